"""Runs: the stages, equilibration and measurement of a scene, with all files in one folder."""

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
from carom._units import units_of

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
    """Runs a scene with all its stages, as ``carom run`` does.

    The function writes the same files as ``carom run``, bit for bit. Other Python threads continue during the
    run. Ctrl-C stops the run, and its files are complete up to that point. :func:`resume` continues the run.

    Parameters
    ----------
    scene : Scene, path or dict
        As for :class:`Scene`.
    out : path, optional
        Folder for the results. By default, they are written to a temporary folder, which is deleted together
        with the :class:`Run`.
    seed, set
        As for :class:`Scene`.
    until_time : float, optional
        Simulated time of the measurement, instead of the limit in the scene `[time]`.
    until_events : int, optional
        Number of physical events in the measurement, instead of the limit in the scene. If both limits are
        given, the run ends at whichever is reached first.
    force : bool
        Whether to replace an existing run in the folder once the new run is complete, and to allow the run to
        write more than 10 GB or a tenth of the free disk space.
    checkpoint_every : float
        Wall time between two checkpoints `[seconds]`.
    threads : int or "auto", optional
        Number of threads, instead of the number in the scene. The results are the same as on one thread, bit
        for bit. ``"auto"`` uses one thread per core, but at most one per 50,000 particles.
    observe : dict of str to callable, optional
        User-defined measurements by name: functions that take a :class:`Frame` and return a number. They are
        called at regular intervals during the final measurement, not during the equilibration or earlier
        stages. :attr:`Run.observables` contains the mean, error and verdict of each function, as computed by
        :func:`mean_and_error`. :attr:`Run.curves` contains its values as a function of time. The functions
        do not change the simulation (not a single bit) or the other files of the run. An exception in a
        function stops the run in the same way as Ctrl-C.
    every : float, optional
        Simulated time between two calls `[time]`; required with ``observe``.
    progress : bool
        Whether to show a progress bar, if tqdm is installed.

    Raises
    ------
    SceneError
        If the scene is invalid.
    FolderError
        If the folder contains something else, another process is writing to it, or a file cannot be written.
    SimulationError
        If the run did not end properly, or its audit failed. ``error.folder`` is the folder with the files,
        if ``out`` was given.
    KeyboardInterrupt
        If Ctrl-C is pressed.

    Examples
    --------
    >>> run = carom.run(fluid)
    >>> print(run.observables["compressibility_factor"])
    3.972 +- 0.025 [1]

    A user-defined measurement, the mean square of one velocity component:

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
    """Resumes a run from its last checkpoint, with the same bits as if it had never stopped.

    Parameters
    ----------
    run : path or Run
        The folder of a run that was interrupted or killed, or of a finished run, which then needs a new
        limit. A :class:`Run` that is passed in keeps the state in which it was opened. The returned
        :class:`Run` has the new state. Both share the same folder, even if the folder is temporary.
    until_time, until_events
        New limits of the measurement, as for :func:`run`.
    force : bool
        Whether to allow the run to write more than 10 GB or a tenth of the free disk space.
    checkpoint_every, threads, observe, every, progress
        As for :func:`run`. A run that was started with ``observe`` needs functions with the same names,
        because its checkpoints contain the values measured so far, but not the functions.

    Raises
    ------
    FolderError
        If there is no run that can be resumed: for example, another version of Carom started the run, or
        one of its input files has changed.
    SimulationError
        As for :func:`run`.

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
    """Returns the folder with the files of a run.

    A run that was meant to replace another run, but did not end properly, stays in a subfolder of the old
    run.
    """
    within = folder / "replacement"
    return within if (within / "summary.json").is_file() else folder


def _ended(run: Run, trouble: str | None, functions: list[tuple[str, Any]], every: float) -> Run:
    if trouble is None:
        uncalled = [name for name, _ in functions if name not in run.observables]
        if uncalled:
            message = f"observe: {', '.join(uncalled)} has no value, because the measurement is shorter than every = {every:g}: choose a smaller every, or run for longer"
            warnings.warn(message, CaromWarning, stacklevel=3)
        return run
    # A temporary folder is deleted after the exception.
    folder = run.folder if run._temporary is None else None
    raise SimulationError(trouble, folder=folder)


