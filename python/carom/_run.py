"""Runs: a scene with its stages, its equilibration and its measurement, in a folder with all files."""

from __future__ import annotations

import html
import json
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from types import TracebackType
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from carom import _carom
from carom._errors import FolderError, SimulationError
from carom._frame import Frame, universe_of
from carom._scene import Scene, SceneLike, whole
from carom._simulation import EVENT_KINDS
from carom._tables import Curve, Observable, Table

__all__ = ["Run", "Stage", "Trajectory", "resume", "run"]

PathLike = "str | os.PathLike[str]"


class Progress:
    """A bar of tqdm, where that is installed and wanted: on a terminal, and in notebooks with widgets. In files of output it would be a line for each state."""

    #: What is counted, where that is not events.
    COUNTED = {"sweeping": "runs done", "exchanging": "attempts"}

    def __init__(self, wanted: bool, title: str) -> None:
        self._bar: Any = None
        self._stage = ""
        kind = _kind_of_bar() if wanted else None
        if kind is not None:
            form = "{desc} {percentage:3.0f} %|{bar}|{postfix}, {remaining} left"
            self._bar = kind(total=1.0, desc=title, bar_format=form, leave=False, delay=0.5)

    @property
    def callback(self) -> Callable[[str, float, float, int], None] | None:
        """What the compiled part calls, if there is anything to show."""
        return None if self._bar is None else self._see

    def _see(self, stage: str, fraction: float, time: float, events: int) -> None:
        bar = self._bar
        if stage != self._stage:
            self._stage = stage
            bar.reset(total=1.0)
        bar.n = min(fraction, 1.0)
        words = f"{stage}, {events} {self.COUNTED.get(stage, 'events')}"
        bar.set_postfix_str(words if not time else f"{words}, t = {time:.4g}", refresh=False)
        bar.refresh()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()


def _kind_of_bar() -> Any:
    is_notebook = "ipykernel" in sys.modules and find_spec("ipywidgets") is not None
    if find_spec("tqdm") is None or not (is_notebook or sys.stderr.isatty()):
        return None
    if is_notebook:
        from tqdm.notebook import tqdm
    else:
        from tqdm.std import tqdm
    return tqdm


def path_of(name: str, path: Any) -> Path:
    """A path of an argument."""
    if not isinstance(path, (str, os.PathLike)):
        raise TypeError(f"{name}: expected a path, found {type(path).__name__}")
    if "\0" in os.fspath(path):
        raise ValueError(f"{name}: a path has no character of the number 0")
    return Path(path)


def _limits(until_time: Any, until_events: Any) -> tuple[float | None, int | None]:
    if until_time is not None:
        if isinstance(until_time, bool) or not isinstance(until_time, (int, float, np.number)):
            raise TypeError(f"until_time: expected a number, found {until_time!r}")
        until_time = float(until_time)
    return until_time, None if until_events is None else whole("until_events", until_events, 1)


def run(
    scene: SceneLike,
    out: str | os.PathLike[str] | None = None,
    *,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    until_time: float | None = None,
    until_events: int | None = None,
    force: bool = False,
    checkpoint_every: float = 300.0,
    progress: bool = True,
) -> Run:
    """Runs a scene with all that it plans, as ``carom run`` does: the same files, the same bits.

    While it runs, other threads of Python run. Ctrl-C ends it with complete files up to there; :func:`resume` goes on.

    Parameters
    ----------
    scene : Scene, path or dict
        As for :class:`Scene`.
    out : path, optional
        Folder of the results. Without one they are in a temporary folder, which goes with the :class:`Run`.
    seed, set
        As for :class:`Scene`.
    until_time : float, optional
        Measures for this simulated time, whatever the scene says `[time]`.
    until_events : int, optional
        Measures for this many physical events, whatever the scene says; the first of the two ends the run.
    force : bool
        Whether a run that is in the folder is replaced when the new one is complete, and more than 10 GB are written.
    checkpoint_every : float
        Time on the clock between two checkpoints `[seconds]`.
    progress : bool
        Whether a bar is shown, where tqdm is installed.

    Raises
    ------
    SceneError
        If the scene is wrong.
    FolderError
        If the folder holds something else, another process writes there, or a file cannot be written.
    SimulationError
        If the run came to no good end, or its audit failed; ``error.folder`` has the files.
    KeyboardInterrupt
        At Ctrl-C.

    Examples
    --------
    >>> run = carom.run(fluid)
    >>> print(run.observables["compressibility_factor"])
    3.977 +- 0.023 [1]
    """
    made = Scene(scene, seed=seed, set=set)
    limits = _limits(until_time, until_events)
    folder = None if out is None else path_of("out", out)
    temporary = None
    if folder is None:
        temporary = tempfile.TemporaryDirectory(prefix="carom-")
        folder = Path(temporary.name) / made.name
    with Progress(progress, made.name) as bar:
        trouble = _carom.run(made._core, folder, bool(force), float(checkpoint_every), *limits, bar.callback)
    return _ended(Run(folder, _temporary=temporary), trouble)


