"""Parameter sweeps: one run of a scene for each combination of values, in threads or on an executor."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Executor, as_completed
from functools import cached_property
from pathlib import Path
from typing import Any, Union

import numpy as np

from carom import _carom
from carom._arguments import flag, path_of, real, shown, whole
from carom._errors import CaromWarning, FolderError, SweepError
from carom._folder import json_of
from carom._html import framed
from carom._observe import Functions, observed
from carom._progress import Progress
from carom._run import Run
from carom._scene import Scene, SceneLike, overrides
from carom._tables import Table

__all__ = ["Sweep", "sweep"]

#: Functions of a frame, and the time between two calls.
_Observed = tuple[Union[Functions, None], Union[float, None]]

#: Number of significant digits of floating-point values, as in the ranges of the program.
_DIGITS = 12


def sweep(
    scene: SceneLike,
    vary: Mapping[Any, Any] | None = None,
    seeds: int | Iterable[int] | None = None,
    out: str | os.PathLike[str] | None = None,
    *,
    executor: Executor | None = None,
    jobs: int | None = None,
    set: Mapping[str, Any] | None = None,
    force: bool = False,
    checkpoint_every: float = 300.0,
    observe: Functions | None = None,
    every: float | None = None,
    progress: bool = True,
) -> Sweep:
    """Runs a scene for all combinations of values, like ``carom sweep``, and skips runs that are complete.

    The function and the program use the same folder. Either can resume an interrupted sweep, no matter which
    of the two started it. Interrupted runs resume from their checkpoints, and the results are bit-identical.
    A sweep can be extended by more values and seeds.

    Parameters
    ----------
    scene : path, dict or Scene
        As for :class:`Scene`.
    vary : dict
        Maps keys of the scene to their values: a list, an array, or a string in the syntax of ``--vary``,
        such as ``"0.05..0.49/12"``. Numbers are written with 12 digits. To change several values together,
        give a tuple of keys and a list of tuples.
    seeds : int or list of int, optional
        Repetitions of each state point: their number ``n``, for the seeds 1 to ``n``, or a list of seeds.
        Means are averages over the seeds.
    out : path, optional
        The folder of the sweep; ``runs/NAME-sweep`` if not given. Other processes and machines that take part
        must be able to access the folder under the same path.
    executor : concurrent.futures.Executor, optional
        The executor that runs the points, such as ``ProcessPoolExecutor``, ``MPIPoolExecutor`` of mpi4py or
        ``client.get_executor()`` of Dask. Each point is a separate task. If a worker is lost and its task is
        run again, the task resumes from the last checkpoint. If no executor is given, the points run in
        threads of this process.
    jobs : int, optional
        Number of threads without an executor; the number of processors if not given.
    set : dict, optional
        Values of the scene to replace at all points, as for :class:`Scene`.
    force : bool
        Whether the sweep may write more than 10 GB in total, or more than a tenth of the free disk space.
    observe, every
        User-defined measurements at all points, as for :func:`run`. Their results also appear in the tables
        and on the page of the sweep. Without an executor, several threads call the functions, one at a time.
        With an executor, the functions must be sent to its workers: processes accept functions of a module,
        and Dask accepts any function. An exception in a function ends the sweep; the same call resumes the
        sweep.
    checkpoint_every, progress
        As for :func:`run`.

    Raises
    ------
    SweepError
        If an axis is invalid, the folder contains a different sweep, or the folder contains complete runs
        that lack measurements in ``observe``.
    SceneError
        If a key or a value is invalid.
    FolderError
        If the folder contains something else, or the files would be too large.

    Warns
    -----
    CaromWarning
        If runs have failed. :attr:`Sweep.failures` contains the reasons. The other runs are complete. Also if
        a measurement in ``observe`` has no value in some runs, because their measurements are shorter than
        ``every``.

    Examples
    --------
    >>> result = carom.sweep(fluid, {"fill.0.packing_fraction": [0.1, 0.2]}, seeds=2, out="sweep")
    >>> result.mean["packing_fraction"], result.mean["runs"]
    (array([0.1, 0.2]), array([2, 2]))
    >>> z = result.mean["compressibility_factor"]
    >>> bool(abs(z[1] - 2.4) < 0.1)
    True
    """
    orders = (flag("force", force), real("checkpoint_every", checkpoint_every))
    observed(observe, every)
    functions: _Observed = (observe, every)
    axes = [_axis(key, values) for key, values in (vary or {}).items()]
    if seeds is not None:
        if isinstance(seeds, Iterable):
            numbers = [whole("seeds", seed) for seed in seeds]
        else:
            numbers = list(range(1, whole("seeds", seeds, 1) + 1))
        axes.append("seed=" + ",".join(str(number) for number in numbers))
    if isinstance(scene, (str, os.PathLike)) and not (isinstance(scene, str) and "\n" in scene):
        path = Path(scene)
        core = _carom.Sweep(path, None, overrides(None, set), axes)
        name = path.stem
    else:
        made = Scene(scene)
        core = _carom.Sweep(Path(f"{made.name}.toml"), made.to_toml(), overrides(None, set), axes)
        name = made.name
    folder = Path("runs") / f"{name}-sweep" if out is None else path_of("out", out)
    folder = Path(os.path.abspath(folder))
    core.check(folder, orders[0])
    core.begin(folder)
    _refuse_unobserved(core, folder, observe or {})
    if executor is None:
        threads = (os.cpu_count() or 1) if jobs is None else whole("jobs", jobs, 1)
        with Progress(progress, name) as bar:
            try:
                core.run_all(folder, threads, (orders, observed(*functions)), bar.callback)
            except BaseException:
                # Updates the tables with all finished points. Repeating the call continues the sweep.
                core.write(folder)
                raise
    else:
        if jobs is not None:
            raise ValueError("jobs: is the number of threads of this process; an executor has its own number of workers")
        _submit(core, folder, executor, (orders, functions), progress, name)
    return _finished(core, folder, functions)


def _text(key: str, value: Any) -> str:
    """A value of an axis, in the syntax of the command line."""
    if isinstance(value, str):
        plain = value.replace("-", "").replace("_", "").replace(".", "").isalnum() and ".." not in value
        # Keeps the quotes of a text such as "1e5", which would otherwise become a number.
        return value if plain and isinstance(_value(value), str) else _carom.Scene.value_of(value, key)
    if isinstance(value, (float, np.floating)) and not isinstance(value, bool):
        number = float(value)
        if not np.isfinite(number):
            raise ValueError(f"vary: {key} is {number}, expected a finite number")
        return f"{number:.{_DIGITS}g}"
    return _carom.Scene.value_of(value, key)


def _axis(keys: Any, values: Any) -> str:
    """An axis, in the syntax of the command line."""
    if isinstance(keys, str):
        if isinstance(values, str):
            return f"{keys}={values}"
        if isinstance(values, Mapping) or not hasattr(values, "__iter__"):
            raise TypeError(f"vary: {keys} is {shown(values)}, expected a list of values, or text such as '0.1..0.5/9'")
        texts = [_text(keys, value) for value in values]
        if not texts:
            raise ValueError(f"vary: {keys} has no values")
        return f"{keys}=" + ",".join(texts)
    if not isinstance(keys, tuple) or not all(isinstance(key, str) for key in keys):
        raise TypeError(f"vary: expected keys that are strings, or tuples of them, found {shown(keys)}")
    rows = [tuple(row) for row in values]
    if not rows:
        raise ValueError(f"vary: {', '.join(keys)} have no values")
    if any(len(row) != len(keys) for row in rows):
        raise ValueError(f"vary: {', '.join(keys)} change together: expected a list of tuples, each with one value for each key")
    columns = zip(keys, zip(*rows))
    return "; ".join(f"{key}=" + ",".join(_text(key, value) for value in column) for key, column in columns)


def _refuse_unobserved(core: _carom.Sweep, folder: Path, observe: Functions) -> None:
    """Rejects functions that a complete run did not evaluate, because complete runs are not repeated."""
    if not observe:
        return
    for name, numbers in _numbers(core, folder):
        missing = [each for each in observe if each not in numbers]
        if missing:
            cure = "choose another out, or remove the folder of that run"
            raise SweepError(f"{folder / name} was run without {', '.join(missing)} in observe\n  help: {cure}", cure=cure)


def _numbers(core: _carom.Sweep, folder: Path) -> Iterator[tuple[str, dict[str, float | None]]]:
    """Yields the name of each complete run, and a dictionary of its measured numbers."""
    for name in [point for point, state, _ in core.standing(folder) if state == "done"]:
        path = folder / name / "measurements.json"
        numbers = json_of(path).get("numbers", []) if path.exists() else []
        yield name, {number["name"]: number["mean"] for number in numbers}


def _point(folder: str, name: str, orders: tuple[bool, float], functions: _Observed) -> tuple[str, str | None]:
    """Runs a point of the sweep as a task of an executor. The task reads the sweep from its folder."""
    return _carom.Sweep.open(Path(folder)).run_point(Path(folder), name, (orders, observed(*functions)))


def _submit(
    core: _carom.Sweep,
    folder: Path,
    executor: Executor,
    orders: tuple[tuple[bool, float], _Observed],
    progress: bool,
    name: str,
) -> None:
    if not hasattr(executor, "submit"):
        cure = "such as client.get_executor() of a Dask client" if hasattr(executor, "get_executor") else "such as ProcessPoolExecutor()"
        raise TypeError(f"executor: expected a concurrent.futures.Executor, {cure}")
    if not isinstance(executor, Executor):
        raise TypeError("executor: expected a concurrent.futures.Executor; for Dask, pass client.get_executor()")
    standing = core.standing(folder)
    missing = [point for point, state, _ in standing if state != "done"]
    over = len(standing) - len(missing)
    futures = [executor.submit(_point, str(folder), point, *orders) for point in missing]
    lost: BaseException | None = None
    with Progress(progress, name) as bar:
        try:
            for future in as_completed(futures):
                error = future.exception()
                lost = lost or error
                over += error is None
                if bar.callback is not None:
                    bar.callback("sweeping", over / max(1, len(standing)), 0.0, over)
        except BaseException:
            for future in futures:
                future.cancel()
            raise
    if lost is not None:
        core.write(folder)
        raise lost


def _finished(core: _carom.Sweep, folder: Path, functions: _Observed) -> Sweep:
    core.write(folder)
    result = Sweep(folder, _core=core)
    observe, every = functions
    if observe:
        runs = list(_numbers(core, folder))
        for each in observe:
            empty = sum(numbers.get(each) is None for _, numbers in runs)
            if empty:
                of = f"{empty} of {len(runs)} runs"
                message = f"observe: {each} has no value in {of}, whose measurements are shorter than every = {every:g}: choose a smaller every, or run for longer"
                warnings.warn(message, CaromWarning, stacklevel=3)
    if result.failures:
        lines = [f"{name}: {why}" for name, why in result.failures.items()]
        message = f"{len(lines)} of {len(result.points)} runs failed:\n" + "\n".join(lines)
        warnings.warn(message, CaromWarning, stacklevel=3)
    return result


class Sweep:
    """A sweep in its folder, with its points, their runs and the tables of all runs.

    Parameters
    ----------
    folder : path
        The folder of a sweep made by :func:`sweep` or by the program. The sweep may still be running.

    Raises
    ------
    FolderError, SweepError
        If the folder contains no sweep, or the scene of the sweep has changed.

    Examples
    --------
    >>> result = carom.sweep(fluid, {"fill.0.packing_fraction": [0.1, 0.2]}, seeds=2, out="sweep")
    >>> result
    <Sweep of packing_fraction, seed: 4 points, 4 done>
    >>> result.points[1]
    {'fill.0.packing_fraction': 0.1, 'seed': 2}
    """

    def __init__(self, folder: str | os.PathLike[str], *, _core: _carom.Sweep | None = None) -> None:
        #: The folder.
        self.folder: Path = path_of("folder", folder)
        if not (self.folder / "sweep.toml").exists():
            raise FolderError(f"{self.folder} is not the folder of a sweep: it has no sweep.toml")
        self._core = _core or _carom.Sweep.open(self.folder)
        self._standing = self._core.standing(self.folder)

    def __reduce__(self) -> Any:
        return Sweep, (Path(os.path.abspath(self.folder)),)

    @cached_property
    def points(self) -> list[dict[str, Any]]:
        """Keys and values of each point, in the order of the tables. The last key varies fastest.

        Examples
        --------
        >>> carom.sweep(fluid, seeds=2, out="seeds").points
        [{'seed': 1}, {'seed': 2}]
        """
        return [{key: _value(text) for key, text in settings} for _, settings in self._core.points()]

    @property
    def runs(self) -> list[Run | None]:
        """The run of each point; ``None`` for a run that is not complete.

        Examples
        --------
        >>> [run.is_sound for run in carom.sweep(fluid, seeds=2, out="seeds").runs]
        [True, True]
        """
        return [Run(self.folder / name) if state == "done" else None for name, state, _ in self._standing]

    @property
    def failures(self) -> dict[str, str]:
        """Reasons why runs failed, by the name of the folder of the run.

        Examples
        --------
        >>> carom.sweep(fluid, seeds=2, out="seeds").failures
        {}
        """
        return {name: why or "" for name, state, why in self._standing if state == "failed"}

    @cached_property
    def _units(self) -> dict[str, str]:
        table = Table.read(self.folder / "sweep-columns.csv")
        return dict(zip(table["column"].tolist(), table["unit"].tolist()))

    @property
    def table(self) -> Table:
        """Table ``sweep.csv``, with one row for each run.

        The columns contain the varied values and each quantity ``x`` with its standard error ``x_error``.

        Examples
        --------
        >>> carom.sweep(fluid, seeds=2, out="seeds").table["seed"]
        array([1, 2])
        """
        return Table.read(self.folder / "sweep.csv", self._units)

    @property
    def mean(self) -> Table:
        """Table ``sweep-mean.csv``, with one row for each state point.

        The columns contain means over the seeds with two standard errors: ``x_error`` follows from the errors
        of the runs, and ``x_scatter`` from the differences between the runs. The two should agree.

        Examples
        --------
        >>> carom.sweep(fluid, seeds=2, out="seeds").mean["runs"]
        array([2])
        """
        return Table.read(self.folder / "sweep-mean.csv", self._units)

    def page(self) -> str:
        """The page of the sweep as HTML, with plots of every quantity against the varied values.

        The plots include published curves for comparison.

        Examples
        --------
        >>> "<!DOCTYPE html>" in carom.sweep(fluid, seeds=2, out="seeds").page()
        True
        """
        return (self.folder / "sweep.html").read_text(encoding="utf-8")

    def _repr_html_(self) -> str:
        return framed(self.page())

    def __len__(self) -> int:
        return len(self._standing)

    def __repr__(self) -> str:
        done = sum(state == "done" for _, state, _ in self._standing)
        return f"<Sweep of {', '.join(self._core.names())}: {len(self)} points, {done} done>"


def _value(text: str) -> Any:
    """Parses a value from the text that the user typed."""
    try:
        return _carom.parse_toml(f"v = {text}")["v"]
    except ValueError:
        return text
