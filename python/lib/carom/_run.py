"""Runs: a scene with its stages, its equilibration and its measurement, in a folder with all files."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

import numpy as np

from carom import _carom
from carom._arguments import flag, path_of, real, threads_of, whole
from carom._errors import CaromWarning, FolderError, SimulationError
from carom._folder import InFolder, TemporaryFolder, json_of
from carom._html import framed
from carom._observable import Observable, measured, source
from carom._observe import Functions, observed
from carom._outputs import Outputs
from carom._progress import Progress
from carom._scene import Scene, SceneLike
from carom._statistics import is_stationary, mean_and_error
from carom._tables import Curve, Named, Table
from carom._trajectory import EventLog, Trajectory

__all__ = ["Run", "Stage", "resume", "run"]


def _limits(until_time: Any, until_events: Any) -> tuple[float | None, int | None]:
    time = None if until_time is None else real("until_time", until_time)
    return time, None if until_events is None else whole("until_events", until_events, 1)


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
    threads: int | Literal["auto"] | None = None,
    observe: Functions | None = None,
    every: float | None = None,
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
        Wall time between two checkpoints `[seconds]`.
    threads : int or "auto", optional
        Simulates on so many threads, whatever the scene says, with the same bits as on one; ``"auto"`` takes as many as there are cores, but one for
        each 250,000 particles at most.
    observe : dict of str to callable, optional
        Own measurements by name: functions that take a :class:`Frame` and return a number. They are called at even times of the last measurement,
        not in an equilibration or a stage before it; :attr:`Run.observables` has the mean, the error and the verdict of each, as
        :func:`mean_and_error` finds them, and :attr:`Run.curves` its values along the time. The bits and the other files of the run are the same
        with them and without. An exception in one of them ends the run as Ctrl-C does.
    every : float, optional
        Simulated time between two calls `[time]`; needed with ``observe``.
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
    3.972 +- 0.025 [1]

    A measurement of one's own, the mean square of a component of the velocities:

    >>> run = carom.run(fluid, observe={"vx2": lambda frame: (frame.velocities[:, 0] ** 2).mean()}, every=0.2)
    >>> bool(abs(run.observables["vx2"].mean - 107 / 108) < 5 * run.observables["vx2"].error)
    True
    """
    made = Scene(scene, seed=seed, set=set)
    functions, interval_of_calls = observed(observe, every)
    limits = _limits(until_time, until_events)
    is_forced, interval = flag("force", force), real("checkpoint_every", checkpoint_every)
    on = threads_of(threads)
    folder = None if out is None else path_of("out", out)
    temporary = None
    if folder is None:
        temporary = TemporaryFolder()
        folder = Path(temporary.name) / made.name
    with Progress(progress, made.name) as bar:
        is_temporary = temporary is not None
        trouble = _carom.run(
            made._core, folder, is_forced, interval, *limits, on, functions, interval_of_calls, bar.callback, is_temporary
        )
    return _ended(Run(_written(folder), _temporary=temporary), trouble, functions, interval_of_calls)


def resume(
    run: str | os.PathLike[str] | Run,
    *,
    until_time: float | None = None,
    until_events: int | None = None,
    force: bool = False,
    checkpoint_every: float = 300.0,
    threads: int | Literal["auto"] | None = None,
    observe: Functions | None = None,
    every: float | None = None,
    progress: bool = True,
) -> Run:
    """Goes on with a run from its last checkpoint, to the same bits as if it had never stopped.

    Parameters
    ----------
    run : path or Run
        The folder of a run that was interrupted or killed, or one that is over, with another end. A :class:`Run` is as it was when it was opened, and what comes
        back as it is then; both have the same folder, also if it is a temporary one.
    until_time, until_events
        Another end of the measurement, as for :func:`run`.
    force : bool
        Whether more than a tenth of what is free on the disk, or 10 GB, is written.
    checkpoint_every, threads, observe, every, progress
        As for :func:`run`. A run that was begun with ``observe`` needs the same names: functions are not in its checkpoints, the values so far are.

    Raises
    ------
    FolderError
        If there is no run that can go on: another version of Carom began it, or a file that it reads has changed.
    SimulationError
        As :func:`run`.

    Examples
    --------
    >>> first = carom.run(fluid)
    >>> longer = carom.resume(first, until_events=40_000)
    >>> longer.summary["events"]["total"]
    40000
    """
    temporary = run._temporary if isinstance(run, Run) else None
    path = run.folder if isinstance(run, Run) else path_of("run", run)
    limits = _limits(until_time, until_events)
    is_forced, interval, on = flag("force", force), real("checkpoint_every", checkpoint_every), threads_of(threads)
    functions, interval_of_calls = observed(observe, every)
    with Progress(progress, path.name) as bar:
        is_temporary = temporary is not None
        trouble = _carom.resume(path, is_forced, interval, *limits, on, functions, interval_of_calls, bar.callback, is_temporary)
    return _ended(Run(_written(path), _temporary=temporary), trouble, functions, interval_of_calls)


def _written(folder: Path) -> Path:
    """The folder that a run has written to: one that was to replace another run and did not come to a good end stays within that one's."""
    within = folder / "replacement"
    return within if (within / "summary.json").is_file() else folder


