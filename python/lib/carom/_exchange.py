"""Replica exchange: swaps replicas of a scene between temperatures or between windows of a distance."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from carom import _carom
from carom._arguments import flag, path_of, real, whole
from carom._arrays import fixed
from carom._errors import FolderError, SceneError, SimulationError
from carom._folder import InFolder, TemporaryFolder, json_of
from carom._html import framed
from carom._observable import Observable, measured, source
from carom._progress import Progress
from carom._run import Results
from carom._scene import Scene, SceneLike
from carom._tables import Table
from carom._trajectory import Trajectory
from carom._units import units_of

__all__ = ["AtTemperature", "Exchange", "exchange"]


def exchange(
    scene: SceneLike,
    out: str | os.PathLike[str] | None = None,
    *,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    jobs: int | None = None,
    force: bool = False,
    checkpoint_every: float = 300.0,
    progress: bool = True,
) -> Exchange:
    """Runs the replicas of a scene with the table ``[exchange]``, like ``carom exchange``.

    For any number of jobs, the package and the program write the same files bit for bit.

    Parameters
    ----------
    scene : Scene, path or dict
        As for :class:`Scene`.
    out : path, optional
        Folder of the results; a temporary folder if not given. If the folder contains an interrupted
        exchange, the exchange resumes. If the folder contains a complete exchange, its results are read.
    seed, set
        As for :class:`Scene`.
    jobs : int, optional
        Number of threads; the number of processors if not given.
    force : bool
        Whether the exchange may write more than 10 GB, or more than a tenth of the free disk space.
    checkpoint_every, progress
        As for :func:`run`.

    Raises
    ------
    SceneError
        If the scene is invalid, or has no table ``[exchange]``.
    FolderError
        If the folder contains something else, or the files would be too large.
    SimulationError
        If a replica cannot continue, or an audit failed.

    Examples
    --------
    >>> pair = {
    ...     "name": "pair", "space": {"size": [4.0, 4.0, 4.0]},
    ...     "species": [{"name": "A", "mass": 1.0, "diameter": 1.0}],
    ...     "interaction": [{"species": ["A", "A"], "potential": "square-well", "lambda": 1.5, "well_depth": 1.0}],
    ...     "particle": [{"species": "A", "position": [1, 1, 1]}, {"species": "A", "position": [3, 3, 3]}],
    ...     "exchange": {"temperatures": [0.4, 0.6, 1.0], "interval": 2.0, "rate": 1.0},
    ...     "run": {"equilibration_time": 20.0, "until_time": 4000.0},
    ... }
    >>> result = carom.exchange(pair)
    >>> bool(abs(result.populations["population"][0] - 0.709) < 0.1)
    True
    """
    made = Scene(scene, seed=seed, set=set)
    if not made._core.has_exchange():
        cure = "add the table exchange with temperatures, interval and rate; carom.run runs a scene without it"
        raise SceneError(f"the scene {made.name} has no [exchange]\n  help: {cure}", cure=cure)
    threads = (os.cpu_count() or 1) if jobs is None else whole("jobs", jobs, 1)
    orders = (flag("force", force), real("checkpoint_every", checkpoint_every))
    folder = None if out is None else path_of("out", out)
    temporary = None
    if folder is None:
        temporary = TemporaryFolder()
        folder = Path(temporary.name) / f"{made.name}-exchange"
    with Progress(progress, made.name) as bar:
        faults = _carom.exchange(made._core, folder, threads, orders, bar.callback)
    result = Exchange(folder, _temporary=temporary)
    if faults:
        # A temporary folder is deleted together with the exchange.
        kept = folder if temporary is None else None
        raise SimulationError(f"the audit failed: {'; '.join(faults)}", folder=kept)
    return result


class AtTemperature(Results):
    """Results of an exchange at one of its temperatures: means and the measurements of instruments.

    The results are taken over all replicas that were at this temperature.

    Examples
    --------
    >>> measured = {**pair, "measure": {"radial_distribution": {"bins": 20}}}
    >>> cold = carom.exchange(measured).results[0]
    >>> cold.temperature, list(cold.curves)
    (0.4, ['radial_distribution'])
    """

    def __init__(self, summary: Mapping[str, Any], measured: Mapping[str, Any], units: dict[str, str]) -> None:
        self._summary, self._measured, self._units = summary, measured, units
        #: The temperature `[energy]`.
        self.temperature: float = summary["temperature"]

    def __repr__(self) -> str:
        return f"<Temperature {self.temperature:g}: {', '.join(self.observables)}>"


class Exchange(InFolder):
    """A complete replica exchange in its folder.

    Parameters
    ----------
    folder : path
        The folder of an exchange made by :func:`exchange` or by the program.

    Raises
    ------
    FolderError
        If the folder contains no replica exchange.

    Examples
    --------
    :func:`exchange` returns an :class:`Exchange`:

    >>> result = carom.exchange(pair)
    >>> result.temperatures
    array([0.4, 0.6, 1. ])
    """

    def __init__(
        self, folder: str | os.PathLike[str], *, _temporary: TemporaryFolder | None = None
    ) -> None:
        self._temporary = _temporary
        #: The folder.
        self.folder: Path = path_of("folder", folder)
        #: Contents of ``summary.json``.
        self.summary: Mapping[str, Any] = json_of(self.folder / "summary.json")
        if "neighbours" not in self.summary:
            raise FolderError(f"{self.folder} is not the folder of a replica exchange")

    @property
    def temperatures(self) -> NDArray[np.float64]:
        """The temperatures, in the order of the scene `[energy]`.

        An exchange between windows has one entry for each window, all with the same temperature.

        Examples
        --------
        >>> carom.exchange(pair).temperatures.shape
        (3,)
        """
        return fixed(np.array([it["temperature"] for it in self.summary["temperatures"]]))

    def observable(self, name: str) -> list[Observable]:
        """The mean of a quantity at each temperature, with its standard error.

        Parameters
        ----------
        name : str
            Name of the quantity, such as ``potential_energy_per_particle`` `[energy]` or
            ``heat_capacity_per_particle`` (in units of k_B).

        Raises
        ------
        KeyError
            If the quantity was not measured.

        Examples
        --------
        >>> u = carom.exchange(pair).observable("potential_energy_per_particle")
        >>> u[0].mean < u[1].mean < u[2].mean
        True
        """
        return [at.observables[name] for at in self.results]

    @cached_property
    def results(self) -> list[AtTemperature]:
        """Means with standard errors and curves of instruments, in the order of the temperatures.

        Examples
        --------
        >>> result = carom.exchange({**pair, "measure": {"radial_distribution": {"bins": 20}}})
        >>> g = [at.curves["radial_distribution"].y for at in result.results]
        >>> all(of_one[12] > of_one[17] for of_one in g)        # within the well and beyond it
        True
        """
        path = self.folder / "measurements.json"
        count = len(self.temperatures)
        measured: list[Mapping[str, Any]] = json_of(path)["stages"] if path.exists() else [{}] * count
        units = units_of(self.summary, self.summary["dimensions"])
        return [AtTemperature(*of_one, units) for of_one in zip(self.summary["temperatures"], measured)]

    @property
    def acceptance(self) -> list[Observable]:
        """Fraction of accepted swap attempts between each temperature or window and the next.

        Examples
        --------
        >>> all(0.2 < it.mean < 1.0 for it in carom.exchange(pair).acceptance)
        True
        """
        found: list[dict[str, Any]] = [it["acceptance"] or {"mean": float("nan"), "standard_error": None} for it in self.summary["neighbours"]]
        exchange = source(self.summary.get("seed"), self.summary["neighbours"])
        return [measured(source(exchange, at), Observable(it["mean"], it["standard_error"], "1")) for at, it in enumerate(found)]

    @property
    def round_trips(self) -> NDArray[np.int64]:
        """Number of round trips of each replica.

        A round trip leads from the highest temperature to the lowest and back, or from the last window to the
        first and back.

        Examples
        --------
        >>> carom.exchange(pair).round_trips.shape
        (3,)
        """
        return fixed(np.array(self.summary["round_trips"], dtype=np.int64))

    @cached_property
    def populations(self) -> Table:
        """Populations of the levels of the potential energy.

        The columns are ``temperature``, ``energy`` and ``width`` of the level `[energy]`, ``population`` and
        ``population_error``.

        Raises
        ------
        FolderError
            If the exchange is between windows of a distance.

        Examples
        --------
        >>> list(carom.exchange(pair).populations)[-1]
        'population_error'
        """
        return self._table("energies.csv", "populations")

    @cached_property
    def curves(self) -> Table:
        """Curves between the temperatures, from the energies at all temperatures together (MBAR).

        The columns are ``temperature`` `[energy]`, ``potential_energy_per_particle`` `[energy]`,
        ``heat_capacity_per_particle`` (in units of k_B), ``entropy_per_particle`` and
        ``reduced_free_energy_per_particle``. The last two are relative to their values at the highest
        temperature. A scene with bonds also has ``mean_square_radius_of_gyration`` and
        ``mean_square_end_to_end_distance`` `[length^2]`. Each quantity except the temperature has a column
        with its error, such as ``heat_capacity_per_particle_error``.

        Raises
        ------
        FolderError
            If the exchange is between windows of a distance.

        Examples
        --------
        >>> curves = carom.exchange(pair).curves
        >>> bool(curves["temperature"][0] == 0.4 and (np.diff(curves["potential_energy_per_particle"]) > 0).all())
        True
        """
        return self._table("curves.csv", "curves between temperatures")

    @cached_property
    def density_of_states(self) -> Table:
        """Density of states ``g(E)`` of the levels of the potential energy.

        The columns are ``energy`` `[energy]`, ``log_density_of_states``, which is the natural logarithm of
        ``g(E)``, and its error ``log_density_of_states_error``. The normalisation is
        ``sum g(E) exp(-E / T) = 1`` at the highest temperature ``T``.

        Raises
        ------
        FolderError
            If the exchange is between windows of a distance.

        Examples
        --------
        >>> carom.exchange(pair).density_of_states["energy"].tolist()
        [-1, 0]
        """
        return self._table("density_of_states.csv", "density of states")

    def _table(self, name: str, what: str, *, of_windows: bool = False) -> Table:
        """Reads a table that not every exchange has: some tables need windows, others need temperatures."""
        if (len(self.windows) > 0) != of_windows:
            between = "temperatures" if of_windows else "windows of a distance"
            raise FolderError(f"{self.folder} has no {what}: it is an exchange between {between}")
        return Table.read(self.folder / name)

    @property
    def windows(self) -> NDArray[np.float64]:
        """Lower and upper end of each window of a distance `[length]`.

        Only an exchange with ``ensemble = "umbrella"`` has windows. For other exchanges the array is empty.

        Examples
        --------
        >>> carom.exchange(pair).windows.shape
        (0, 2)
        """
        found = (self.summary.get("umbrella") or {}).get("windows", [])
        return fixed(np.array(found, dtype=float).reshape(-1, 2))

    @cached_property
    def potential_of_mean_force(self) -> Table:
        """Free energies along the distance, from all windows together.

        The columns ``distance`` and ``width`` contain the middle and the width of each bin `[length]`. The
        column ``free_energy`` contains ``F(r) = -T ln p(r)`` with the probability density ``p(r)`` of the
        distance, and ``potential_of_mean_force`` contains ``w(r) = F(r) + (D - 1) T ln r`` in ``D``
        dimensions `[energy]`. Both have a column with their error, such as ``free_energy_error``, and both
        are zero for the mean density in the last window.

        Raises
        ------
        FolderError
            If the exchange has no windows.

        Examples
        --------
        >>> umbrella = {"between": [[0], [1]], "windows": [[1.0, 1.6], [1.4, 1.95]], "bins": 8}
        >>> changed = {"exchange.ensemble": "umbrella", "exchange.temperatures": [0.6], "exchange.umbrella": umbrella, "run.equilibration_time": 200.0}
        >>> w = carom.exchange(pair, set=changed).potential_of_mean_force
        >>> bool(w["potential_of_mean_force"][w["distance"] < 1.5].max() < w["potential_of_mean_force"][w["distance"] > 1.5].min())
        True
        """
        return self._table("potential_of_mean_force.csv", "potential of mean force", of_windows=True)

    @property
    def distances(self) -> NDArray[np.float64]:
        """Distance of the replica in each window at each attempt `[length]`.

        The array has the shape ``(windows, attempts)``. For an exchange without windows the array is empty.

        Examples
        --------
        >>> carom.exchange(pair).distances.shape
        (0,)
        """
        rows = self.attempts
        return fixed(np.array([rows[f"distance_{at}"] for at in range(1, len(self.windows) + 1)], dtype=float))

    def temperatures_for(self, acceptance: float) -> NDArray[np.float64]:
        """Temperatures between which all swaps have the same acceptance `[energy]`.

        The temperatures extend from the lowest to the highest temperature of the exchange, and follow from
        its density of states. Their number is the smallest for which the acceptance is at least
        ``acceptance``.

        Parameters
        ----------
        acceptance : float
            The requested acceptance, between 0 and 1.

        Raises
        ------
        ValueError
            If the number is not between 0 and 1, or the density of states is unknown.

        Examples
        --------
        >>> carom.exchange(pair).temperatures_for(0.5)
        array([0.4, 1. ])
        """
        asked = real("acceptance", acceptance)
        found = _carom.exchange_temperatures(self.folder, asked) if 0.0 < asked < 1.0 else None
        if found is None:
            raise ValueError(
                f"acceptance: expected a number between 0 and 1 and an exchange with a density of states; {asked:g} gives no temperatures here"
            )
        return fixed(np.array(found))

    @property
    def warnings(self) -> list[str]:
        """Reasons why the exchange may not be in equilibrium.

        Examples are frozen temperatures and too few round trips. The list is empty if there are no such
        reasons.

        Examples
        --------
        >>> carom.exchange(pair).warnings
        []
        """
        return list(self.summary.get("warnings", []))

    @cached_property
    def attempts(self) -> Table:
        """Table ``exchange.csv``, with one row for each attempt to swap.

        The columns are ``time``, and ``replica_1``, ``potential_1`` and so on for each temperature or window.

        Examples
        --------
        >>> "replica_1" in carom.exchange(pair).attempts
        True
        """
        return Table.read(self.folder / "exchange.csv")

    @property
    def potential_energies(self) -> NDArray[np.float64]:
        """Potential energy of the replica at each temperature at each attempt `[energy]`.

        The array has the shape ``(temperatures, attempts)``. WHAM and MBAR reweight these energies.

        Examples
        --------
        >>> carom.exchange(pair).potential_energies.shape[0]
        3
        """
        rows = self.attempts
        return fixed(np.array([rows[f"potential_{at}"] for at in range(1, len(self.temperatures) + 1)], dtype=float))

    @cached_property
    def frames(self) -> list[Trajectory]:
        """The trajectory at each temperature, in the order of the temperatures.

        Examples
        --------
        >>> len(carom.exchange(pair).frames)
        3
        """
        count = len(self.temperatures)
        return [Trajectory(self.folder / f"trajectory-{at}.xyz", _owner=self) for at in range(1, count + 1)]

    def page(self) -> str:
        """The page of the exchange as HTML.

        Examples
        --------
        >>> "<!DOCTYPE html>" in carom.exchange(pair).page()
        True
        """
        return (self.folder / "exchange.html").read_text(encoding="utf-8")

    def _repr_html_(self) -> str:
        return framed(self.page())

    def __repr__(self) -> str:
        places = "windows" if len(self.windows) else "temperatures"
        return f"<Exchange of {self.summary['scene']}: {len(self.temperatures)} {places}, {self.summary['attempts']} attempts>"