class Results:
    """Results of a run, or of one of its stages."""

    _summary: Mapping[str, Any]
    _measured: Mapping[str, Any]
    #: Units of the observables, by name.
    _units: dict[str, str]

    @cached_property
    def observables(self) -> Named[Observable]:
        """Means with standard errors of all observables and of the numbers that instruments report, by name.

        Quantities with an unknown mean are left out.

        Examples
        --------
        >>> run = carom.run(fluid)
        >>> run.observables["temperature"].mean
        1.0
        """
        found: dict[str, Observable] = {}
        for name, it in self._summary["observables"].items():
            verdict = str((it.get("stationarity") or {}).get("verdict"))
            if it["mean"] is not None:
                unit = self._units.get(name, "1")
                found[name] = Observable(it["mean"], it["standard_error"], unit, is_stationary(verdict), verdict == "constant")
        for it in self._measured.get("numbers", []):
            if it["mean"] is not None:
                own = self._number(it)
                # An observable of an instrument may be more precise, but lack a test of stationarity. The verdict of
                # the run is then used.
                known = found.get(it["name"])
                found[it["name"]] = own if known is None or own.is_stationary is not None else replace(own, is_stationary=known.is_stationary)
        run = source(self._summary.get("seed"), self._summary["observables"])
        return Named("observable", {name: measured(source(run, name), it) for name, it in found.items()})

    def _number(self, it: Mapping[str, Any]) -> Observable:
        """Returns a number that an instrument reports.

        For a user-defined measurement, the time series of its values shows whether it is stationary.
        """
        plain = Observable(it["mean"], it["standard_error"], it["unit"])
        series = self.curves.get(it["name"])
        if series is None or list(series.variables) != ["time"] or not np.isfinite(series.y).all():
            return plain
        own = mean_and_error(series.y, it["unit"])
        return own if (own.mean, own.error) == (plain.mean, plain.error) else plain

    @cached_property
    def curves(self) -> Named[Curve]:
        """Curves measured by instruments, by name.

        Examples
        --------
        >>> run = carom.run(fluid, set={"measure.radial_distribution": True})
        >>> list(run.curves)
        ['radial_distribution']
        """
        return Named("curve", {it["name"]: Curve._of(it) for it in self._measured.get("curves", [])})

    @property
    def published(self) -> list[dict[str, Any]]:
        """Published values of the measured quantities, from theory and other simulations.

        Each entry has the keys ``quantity``, ``value``, ``label`` and ``source``.

        Examples
        --------
        >>> z = next(it for it in carom.run(fluid).published if it["quantity"] == "compressibility_factor")
        >>> round(z["value"], 3), z["label"]
        (3.984, 'mKLM')
        """
        return list(self._summary.get("published", []))


class Stage(Results):
    """A measured stage of a run: its name and its results.

    Examples
    --------
    >>> anneal = {**fluid, "stage": [{"name": "warm", "measure": True, "until_events": 5000}]}
    >>> stage = carom.run(anneal).stages[0]
    >>> stage.name, round(stage.observables["temperature"].mean, 9)
    ('warm', 1.0)
    """

    def __init__(self, summary: Mapping[str, Any], measured: Mapping[str, Any], units: dict[str, str]) -> None:
        self._summary, self._measured, self._units = summary, measured, units
        #: Name of the stage in the scene.
        self.name: str = summary["name"]

    def __repr__(self) -> str:
        return f"<Stage {self.name}: {', '.join(self.observables)}>"


