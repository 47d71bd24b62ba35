"""What a `stop` function may do with the simulation that calls it."""

from __future__ import annotations

import numpy as np
import pytest

import carom


def test_stop_function_cannot_advance_its_simulation(fluid: dict) -> None:
    plain = carom.Simulation(fluid)
    plain.advance(events=500)
    simulation = carom.Simulation(fluid)
    generators = [simulation.events(events=10) for _ in range(500)]
    calls = (
        lambda: simulation.advance(1.0),
        lambda: simulation.advance(events=0),
        lambda: simulation.advance(events=5, stop=lambda event: False),
        lambda: simulation.events(events=5),
        lambda: next(generators.pop()),
    )
    refused = 0

    def stop(event: np.void) -> bool:
        nonlocal refused
        for call in calls:
            with pytest.raises(RuntimeError, match="return True and continue after the call"):
                call()
            refused += 1
        return False

    assert simulation.advance(events=500, stop=stop) == "events"
    assert refused == 2500
    assert simulation.time == plain.time and (simulation.positions == plain.positions).all()
    with pytest.raises(ZeroDivisionError):
        simulation.advance(events=5, stop=lambda event: 1 / 0)
    assert simulation.advance(events=5) == "events"
    assert simulation.event_counts["core"] == 506


def test_stop_function_can_read_and_copy(fluid: dict) -> None:
    simulation = carom.Simulation(fluid)
    seen = []

    def stop(event: np.void) -> bool:
        other = simulation.copy()
        other.advance(events=1)
        seen.append((simulation.time, event["time"], other.time > simulation.time, simulation.frame().time))
        return False

    simulation.advance(events=20, stop=stop)
    assert len(seen) == 20 and all(a == b == d and c for a, b, c, d in seen)


@pytest.mark.parametrize("what", ["velocities", "positions"])
def test_change_in_a_stop_function_equals_change_between_calls(what: str, fluid: dict) -> None:
    def change(simulation: carom.Simulation) -> None:
        if what == "velocities":
            simulation.velocities = -1.25 * simulation.velocities
        else:
            simulation.positions = simulation.positions + [0.25, 0.0, 0.0]

    def stop(event: np.void) -> bool:
        if within.event_counts["core"] % 50 == 0:
            change(within)
        return False

    within = carom.Simulation(fluid)
    assert within.advance(events=300, stop=stop) == "events"
    between = carom.Simulation(fluid)
    for _ in range(6):
        between.advance(events=50)
        change(between)
    assert within.time == between.time and within.energy == between.energy
    assert (within.velocities == between.velocities).all() and (within.positions == between.positions).all()


def test_invalid_change_in_a_stop_function_ends_the_call(fluid: dict) -> None:
    simulation = carom.Simulation(fluid)

    def stop(event: np.void) -> bool:
        simulation.positions = np.zeros((108, 3))
        return False

    with pytest.raises(ValueError, match="overlaps"):
        simulation.advance(events=10, stop=stop)
    assert simulation.event_counts["core"] == 1 and simulation.deepest_overlap < 1e-12
    assert simulation.advance(events=10) == "events"