def resume(
    folder: str | os.PathLike[str],
    *,
    until_time: float | None = None,
    until_events: int | None = None,
    checkpoint_every: float = 300.0,
    progress: bool = True,
) -> Run:
    """Goes on with a run from its last checkpoint, to the same bits as if it had never stopped.

    Parameters
    ----------
    folder : path
        The folder of a run that was interrupted or killed, or one that is over, with another end.
    until_time, until_events
        Another end of the measurement, as for :func:`run`.
    checkpoint_every, progress
        As for :func:`run`.

    Raises
    ------
    FolderError
        If there is no run that can go on: another version of Carom began it, or a file that it reads has changed.
    SimulationError
        As :func:`run`.

    Examples
    --------
    >>> first = carom.run(fluid)
    >>> longer = carom.resume(first.folder, until_events=40_000)
    >>> longer.summary["events"]["total"]
    40000
    """
    path = path_of("folder", folder)
    limits = _limits(until_time, until_events)
    with Progress(progress, path.name) as bar:
        trouble = _carom.resume(path, float(checkpoint_every), *limits, bar.callback)
    return _ended(Run(path), trouble)


def _ended(run: Run, trouble: str | None) -> Run:
    if trouble is None:
        return run
    # Its files outlive the exception only where the user has named the folder.
    folder = run.folder if run._temporary is None else None
    raise SimulationError(trouble, folder=folder)


class Results:
    """What was measured: of a run, or of one of its stages."""

    _summary: Mapping[str, Any]
    _measured: Mapping[str, Any]
    _dimensions: int

    @cached_property
    def observables(self) -> dict[str, Observable]:
        """Means with standard errors by name, of the observables and of the numbers that instruments report; those that are not known are left out.

        Examples
        --------
        >>> run = carom.run(fluid)
        >>> run.observables["temperature"].mean
        1.0
        """
        units = _carom.observable_units(self._dimensions)
        found = {}
        for name, it in self._summary["observables"].items():
            verdict = str((it.get("stationarity") or {}).get("verdict"))
            stationary = {"stationary": True, "constant": True, "drifting": False}.get(verdict)
            if it["mean"] is not None:
                found[name] = Observable(it["mean"], it["standard_error"], units.get(name, "1"), stationary)
        for it in self._measured.get("numbers", []):
            if it["mean"] is not None:
                found[it["name"]] = Observable(it["mean"], it["standard_error"], it["unit"])
        return found

    @cached_property
    def curves(self) -> dict[str, Curve]:
        """What instruments have measured as functions, by name.

        Examples
        --------
        >>> run = carom.run(fluid, set={"measure.radial_distribution": True})
        >>> list(run.curves)
        ['radial_distribution']
        """
        return {it["name"]: Curve._of(it) for it in self._measured.get("curves", [])}

    @property
    def published(self) -> list[dict[str, Any]]:
        """What theory and other simulations say of what was measured: ``quantity``, ``value``, ``label`` and ``source`` of each.

        Examples
        --------
        >>> z = next(it for it in carom.run(fluid).published if it["quantity"] == "compressibility_factor")
        >>> round(z["value"], 3), z["label"]
        (3.984, 'mKLM')
        """
        return list(self._summary.get("published", []))


class Stage(Results):
    """A measured stage of a run: its name and what was measured in it.

    Examples
    --------
    >>> anneal = {**fluid, "stage": [{"name": "warm", "measure": True, "until_events": 5000}]}
    >>> stage = carom.run(anneal).stages[0]
    >>> stage.name, round(stage.observables["temperature"].mean, 9)
    ('warm', 1.0)
    """

    def __init__(self, summary: Mapping[str, Any], measured: Mapping[str, Any], dimensions: int) -> None:
        self._summary, self._measured, self._dimensions = summary, measured, dimensions
        #: Its name in the scene.
        self.name: str = summary["name"]

    def __repr__(self) -> str:
        return f"<Stage {self.name}: {', '.join(self.observables)}>"


