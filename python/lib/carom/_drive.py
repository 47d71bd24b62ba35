"""External control of simulations: temperatures and thermostats."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from carom import _carom
from carom._arguments import finite, shown, whole

__all__ = ["Driven"]

_AXES = "xyz"


class Driven:
    """Simulation whose velocities and thermostat can be changed."""

    __slots__ = ()

    _core: _carom.Simulation

    def thermalize(self, temperature: float, *, seed: int) -> None:
        """Draws new velocities for all moving particles, like ``temperature`` of a ``[[fill]]`` at the start.

        The velocities follow Maxwell's distribution and have exactly this temperature. The total momentum is
        zero along axes on which momentum is conserved. In a sheared box, the velocities are drawn relative to
        the streaming velocity. The energy supplied by this call is counted.

        Parameters
        ----------
        temperature : float
            `[energy]`.
        seed : int
            Seed of the random numbers. The same seed gives the same velocities. These differ from the initial
            velocities of a scene with that seed.

        Raises
        ------
        ValueError, TypeError
            If the temperature is not positive, or no particle moves. The simulation then stays unchanged.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> simulation.thermalize(2.0, seed=1)
        >>> round(simulation.temperature, 9), bool(abs(simulation.momentum).max() < 1e-12)
        (2.0, True)
        """
        self._core.thermalize(finite("temperature", temperature), whole("seed", seed))

    def rescale(self, temperature: float) -> None:
        """Scales all velocities once, to a given temperature.

        The velocities are scaled relative to the motion that :attr:`Simulation.temperature` excludes. The
        energy supplied by this call is counted. For a thermostat that rescales at regular intervals, call
        this method and :meth:`Simulation.advance` in a loop.

        Parameters
        ----------
        temperature : float
            `[energy]`.

        Raises
        ------
        ValueError, TypeError
            If the temperature is not positive, or the simulation has no temperature to scale: with gravity,
            with fewer than two moving particles, or if all particles are at rest.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> for temperature in (0.9, 0.8, 0.7):
        ...     simulation.rescale(temperature)
        ...     _ = simulation.advance(0.5)
        >>> round(simulation.temperature, 9)
        0.7
        """
        self._core.rescale(finite("temperature", temperature))

    @property
    def thermostat(self) -> dict[str, Any] | None:
        """Present thermostat, or ``None`` if the simulation has no thermostat.

        The dictionary has the keys of ``[run.thermostat]`` in a scene: ``kind``, ``temperature``, ``rate``
        and ``axes``. Flat axes are left out. A thermostat can also be assigned; without ``axes``, it acts
        along all axes.

        Raises
        ------
        ValueError, TypeError
            As for :meth:`set_thermostat`, and if the assigned dictionary has another kind or an unknown key.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> simulation.thermostat = {"kind": "andersen", "temperature": 2.0, "rate": 1.0}
        >>> simulation.thermostat["axes"]
        ['x', 'y', 'z']
        >>> simulation.thermostat = None
        """
        bath = self._core.thermostat()
        if bath is None:
            return None
        temperature, rate, axes = bath
        named = [name for name, has in zip(_AXES, axes) if has]
        return {"kind": "andersen", "temperature": temperature, "rate": rate, "axes": named}

    @thermostat.setter
    def thermostat(self, thermostat: Mapping[str, Any] | None) -> None:
        if thermostat is None:
            self.set_thermostat(None)
            return
        if not isinstance(thermostat, Mapping):
            raise TypeError(f"thermostat: expected a dictionary or None, found {shown(thermostat)}")
        if thermostat.get("kind") != "andersen":
            found = shown(thermostat.get("kind"))
            raise ValueError(f"thermostat: expected the kind 'andersen', found {found}; velocities are scaled by rescale()")
        unknown = [key for key in thermostat if key not in ("kind", "temperature", "rate", "axes")]
        if unknown or "temperature" not in thermostat:
            raise ValueError(f"thermostat: expected the key temperature, and optionally rate and axes, found {', '.join(map(str, thermostat))}")
        self.set_thermostat(thermostat["temperature"], thermostat.get("rate"), thermostat.get("axes", _AXES))

    def set_thermostat(self, temperature: float | None, rate: float | None = None, axes: Iterable[str] = _AXES) -> None:
        """Starts an Andersen thermostat, which replaces the present one, if any.

        It works like the thermostat of a scene. Its collisions are events of the kind ``thermostat``, and the
        energy that they supply is counted. Each thermostat has its own random numbers, derived from the seed
        of the scene.

        Parameters
        ----------
        temperature : float or None
            `[energy]`; ``None`` removes the present thermostat.
        rate : float
            Mean rate at which each particle gets a new velocity `[1 / time]`.
        axes : list of str
            Axes along which new velocities are drawn: any of ``"x"``, ``"y"`` and ``"z"``.

        Raises
        ------
        ValueError, TypeError
            If a number is not positive, no particle moves along the axes, or no rate is given. The simulation
            and its thermostat then stay unchanged.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> simulation.set_thermostat(2.0, rate=5.0)
        >>> _ = simulation.advance(2.0)
        >>> bool(abs(simulation.temperature - 2.0) < 0.5), simulation.event_counts["thermostat"] > 500
        (True, True)
        """
        if temperature is None:
            self._core.set_thermostat(None)
            return
        if rate is None:
            raise ValueError("rate: expected how often each particle gets a new velocity, such as rate=1.0")
        named = list(axes)
        wrong = [name for name in named if not isinstance(name, str) or name not in tuple(_AXES)]
        if wrong:
            raise ValueError(f"axes: expected some of 'x', 'y' and 'z', found {shown(wrong[0])}")
        has_x, has_y, has_z = (name in named for name in _AXES)
        self._core.set_thermostat((finite("temperature", temperature), finite("rate", rate), (has_x, has_y, has_z)))
