"""Simulations, which advance a scene from event to event."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from html import escape
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from carom import _carom
from carom._arguments import finite, flag, shown, threads_of, vectors, whole
from carom._arrays import fixed
from carom._drive import Driven
from carom._errors import SimulationError
from carom._frame import Frame
from carom._html import number, table
from carom._progress import Progress
from carom._scene import Scene, SceneLike, endless
from carom._state import State
from carom._tables import Named

if TYPE_CHECKING:
    from carom._run import Run

__all__ = ["EVENT", "EVENT_KINDS", "Simulation"]

#: Kinds of events. The field ``kind`` is an index of this tuple.
EVENT_KINDS: tuple[str, ...] = (
    "core",
    "capture",
    "release",
    "bounce",
    "wall -x",
    "wall +x",
    "wall -y",
    "wall +y",
    "wall -z",
    "wall +z",
    "thermostat",
    "surface",
    "exit",
    "entry",
)

#: Type of an event in the arrays of :meth:`Simulation.events`.
EVENT: np.dtype[np.void] = np.dtype(
    [
        ("time", "=f8"),
        ("kind", "u1"),
        ("particle", "=i8"),
        ("partner", "=i8"),
        ("positions", "=f8", (2, 3)),
        ("velocities_before", "=f8", (2, 3)),
        ("velocities_after", "=f8", (2, 3)),
        ("energy_step", "=f8"),
        ("dissipated", "=f8"),
        ("impulse", "=f8"),
        ("distance", "=f8"),
        ("normal", "=f8", (3,)),
    ],
    align=True,
)

#: A number of events that no simulation reaches.
_ENDLESS = 2**64 - 1


def _bits(kinds: str | Iterable[str] | None) -> int:
    if kinds is None:
        return (1 << len(EVENT_KINDS)) - 1
    bits = 0
    for kind in [kinds] if isinstance(kinds, str) else kinds:
        numbers = [at for at, known in enumerate(EVENT_KINDS) if kind in (known, known.split()[0])]
        if not numbers:
            raise ValueError(f"kinds: expected some of {', '.join(EVENT_KINDS)}, or wall for all walls, found {shown(kind)}")
        for number in numbers:
            bits |= 1 << number
    return bits


def _columns(columns: Iterable[str]) -> list[str]:
    known = EVENT.names or ()
    chosen = [columns] if isinstance(columns, str) else list(columns)
    for name in chosen:
        if name not in known:
            raise ValueError(f"columns: expected some of {', '.join(known)}, found {shown(name)}")
    return chosen


def _events_of(found: bytearray) -> NDArray[np.void]:
    return fixed(np.frombuffer(found, EVENT))


class Simulation(State, Driven):
    """A simulation, which advances a scene in time.

    The results are bitwise the same however often the simulation is stopped, inspected or copied.

    Other Python threads run while the simulation advances. Ctrl-C ends the call cleanly: the simulation stays
    at the last event that it reached, and can be continued. Two threads cannot use the same simulation at the
    same time, but each thread can use its own :meth:`copy`.

    Parameters
    ----------
    scene : Scene, path, dict or Run
        As for :class:`Scene`. A scene without ``[run]`` is also accepted, and gets ``until_events = 1``
        instead. If a :class:`Run` is given, the simulation continues from the end of the run, with its
        particles, bonds, time, the states of all pairs, and the thermostat of its measurement. The
        equilibration and the stages of the run are not repeated, and events are counted from zero. Only runs
        change the volume: after a measurement at constant pressure, the simulation keeps the final box.
    plan : bool
        Whether to reject a scene that plans something only a run can do: stages, growth, an equilibration, or
        a thermostat that scales velocities. ``False`` ignores the plan and its thermostat, and uses only the
        dynamics. :meth:`prepared` carries out the plan.
    seed, set
        As for :class:`Scene`.
    threads : int or "auto", optional
        As for :func:`run`.

    Raises
    ------
    SceneError
        If the scene is invalid, or needs a run.

    Examples
    --------
    >>> simulation = carom.Simulation(fluid)
    >>> simulation.advance(events=20_000)
    'events'
    >>> simulation.event_counts["core"]
    20000

    Continue from the end of a run:

    >>> run = carom.run(fluid)
    >>> carom.Simulation(run).time == run.summary["time"]
    True
    """

    __slots__ = ()

    def __init__(
        self,
        scene: SceneLike | Run,
        *,
        plan: bool = True,
        seed: int | None = None,
        set: dict[str, Any] | None = None,
        threads: int | Literal["auto"] | None = None,
    ) -> None:
        from carom._run import Run

        self._scene = endless(scene._end() if isinstance(scene, Run) else scene, seed, set)
        self._core = _carom.Simulation(self._scene._core, flag("plan", plan), threads_of(threads))
        self._is_asking = False

    @classmethod
    def prepared(
        cls,
        scene: SceneLike,
        *,
        seed: int | None = None,
        set: dict[str, Any] | None = None,
        threads: int | Literal["auto"] | None = None,
        progress: bool = True,
    ) -> Simulation:
        """Simulates everything that a scene plans before its measurement.

        Returns the simulation at the start of the measurement, with the thermostat and the gravity of the
        measurement. The state is bitwise the same as in :func:`run`.

        The call carries out the stages, with their thermostats, growth, gravity and surfaces, and the
        equilibration, with the same driver as a run. Measurements made during stages are not kept. To observe
        the preparation, use :func:`run`. Other Python threads run meanwhile.

        Parameters
        ----------
        scene : Scene, path or dict
            As for :class:`Scene`.
        seed, set
            As for :class:`Scene`.
        threads, progress
            As for :func:`run`.

        Raises
        ------
        SceneError
            If the scene is invalid, or its measurement has a thermostat that scales velocities.
        SimulationError
            If the preparation fails: for example, spheres jam during growth, or the equilibration does not
            end.
        KeyboardInterrupt
            On Ctrl-C.

        Examples
        --------
        >>> scene = {**fluid, "run": {"equilibration_events": 5000, "until_events": 20_000}}
        >>> simulation = carom.Simulation.prepared(scene)
        >>> simulation.event_counts["core"]
        5000
        """
        made = Scene(scene, seed=seed, set=set)
        with Progress(flag("progress", progress), made.name) as bar:
            core = _carom.Simulation.prepared(made._core, threads_of(threads), bar.callback)
        return cls._of(core, made)

    # Advancing

    def _refuse_while_asking(self) -> None:
        if self._is_asking:
            raise RuntimeError(
                "a `stop` function cannot advance its own simulation: return True and continue after the call, or advance a copy"
            )

    def _until(self, duration: Any, events: Any, until: Any) -> tuple[float, int]:
        self._refuse_while_asking()
        if duration is None and events is None and until is None:
            raise ValueError("expected a duration, a number of events, or until=TIME; the first of them ends the call")
        time = math.inf
        if duration is not None:
            length = finite("duration", duration)
            if length < 0.0:
                raise ValueError(f"duration: expected a time of at least 0, found {length}")
            time = self._core.time + length
        if until is not None:
            goal = finite("until", until)
            if goal < self._core.time:
                raise ValueError(f"until: expected a time of at least {self._core.time}, the current time, found {goal}")
            time = min(time, goal)
        count = _ENDLESS
        if events is not None:
            count = min(_ENDLESS, self._core.physical_events() + whole("events", events))
        return time, count

    def advance(
        self,
        duration: float | None = None,
        *,
        events: int | None = None,
        until: float | None = None,
        stop: Callable[[np.void], bool] | None = None,
        kinds: str | Iterable[str] | None = None,
        progress: bool = False,
    ) -> str:
        """Advances the simulation until the first of the given limits is reached.

        Parameters
        ----------
        duration : float
            Simulated time from now `[time]`.
        events : int
            Number of physical events from now. All events are physical except the events of thermostats.
        until : float
            Simulated time since the start of the scene `[time]`.
        stop : callable
            Function called after each event of ``kinds``, with the event as an entry of type :data:`EVENT`.
            If it returns true, the simulation stops at that event. The function can inspect and copy the
            simulation, and can set its positions and velocities; the simulation then continues from these, as
            between two calls. The function cannot advance the simulation. Each call costs about 3
            microseconds.
        kinds : str or list of str
            Any of :data:`EVENT_KINDS`, or ``"wall"`` for all walls. All kinds by default.
        progress : bool
            Whether to show a progress bar, as in :func:`run`, if the call takes more than half a second.

        Returns
        -------
        str
            Why the call ended: ``"time"``, ``"events"``, ``"stop"``, or ``"idle"`` if no further event will
            ever happen.

        Raises
        ------
        SimulationError
            If the dynamics come to rest in a way that needs infinitely many events.
        ValueError, TypeError
            If no limit is given, or if a value is negative, not finite or not a number.
        RuntimeError
            If ``stop`` advances the simulation that calls it, or another thread is advancing it.
        KeyboardInterrupt
            On Ctrl-C. The simulation can be continued.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> simulation.advance(2.0), simulation.time
        ('time', 2.0)
        >>> simulation.advance(events=10**6, stop=lambda event: 5 in (event["particle"], event["partner"]))
        'stop'
        """
        time, count = self._until(duration, events, until)
        if stop is None:
            if kinds is not None:
                raise ValueError("kinds: has no effect without stop: add stop, or omit kinds")
            with Progress(flag("progress", progress), self._scene.name) as bar:
                return self._core.advance(time, count, bar.callback)
        if not callable(stop):
            raise TypeError(f"stop: expected a function of an event, found {shown(stop)}")
        bits = _bits(kinds)
        core, begun = self._core, (self._core.time, self._core.physical_events())
        self._is_asking = True
        try:
            with Progress(flag("progress", progress), self._scene.name) as bar:
                while True:
                    found, reason = core.events(1, time, count, bits)
                    if found and stop(_events_of(found)[0]):
                        return "stop"
                    if reason is not None:
                        return reason
                    if bar.is_due():
                        done = core.physical_events() - begun[1]
                        part = max((core.time - begun[0]) / (time - begun[0]), done / (count - begun[1]))
                        bar.show("advancing", part, core.time, done)
        finally:
            self._is_asking = False

    @overload
    def events(
        self,
        duration: float | None = None,
        *,
        events: int | None = None,
        until: float | None = None,
        kinds: str | Iterable[str] | None = None,
        batch: int = 65536,
        columns: None = None,
    ) -> Iterator[NDArray[np.void]]: ...

    @overload
    def events(
        self,
        duration: float | None = None,
        *,
        events: int | None = None,
        until: float | None = None,
        kinds: str | Iterable[str] | None = None,
        batch: int = 65536,
        columns: Iterable[str],
    ) -> Iterator[dict[str, NDArray[Any]]]: ...

    def events(
        self,
        duration: float | None = None,
        *,
        events: int | None = None,
        until: float | None = None,
        kinds: str | Iterable[str] | None = None,
        batch: int = 65536,
        columns: Iterable[str] | None = None,
    ) -> Iterator[Any]:
        """Advances the simulation as :meth:`advance` does, and yields all events in batches.

        When a batch is yielded, the simulation is at the last event of the batch. If a loop over the batches
        ends early, the simulation stays there. If other calls advance the simulation within the loop, their
        events are not yielded.

        Parameters
        ----------
        duration, events, until
            Limits, as for :meth:`advance`.
        kinds : str or list of str
            Yield only events of these kinds. All kinds by default.
        batch : int
            Maximum number of events in a batch. Each event takes 232 bytes.
        columns : list of str
            Fields of :data:`EVENT`. If given, each batch is a dictionary with one array for each field. These
            arrays are contiguous, writable and independent of the batch, as PyTorch and DLPack require.

        Yields
        ------
        array of :data:`EVENT`, shape (m,)
            The fields are: ``time`` `[time]`; ``kind``, an index into :data:`EVENT_KINDS`; ``particle`` and
            ``partner``, the ids of the two particles, with -1 for no partner; ``positions`` of both particles
            `[length]`, within the box, and their ``velocities_before`` and ``velocities_after``
            `[length / time]`, each of shape (2, 3), with 0 for no partner; ``energy_step``, the gain in
            potential energy `[energy]`, or for a thermostat event the kinetic energy that it supplied;
            ``dissipated``, the kinetic energy lost to restitution `[energy]`, which is negative if the TC model
            lifts a particle at rest; ``normal``, the unit vector from the partner to the particle; ``impulse``, the momentum that the particle gained along
            ``normal`` `[mass length / time]`; ``distance``, the distance of the discontinuity `[length]`.

        Raises
        ------
        The same exceptions as :meth:`advance`.

        Examples
        --------
        Compute the pressure of hard spheres from the virial of the events:

        >>> simulation = carom.Simulation(fluid, seed=2)
        >>> _ = simulation.advance(events=20_000)
        >>> start, virial = simulation.time, 0.0
        >>> for batch in simulation.events(events=50_000):
        ...     virial += (batch["impulse"] * batch["distance"]).sum()
        >>> z = 1.0 + virial / (3 * 107 / 3 * 3 * (simulation.time - start))
        >>> bool(abs(z - 3.95) < 0.1)
        True
        """
        # Invalid arguments raise an error here, not at the first batch.
        time, count = self._until(duration, events, until)
        batches = self._batches(time, count, _bits(kinds), whole("batch", batch, 1))
        if columns is None:
            return batches
        chosen = _columns(columns)
        return ({name: found[name].copy() for name in chosen} for found in batches)

    def _batches(self, time: float, count: int, bits: int, batch: int) -> Iterator[NDArray[np.void]]:
        while True:
            self._refuse_while_asking()
            found, reason = self._core.events(batch, time, count, bits)
            if found:
                yield _events_of(found)
            if reason is not None:
                return

    # Reading the state

    @property
    def scene(self) -> Scene:
        """The scene from which the simulation started.

        Examples
        --------
        >>> carom.Simulation(fluid).scene.name
        'fluid'
        """
        return self._scene

    @property
    def time(self) -> float:
        """Simulated time `[time]`.

        Examples
        --------
        >>> carom.Simulation(fluid).time
        0.0
        """
        return self._core.time

    @property
    def size(self) -> NDArray[np.float64]:
        """Current edges of the box `[length]`, of shape ``(3,)``; 0 along flat axes.

        After a stage at constant pressure, they differ from the initial edges in ``scene.size``.

        Examples
        --------
        >>> carom.Simulation(fluid).size.round(3)
        array([5.734, 5.734, 5.734])
        """
        return fixed(np.array(self._core.space()[1]))

    @property
    def engine(self) -> str:
        """Description of the engine chosen for the scene.

        Examples
        --------
        >>> carom.Simulation(fluid).engine.split(",")[0]
        'force-free particles'
        """
        return self._core.engine

    @property
    def event_counts(self) -> dict[str, int]:
        """Number of events of each kind since the start.

        The kinds are ``core``, ``capture``, ``release``, ``bounce``, ``wall``, ``thermostat``, ``exit``, ``entry``
        and ``transition``. Contacts with surfaces count as ``wall``. Transitions are moves between cells and
        neighbour lists, and are not physical events.

        Examples
        --------
        >>> carom.Simulation(fluid).event_counts["core"]
        0
        """
        return Named("kind", self._core.event_counts())

    @property
    def energy(self) -> dict[str, float]:
        """Current energies `[energy]`.

        They are ``kinetic``, of the motion of the centres; ``rotational``, of the spins; ``thermal``, the kinetic energy without the streaming motion in a sheared box;
        ``potential``; ``pair``, the part of the potential energy that comes from pairs; and the energies
        ``dissipated`` and ``supplied`` since the start. ``kinetic + potential + dissipated - supplied`` is
        conserved.

        Examples
        --------
        >>> round(carom.Simulation(fluid).energy["kinetic"], 9)  # 3 (N - 1) / 2
        160.5
        """
        return Named("energy", self._core.energy())

    @property
    def temperature(self) -> float | None:
        """Current kinetic temperature `[energy]`, as measured in runs.

        The temperature excludes the centre-of-mass velocity along axes on which momentum is conserved, and
        the streaming velocity in a sheared box. It is ``None`` with gravity, and with fewer than two moving
        particles.

        Examples
        --------
        >>> round(carom.Simulation(fluid).temperature, 9)
        1.0
        """
        return self._core.temperature

    @property
    def momentum(self) -> NDArray[np.float64]:
        """Total momentum `[mass length / time]`, of shape ``(3,)``.

        Examples
        --------
        >>> bool(abs(carom.Simulation(fluid).momentum).max() < 1e-12)
        True
        """
        return fixed(np.array(self._core.momentum()))

    @property
    def deepest_overlap(self) -> float:
        """Current deepest overlap of all pairs and walls, relative to the required distance.

        In a sound simulation, the overlap is only round-off, about 1e-15.

        Examples
        --------
        >>> carom.Simulation(fluid).deepest_overlap
        0.0
        """
        return self._core.deepest_overlap()

    @property
    def positions(self) -> NDArray[np.float64]:
        """Current positions `[length]`, of shape ``(n, 3)``, in the order of the ids.

        Along periodic axes, the positions are within the box, except for round-off. Reading returns a new
        read-only array, made in one pass. Assigned positions are checked like the positions of a scene, and
        the states of the pairs follow from the distances. The energy supplied by the assignment is counted.

        Raises
        ------
        ValueError, TypeError
            If an assigned array has the wrong shape or contains numbers that are not finite, or if particles
            in it overlap, leave a sheared box or move along a flat axis. The simulation then stays unchanged.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> simulation.positions = simulation.positions + [0.1, 0.0, 0.0]
        >>> simulation.positions.shape
        (108, 3)
        """
        return self._core.positions()

    @positions.setter
    def positions(self, positions: ArrayLike) -> None:
        self.set_positions(positions)

    def set_positions(self, positions: ArrayLike, *, keep_states: bool = False) -> None:
        """Sets the positions of all particles.

        Parameters
        ----------
        positions : array, shape (n, 3)
            `[length]`, in the order of the ids.
        keep_states : bool
            Whether captured pairs stay captured. Positions that are inconsistent with the captured pairs are
            then rejected. Otherwise, the states of the pairs follow from the distances.

        Raises
        ------
        ValueError, TypeError
            As for :attr:`positions`.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> try:
        ...     simulation.set_positions(0.7 * simulation.positions)
        ... except ValueError as error:
        ...     print(str(error).split(" by ")[0])
        positions: particle 106 overlaps with particle 107
        """
        self._core.set_positions(vectors("positions", positions, len(self)), flag("keep_states", keep_states))

    @property
    def spins(self) -> NDArray[np.float64]:
        """Current spins `[1 / time]`, of shape ``(n, 3)``, in the order of the ids.

        A spin is the angular velocity of a particle about its centre. Without rough contacts, all spins are 0.

        Examples
        --------
        >>> bool((carom.Simulation(fluid).spins == 0).all())
        True
        """
        return self._core.spins()

    @property
    def velocities(self) -> NDArray[np.float64]:
        """Current velocities `[length / time]`, of shape ``(n, 3)``, in the order of the ids.

        Reading returns a new read-only array. Assigning calls :meth:`set_velocities`.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> simulation.velocities = 2.0 * simulation.velocities
        >>> round(simulation.energy["kinetic"], 9)
        642.0
        """
        return self._core.velocities()

    @velocities.setter
    def velocities(self, velocities: ArrayLike) -> None:
        self.set_velocities(velocities)

    def set_velocities(self, velocities: ArrayLike) -> None:
        """Sets the current velocities of all particles.

        The energy supplied by this call is counted.

        Parameters
        ----------
        velocities : array, shape (n, 3)
            `[length / time]`, in the order of the ids; 0 along flat axes and for static particles.

        Raises
        ------
        ValueError, TypeError
            If the array has the wrong shape, or contains numbers that are not finite or not real. The
            simulation then stays unchanged.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> simulation.set_velocities(-simulation.velocities)
        """
        self._core.set_velocities(vectors("velocities", velocities, len(self)))

    @property
    def images(self) -> NDArray[np.int32]:
        """Number of periods travelled along each axis since the start, of shape ``(n, 3)``.

        :attr:`Frame.unwrapped` uses these numbers.

        Examples
        --------
        >>> int(abs(carom.Simulation(fluid).images).max())
        0
        """
        return self._core.images()

    @property
    def species(self) -> NDArray[np.int64]:
        """Species of each particle, of shape ``(n,)``, as indices into ``scene.species_names``.

        Examples
        --------
        >>> carom.Simulation(fluid).species[:3]
        array([0, 0, 0])
        """
        return self._core.species()

    @property
    def ids(self) -> NDArray[np.int64]:
        """Ids of the particles, in the order of all arrays. Particles that enter have new ids.

        Examples
        --------
        >>> carom.Simulation(fluid).ids[:3].tolist()
        [0, 1, 2]
        """
        return self._core.ids()

    @property
    def captured_pairs(self) -> NDArray[np.int64]:
        """Pairs inside a well or another step of their potential, of shape ``(pairs, 3)``.

        Each pair is listed once, with the lower id, the higher id, and the number of steps that the pair is
        inside.

        Examples
        --------
        >>> carom.Simulation(fluid).captured_pairs.shape
        (0, 3)
        """
        return self._core.captured_pairs()

    def frame(self) -> Frame:
        """Current state of all particles, with the box.

        Use a frame to pass the state to other programs, or when positions, velocities and images of the same
        time are needed.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> _ = simulation.advance(1.0)
        >>> simulation.frame().time
        1.0
        """
        scene, core = self._scene, self._core
        species = core.species()
        lower, size, periodic = core.space()
        bond_names, bond_kinds = scene._core.bond_kinds()
        return Frame(
            time=core.time,
            positions=core.positions(),
            velocities=core.velocities(),
            images=core.images(),
            ids=core.ids(),
            species=species,
            radii=fixed(core.radii()),
            species_names=scene.species_names,
            species_masses=scene._frame_masses,
            lower=fixed(np.array(lower)),
            size=fixed(np.array(size)),
            periodic=fixed(np.array(periodic)),
            displacement=core.displacement,
            bonds=scene.bonds,
            bond_names=bond_names,
            bond_kinds=bond_kinds,
        )

    def to_ase(self) -> Any:
        """Converts the current state as :meth:`Frame.to_ase` does.

        Examples
        --------
        >>> len(carom.Simulation(fluid).to_ase())  # doctest: +ASE
        108
        """
        return self.frame().to_ase()

    def to_mdanalysis(self) -> Any:
        """Converts the current state as :meth:`Frame.to_mdanalysis` does.

        Examples
        --------
        >>> carom.Simulation(fluid).to_mdanalysis().atoms.n_atoms  # doctest: +MDANALYSIS
        108
        """
        return self.frame().to_mdanalysis()

    def to_freud(self) -> tuple[Any, NDArray[np.float64]]:
        """Converts the current state as :meth:`Frame.to_freud` does.

        Examples
        --------
        >>> box, points = carom.Simulation(fluid).to_freud()  # doctest: +FREUD
        >>> len(points)  # doctest: +FREUD
        108
        """
        return self.frame().to_freud()

    def __len__(self) -> int:
        return self._core.count()

    def __repr__(self) -> str:
        scene = self._scene
        try:
            now = f"at time {self.time:g}"
        except SimulationError:
            now = "that has failed"
        except RuntimeError:
            now = "advancing in another thread"
        count = self._core.count() if now.startswith("at") else len(scene)
        return f"<Simulation of {scene.name} {now}: {count} particles>"

    def _repr_html_(self) -> str:
        try:
            return self._as_table()
        except RuntimeError:
            return escape(repr(self))

    def _as_table(self) -> str:
        events = sum(count for kind, count in self.event_counts.items() if kind != "transition")
        caption = f"<b>{escape(self._scene.name)}</b> at time {self.time:.6g}: {len(self)} particles, {events} events"
        rows = [("engine", escape(self.engine)), *((f"{name} energy", number(value)) for name, value in self.energy.items())]
        return table(caption, ["", ""], rows)