class Run(Results):
    """A run in its folder: parameters, results, trajectory and events. What is large is read when it is asked for.

    It can be used in a ``with`` statement, which removes a temporary folder at its end; otherwise that goes with the object.

    Parameters
    ----------
    folder : path
        The folder of a run that is over, made by :func:`run` or by the program.

    Raises
    ------
    FolderError
        If there is no such run.

    Examples
    --------
    >>> run = carom.run(fluid)
    >>> run.is_sound, len(run.frames)
    (True, 6)
    """

    def __init__(
        self,
        folder: str | os.PathLike[str],
        *,
        _temporary: tempfile.TemporaryDirectory[str] | None = None,
    ) -> None:
        self._temporary = _temporary
        self._is_closed = False
        self._folder = path_of("folder", folder)
        self._summary = _json(self._folder / "summary.json")
        system = self._summary.get("system") or {}
        self._dimensions = system.get("dimensions", 3)

    def _open(self) -> Path:
        if self._is_closed:
            raise ValueError("the run is closed, and its temporary folder is gone: give carom.run an out to keep the files")
        return self._folder

    @cached_property
    def _measured(self) -> Mapping[str, Any]:  # type: ignore[override]
        path = self._open() / "measurements.json"
        return _json(path) if path.exists() else {}

    @property
    def folder(self) -> Path:
        """The folder with all files of the run.

        Raises
        ------
        ValueError
            If the run is closed.

        Examples
        --------
        >>> run = carom.run(fluid)
        >>> sorted(path.name for path in run.folder.glob("*.json"))
        ['summary.json']
        """
        return self._open()

    @property
    def summary(self) -> Mapping[str, Any]:
        """Content of ``summary.json``: counts of events, energies, overlaps, the box, and the speed of the run.

        Examples
        --------
        >>> carom.run(fluid).summary["events"]["core"]
        20000
        """
        return self._summary

    @property
    def is_sound(self) -> bool:
        """Whether it came to an end that the scene asks for, and its audit has nothing to object to.

        Examples
        --------
        >>> carom.run(fluid).is_sound
        True
        """
        good = ("time", "events", "condition", "idle", None)
        return not self._summary["faults"] and self._summary.get("ending") in good

    @cached_property
    def scene(self) -> Scene:
        """The scene as it was run.

        Raises
        ------
        FolderError
            If the run was made in Rust, from a scene without a text.
        SceneError
            If a file that it reads is gone.

        Examples
        --------
        >>> carom.run(fluid, seed=5).scene.seed
        5
        """
        path = self._open() / "scene.toml"
        if not path.exists():
            raise FolderError(f"{self._folder} has no scene.toml: its scene was made in code")
        return Scene(path)

    @cached_property
    def parameters(self) -> dict[str, Any]:
        """The scene as it was run, as a dictionary with the tables and keys of a scene file; empty where it was made in code.

        Examples
        --------
        >>> carom.run(fluid).parameters["fill"][0]["packing_fraction"]
        0.3
        """
        path = self._open() / "scene.toml"
        return _carom.parse_toml(path.read_text(encoding="utf-8")) if path.exists() else {}

    @cached_property
    def thermo(self) -> Table:
        """Rows of ``thermo.csv``: energies, pressure and more at even times, of all stages, with units.

        Examples
        --------
        >>> thermo = carom.run(fluid).thermo
        >>> thermo["kinetic"].shape == thermo["time"].shape
        True
        """
        columns = self._summary.get("columns", {}).get("thermo.csv", [])
        return Table.read(self._open() / "thermo.csv", {it["name"]: it["unit"] for it in columns})

    @cached_property
    def frames(self) -> Trajectory:
        """The frames, each read from the file when it is asked for.

        Examples
        --------
        >>> carom.run(fluid).frames[-1].positions.shape
        (108, 3)
        """
        return Trajectory(self._open() / "trajectory.xyz", _owner=self)

    @cached_property
    def events(self) -> EventLog | None:
        """All events, as memory maps by column, where the scene asks for them with ``output.events``; otherwise ``None``.

        Examples
        --------
        >>> run = carom.run(fluid, set={"output.events": True})
        >>> len(run.events["time"])
        20000
        """
        folder = self._open() / "events"
        return EventLog(folder, self) if folder.is_dir() else None

    @cached_property
    def stages(self) -> list[Stage]:
        """The measured stages before the last measurement, in their order.

        Examples
        --------
        >>> carom.run(fluid).stages
        []
        """
        measured = {it["name"]: it for it in self._measured.get("stages", [])}
        stages = self._summary.get("stages", [])
        return [Stage(it, measured.get(it["name"], {}), self._dimensions) for it in stages]

    @property
    def report(self) -> str:
        """The final table, as the program prints it.

        Examples
        --------
        >>> carom.run(fluid).report.splitlines()[0].split()
        ['scene', 'fluid,', 'seed', '1']
        """
        return (self._open() / "report.txt").read_text(encoding="utf-8")

    def page(self) -> str:
        """The page of ``carom report`` as HTML, with results, plots and the moving particles; it needs no other file.

        Raises
        ------
        FolderError
            If a file of the run is damaged.

        Examples
        --------
        >>> "<!DOCTYPE html>" in carom.run(fluid).page()
        True
        """
        return _carom.page(self._open())

    def to_mdanalysis(self) -> Any:
        """All frames as an ``MDAnalysis.Universe``, in memory.

        Raises
        ------
        ImportError
            If MDAnalysis is not installed.

        Examples
        --------
        >>> carom.run(fluid).to_mdanalysis().trajectory.n_frames  # doctest: +MDANALYSIS
        6
        """
        return self.frames.to_mdanalysis()

    def close(self) -> None:
        """Removes the folder, if it is a temporary one. What has been read stays; all else raises ``ValueError``.

        Examples
        --------
        >>> run = carom.run(fluid)
        >>> run.close()
        """
        if self._temporary is not None:
            self._is_closed = True
            self._temporary.cleanup()

    def __enter__(self) -> Run:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        lines = [f"<Run of {self._summary['scene']}, seed {self._summary['seed']}: {self._summary['events']['total']} events"]
        lines += [f"  {name} = {it}" for name, it in self.observables.items()]
        return "\n".join(lines) + ">"

    def _repr_html_(self) -> str:
        return framed(self.page())


