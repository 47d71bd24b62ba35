"""Drive of simulations from outside: temperatures, and heat baths."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from carom import _carom
from carom._arguments import finite, shown, whole

__all__ = ["Driven"]

_AXES = "xyz"


class Driven:
    """Simulation whose velocities and heat bath can be changed."""

    __slots__ = ()

    _core: _carom.Simulation

    def thermalize(self, temperature: float, *, seed: int) -> None:
        """Draws new velocities for all particles that move, as ``temperature`` of a ``[[fill]]`` does at the start.

        They have Maxwell's distribution and exactly this temperature. As a whole they are at rest, along axes on which nothing changes the momentum. In a sheared
        box they are those relative to what streams. The energy that this supplies is counted.

        Parameters
        ----------
        temperature : float
            `[energy]`.
        seed : int
            Seed of the random numbers: the same one gives the same velocities, which are not those of a scene with that seed.

        Raises
        ------
        ValueError, TypeError
            If the temperature is not positive, or nothing moves; the simulation is as it was then.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> simulation.thermalize(2.0, seed=1)
        >>> round(simulation.temperature, 9), bool(abs(simulation.momentum).max() < 1e-12)
        (2.0, True)
        """
        self._core.thermalize(finite("temperature", temperature), whole("seed", seed))

    def rescale(self, temperature: float) -> None:
        """Scales all velocities to a temperature, once, relative to what :attr:`Simulation.temperature` leaves out. The energy that this supplies is counted.

        A thermostat that does so at even times is a loop with :meth:`Simulation.advance`.

        Parameters
        ----------
        temperature : float
            `[energy]`.

        Raises
        ------
        ValueError, TypeError
            If the temperature is not positive, or there is none to scale: with gravity, with fewer than two particles that move, or at rest.

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
        """Heat bath that there is now, with the keys of ``[run.thermostat]`` in a scene: ``kind``, ``temperature``, ``rate`` and ``axes``, without flat ones;
        ``None`` without one. It can be assigned, too, without ``axes`` for all.

        Raises
        ------
        ValueError, TypeError
            As :meth:`set_thermostat`, also for another kind or key.

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
            raise ValueError(f"thermostat: expected temperature, rate and axes, found {', '.join(map(str, thermostat))}")
        self.set_thermostat(thermostat["temperature"], thermostat.get("rate"), thermostat.get("axes", _AXES))

    def set_thermostat(self, temperature: float | None, rate: float | None = None, axes: Iterable[str] = _AXES) -> None:
        """Starts a heat bath in place of the one that there is: an Andersen thermostat, as that of a scene.

        Its collisions are events of the kind ``thermostat``, and the energy that they supply is counted. Each bath has random numbers of its own, of the seed of the
        scene.

        Parameters
        ----------
        temperature : float or None
            `[energy]`; ``None`` ends the bath that there is.
        rate : float
            How often each particle gets a new velocity, in the mean `[1 / time]`.
        axes : list of str
            Axes along which velocities are drawn anew: some of ``"x"``, ``"y"`` and ``"z"``.

        Raises
        ------
        ValueError, TypeError
            If a number is not positive, nothing moves along the axes, or there is no rate; the simulation, and the bath that it has, are as they were then.

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