class Run(Outputs, InFolder, Results):
    """A run in its folder: parameters, results, trajectory and events. Large data are read on demand.

    A run can be used in a ``with`` statement, which removes a temporary folder at its end. Otherwise, a
    temporary folder is deleted together with the object. A pickled run stores the path of the folder. For a
    temporary folder, it also stores the observables and curves, because the folder still belongs to the
    original object.

    Parameters
    ----------
    folder : path
        The folder of a finished run, made by :func:`run` or by the program.

    Raises
    ------
    FolderError
        If the folder does not contain such a run.

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
        self._units = units_of(self._summary, system.get("dimensions", 3))

    def _open(self) -> Path:
        if self._is_closed:
            raise ValueError("the run is closed, and its temporary folder was removed: pass out= to carom.run to keep the files")
        if not self._folder.is_dir():
            cure = "pass out= to carom.run: a temporary folder is removed together with its run"
            raise FolderError(f"the folder {self._folder} of the run no longer exists\n  help: {cure}", cure=cure)
        return self._folder

    def __getstate__(self) -> dict[str, Any]:
        state = super().__getstate__()
        if self._temporary is not None and not self._is_closed:
            # The pickle contains the measurements, because the temporary folder is not part of it.
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
        """Whether the run ended as the scene specifies, and its audit found no fault.

        Examples
        --------
        >>> carom.run(fluid).is_sound
        True
        """
        good = ("time", "events", "condition", "idle", None)
        return not self._summary["faults"] and self._summary.get("ending") in good

    @cached_property
    def scene(self) -> Scene:
        """The scene that was run, including all changes.

        Raises
        ------
        FolderError
            If the run was made in Rust, from a scene without a scene file.
        SceneError
            If a file that the scene reads no longer exists.

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
        """The scene that was run, as a dictionary with the tables and keys of a scene file.

        The dictionary is empty if the scene was made in code.

        Examples
        --------
        >>> carom.run(fluid).parameters["fill"][0]["packing_fraction"]
        0.3
        """
        path = self._open() / "scene.toml"
        return _carom.parse_toml(path.read_text(encoding="utf-8")) if path.exists() else {}

    def _end(self) -> dict[str, Any]:
        """Returns a scene that continues from the end of the run.

        Everything that this scene leaves out is taken from the run. The volume stays constant, and particles keep
        their species, because only runs have a barostat and swap moves.
        """
        plan = {key: value for key, value in self.parameters.get("run", {"until_events": 1}).items() if "equilibration" not in key and key not in ("barostat", "swap")}
        kept = {key: value for key, value in self.parameters.items() if key in ("name", "surface")}
        return {**kept, "start": {"from": os.path.abspath(self._open())}, "run": plan}

    @cached_property
    def thermo(self) -> Table:
        """The rows of ``thermo.csv``: energies, pressure and more at regular intervals, with units.

        The rows cover all stages.

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
        """The frames of the trajectory. Each frame is read from the file on demand.

        Examples
        --------
        >>> carom.run(fluid).frames[-1].positions.shape
        (108, 3)
        """
        return Trajectory(self._open() / "trajectory.xyz", _owner=self)

    @cached_property
    def events(self) -> EventLog | None:
        """All events, as one memory map per column, or ``None`` if ``output.events`` is not set in the scene.

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
        """The measured stages before the final measurement, in order.

        Examples
        --------
        >>> carom.run(fluid).stages
        []
        """
        measured = {it["name"]: it for it in self._measured.get("stages", [])}
        stages = self._summary.get("stages", [])
        return [Stage(it, measured.get(it["name"], {}), self._units) for it in stages]

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
        """Returns the page of ``carom report`` as self-contained HTML.

        The page shows the results, plots and an animation of the particles.

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
        """Returns all frames as an in-memory ``MDAnalysis.Universe``, at their original times.

        See :meth:`Trajectory.to_mdanalysis`.

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
        """Removes the folder if it is temporary.

        Data that were already read remain available. Access to other data raises ``ValueError``.

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
        return ", interrupted: carom.resume continues it" if self._summary.get("ending") == "interrupted" else ""

    def _repr_html_(self) -> str:
        return framed(self.page())