def framed(page: str, height: int = 700) -> str:
    """A page in a cell of a notebook."""
    style = f"width:100%;height:{height}px;border:0"
    return f'<iframe srcdoc="{html.escape(page)}" style="{style}" sandbox="allow-scripts"></iframe>'


class Trajectory(Sequence[Frame]):
    """The frames of a trajectory file, each read when it is asked for. The file is passed over once, for where they are.

    Parameters
    ----------
    path : path
        A file in extended XYZ, such as the ``trajectory.xyz`` of a run. A last frame that is cut off, as by a kill, is left out.

    Raises
    ------
    FolderError
        If the file cannot be read, or is no trajectory.

    Examples
    --------
    >>> run = carom.run(fluid, set={"output.frame_interval": 0.1})
    >>> [round(frame.time, 1) for frame in run.frames[-3:]] == [round(t, 1) for t in run.frames.times[-3:]]
    True
    """

    def __init__(self, path: str | os.PathLike[str], *, _owner: Any = None) -> None:
        self._path = path_of("path", path)
        # Keeps a temporary folder.
        self._owner = _owner
        self._core = _carom.Trajectory(self._path)

    def __len__(self) -> int:
        return len(self._core)

    @overload
    def __getitem__(self, at: int) -> Frame: ...
    @overload
    def __getitem__(self, at: slice) -> list[Frame]: ...
    def __getitem__(self, at: int | slice) -> Frame | list[Frame]:
        if isinstance(at, slice):
            return [self[place] for place in range(*at.indices(len(self)))]
        place = at.__index__()
        if not -len(self) <= place < len(self):
            raise IndexError(f"frame {place} of {len(self)}")
        return Frame._of(self._core.frame(place % len(self)))

    @cached_property
    def times(self) -> NDArray[np.float64]:
        """Simulated time of each frame `[time]`, of the shape ``(frames,)``; reads them all once.

        Examples
        --------
        >>> carom.run(fluid).frames.times.shape
        (6,)
        """
        return np.array([frame.time for frame in self])

    def positions(self, *, unwrapped: bool = True) -> NDArray[np.float64]:
        """Positions in all frames `[length]`, of the shape ``(frames, n, 3)``.

        Parameters
        ----------
        unwrapped : bool
            Whether particles go on beyond the sides of a periodic box, as for displacements; otherwise they are within it.

        Raises
        ------
        ValueError
            If frames have different particles, or images are asked for and not known.

        Examples
        --------
        The mean squared displacement between the first and the last frame:

        >>> r = carom.run(fluid).frames.positions()
        >>> float(((r[-1] - r[0]) ** 2).sum(axis=1).mean()) > 1.0
        True
        """
        return self._stacked("unwrapped" if unwrapped else "positions")

    def velocities(self) -> NDArray[np.float64]:
        """Velocities in all frames `[length / time]`, of the shape ``(frames, n, 3)``.

        Raises
        ------
        ValueError
            If frames have different particles.

        Examples
        --------
        >>> carom.run(fluid).frames.velocities().shape
        (6, 108, 3)
        """
        return self._stacked("velocities")

    def _stacked(self, name: str) -> NDArray[np.float64]:
        stacked: NDArray[np.float64] | None = None
        ids: NDArray[np.uint32] | None = None
        for at, frame in enumerate(self):
            values = getattr(frame, name)
            if stacked is None or ids is None:
                stacked, ids = np.empty((len(self), *values.shape)), frame.ids
            if len(frame.ids) != len(ids) or (frame.ids != ids).any():
                raise ValueError(f"frame {at} has other particles than the first one: go through the frames one by one")
            stacked[at] = values
        return np.empty((0, 0, 3)) if stacked is None else stacked

    def to_mdanalysis(self) -> Any:
        """All frames as an ``MDAnalysis.Universe``, in memory.

        Raises
        ------
        ImportError
            If MDAnalysis is not installed.
        ValueError
            If frames have different particles, or there are none.

        Examples
        --------
        >>> carom.run(fluid).frames.to_mdanalysis().trajectory.n_frames  # doctest: +MDANALYSIS
        6
        """
        if not len(self):
            raise ValueError(f"{self._path} has no frames")
        return universe_of(list(self))

    def __iter__(self) -> Iterator[Frame]:
        return (self[at] for at in range(len(self)))

    def __repr__(self) -> str:
        return f"<Trajectory of {len(self)} frames>"