def _ended(run: Run, trouble: str | None, functions: list[tuple[str, Any]], every: float) -> Run:
    if trouble is None:
        uncalled = [name for name, _ in functions if name not in run.observables]
        if uncalled:
            message = f"observe: {', '.join(uncalled)} has no value, because the measurement is shorter than every = {every:g}: give a smaller every, or run for longer"
            warnings.warn(message, CaromWarning, stacklevel=3)
        return run
    # Its files outlive the exception only if the user has named the folder.
    folder = run.folder if run._temporary is None else None
    raise SimulationError(trouble, folder=folder)


class Results:
    """Results of a run, or of one of its stages."""

    _summary: Mapping[str, Any]
    _measured: Mapping[str, Any]
    _dimensions: int

    @cached_property
    def observables(self) -> Named[Observable]:
        """Means with standard errors by name, of the observables and of the numbers that instruments report; those that are not known are left out.

        Examples
        --------
        >>> run = carom.run(fluid)
        >>> run.observables["temperature"].mean
        1.0
        """
        units = _carom.observable_units(self._dimensions)
        found: dict[str, Observable] = {}
        for name, it in self._summary["observables"].items():
            verdict = str((it.get("stationarity") or {}).get("verdict"))
            if it["mean"] is not None:
                unit = units.get(name, "1")
                found[name] = Observable(it["mean"], it["standard_error"], unit, is_stationary(verdict), verdict == "constant")
        for it in self._measured.get("numbers", []):
            if it["mean"] is not None:
                own = self._number(it)
                # An instrument that measures an observable more precisely has no verdict: that of the
                # observable applies to the same time.
                known = found.get(it["name"])
                found[it["name"]] = own if known is None or own.is_stationary is not None else replace(own, is_stationary=known.is_stationary)
        run = source(self._summary.get("seed"), self._summary["observables"])
        return Named("observable", {name: measured(source(run, name), it) for name, it in found.items()})

    def _number(self, it: Mapping[str, Any]) -> Observable:
        """A number that an instrument reports. One of the user's own has its values beside it, which tell whether it is stationary."""
        plain = Observable(it["mean"], it["standard_error"], it["unit"])
        series = self.curves.get(it["name"])
        if series is None or list(series.variables) != ["time"] or not np.isfinite(series.y).all():
            return plain
        own = mean_and_error(series.y, it["unit"])
        return own if (own.mean, own.error) == (plain.mean, plain.error) else plain

    @cached_property
    def curves(self) -> Named[Curve]:
        """Curves that instruments have measured, by name.

        Examples
        --------
        >>> run = carom.run(fluid, set={"measure.radial_distribution": True})
        >>> list(run.curves)
        ['radial_distribution']
        """
        return Named("curve", {it["name"]: Curve._of(it) for it in self._measured.get("curves", [])})

    @property
    def published(self) -> list[dict[str, Any]]:
        """Published values, of theory and other simulations, of the measured quantities: ``quantity``, ``value``, ``label`` and ``source`` of each.

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


class Run(Outputs, InFolder, Results):
    """A run in its folder: parameters, results, trajectory and events. What is large is read when it is asked for.

    It can be used in a ``with`` statement, which removes a temporary folder at its end; otherwise that goes with the object. A run is pickled as its folder,
    with its observables and curves; a temporary folder stays with the object that made it.

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
        _temporary: TemporaryFolder | None = None,
    ) -> None:
        self._temporary = _temporary
        self._is_closed = False
        self._folder = path_of("folder", folder)
        self._summary = Named("entry", json_of(self._folder / "summary.json"))
        system = self._summary.get("system") or {}
        self._dimensions = system.get("dimensions", 3)

    def _open(self) -> Path:
        if self._is_closed:
            raise ValueError("the run is closed, and its temporary folder is gone: give carom.run an out to keep the files")
        if not self._folder.is_dir():
            cure = "give carom.run an out: a temporary folder goes with the run that made it"
            raise FolderError(f"the folder {self._folder} of the run is gone\n  help: {cure}", cure=cure)
        return self._folder

    def __getstate__(self) -> dict[str, Any]:
        state = super().__getstate__()
        if self._temporary is not None and not self._is_closed:
            # Data that vanish with the folder.
            state["_measured"] = self._measured
        return state

    @cached_property
    def _measured(self) -> Mapping[str, Any]:  # type: ignore[override]
        path = self._open() / "measurements.json"
        return json_of(path) if path.exists() else {}

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

    def _end(self) -> dict[str, Any]:
        """The scene that goes on from the end of the run: what it leaves out is as it was in the run. The volume stays: only runs have a barostat."""
        plan = {key: value for key, value in self.parameters.get("run", {"until_events": 1}).items() if "equilibration" not in key and key != "barostat"}
        kept = {key: value for key, value in self.parameters.items() if key in ("name", "surface")}
        return {**kept, "start": {"from": os.path.abspath(self._open())}, "run": plan}

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
        """All frames as an ``MDAnalysis.Universe``, in memory, at their own times; see :meth:`Trajectory.to_mdanalysis`.

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
        lines = [f"<Run of {self._summary['scene']}, seed {self._summary['seed']}: {self._summary['events']['total']} events{self._unfinished()}"]
        lines += [f"  {name} = {it}" for name, it in self.observables.items()]
        return "\n".join(lines) + ">"

    def _unfinished(self) -> str:
        return ", interrupted: carom.resume goes on" if self._summary.get("ending") == "interrupted" else ""

    def _repr_html_(self) -> str:
        return framed(self.page())