class EventLog(Mapping[str, NDArray[Any]]):
    """All events of a run, by column: memory maps of the files in the folder ``events``, one entry per event in the order of time.

    The columns are those of :meth:`Simulation.events`, with the same units, but for ``impulse``, ``distance`` and ``normal``.

    Raises
    ------
    FolderError
        If a file cannot be read.

    Examples
    --------
    >>> run = carom.run(fluid, set={"output.events": True})
    >>> run.events["positions"].shape, carom.EVENT_KINDS[run.events["kind"][0]]
    ((20000, 2, 3), 'core')
    """

    COLUMNS = (
        "time",
        "kind",
        "particle",
        "partner",
        "positions",
        "velocities_before",
        "velocities_after",
        "energy_step",
        "dissipated",
    )
    #: Kinds by number.
    KINDS = EVENT_KINDS

    def __init__(self, folder: Path, owner: Any = None) -> None:
        self._folder = folder
        self._owner = owner

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self.COLUMNS:
            raise KeyError(f"no column {name!r}; there are {', '.join(self.COLUMNS)}")
        path = self._folder / f"{name}.npy"
        try:
            column: NDArray[Any] = np.load(path, mmap_mode="r")
        except ValueError:
            # There is nothing to map where there are no events.
            column = np.load(path)
        except OSError as error:
            raise FolderError(f"cannot read {path}: {error}") from error
        return column

    def __iter__(self) -> Iterator[str]:
        return iter(self.COLUMNS)

    def __len__(self) -> int:
        return len(self.COLUMNS)

    def __repr__(self) -> str:
        return f"<EventLog of {len(self['time'])} events: {', '.join(self.COLUMNS)}>"


def _json(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        cure = "go on with carom.resume where a run was killed"
        raise FolderError(f"cannot read {path}: {error}\n  help: {cure}", cure=cure) from error
    if not isinstance(content, dict):
        raise FolderError(f"{path} is no file of Carom")
    return content
