"""Temperatures and thermostats of simulations."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest

import carom


def large(fluid: dict, **others: Any) -> dict:
    return {**fluid, "fill": [{**fluid["fill"][0], "count": 4000, **others}]}


def test_thermalized_velocities_are_maxwellian(fluid: dict) -> None:
    simulation = carom.Simulation(large(fluid))
    simulation.advance(events=1000)
    supplied = simulation.energy["supplied"]
    before = simulation.energy["kinetic"]
    simulation.thermalize(2.5, seed=7)
    assert simulation.temperature == pytest.approx(2.5, rel=1e-12)
    assert abs(simulation.momentum).max() < 1e-9
    assert simulation.energy["supplied"] - supplied == pytest.approx(simulation.energy["kinetic"] - before, rel=1e-12)
    v = simulation.velocities.ravel() / math.sqrt(2.5)
    # Moments of a normal distribution, within four standard errors.
    assert abs((v**4).mean() - 3.0) < 4.0 * math.sqrt(96.0 / v.size) and abs((v**3).mean()) < 4.0 * math.sqrt(15.0 / v.size)
    # The velocities depend only on the temperature and the seed, not on earlier calls or velocities.
    again = carom.Simulation(large(fluid))
    again.thermalize(2.5, seed=7)
    assert np.array_equal(again.velocities, simulation.velocities)
    again.thermalize(2.5, seed=8)
    other = again.velocities
    assert abs(np.corrcoef(other.ravel(), simulation.velocities.ravel())[0, 1]) < 0.05
    again.thermalize(1.0, seed=1)
    assert abs(np.corrcoef(again.velocities.ravel(), again.scene.velocities.ravel())[0, 1]) < 0.05
    simulation.advance(events=1000)


def test_thermalize_handles_walls_gravity_planes_and_shear(fluid: dict, mixture: dict) -> None:
    # Walls change the momentum along z, so only the momentum along x and y is zero.
    walled = carom.Simulation({**fluid, "space": {"z": "walls"}, "fill": [{**fluid["fill"][0], "arrangement": "random", "packing_fraction": 0.1}]})
    walled.thermalize(1.5, seed=1)
    assert abs(walled.momentum[:2]).max() < 1e-12 < abs(walled.momentum[2])
    assert walled.temperature == pytest.approx(1.5, rel=1e-12)
    # With gravity, a simulation has no `temperature`.
    falling = carom.Simulation(mixture)
    falling.thermalize(3.0, seed=2)
    masses = falling.scene.masses[falling.species]
    assert 0.5 * (masses[:, None] * falling.velocities**2).sum() == pytest.approx(1.5 * 3.0 * 100, rel=0.02)
    disks = {
        **fluid,
        "species": [*fluid["species"], {"name": "post", "static": True, "diameter": 1.0}],
        "interaction": [*fluid["interaction"], {"species": ["sphere", "post"], "potential": "hard-sphere"}],
        "space": {"size": [20.0, 20.0, 0.0], "z": "flat"},
        "particle": [{"species": "post", "position": [10.0, 10.0, 0.0]}],
        "fill": [{"species": "sphere", "arrangement": "random", "count": 50, "temperature": 1.0}],
    }
    plane = carom.Simulation(disks)
    plane.thermalize(0.7, seed=3)
    assert (plane.velocities[:, 2] == 0.0).all() and (plane.velocities[0] == 0.0).all()
    assert plane.temperature == pytest.approx(0.7, rel=1e-12)
    # In a sheared box, thermal velocities are relative to the streaming velocity.
    sheared = carom.Simulation({**large(fluid), "space": {"shear_rate": 0.5}})
    sheared.thermalize(1.0, seed=4)
    y = sheared.positions[:, 1] - 0.5 * sheared.scene.size[1]
    assert np.polyfit(y, sheared.velocities[:, 0], 1)[0] == pytest.approx(0.5, abs=0.05)
    assert sheared.temperature == pytest.approx(1.0, rel=1e-12)


def test_rescale_changes_thermal_velocities_only(fluid: dict, mixture: dict) -> None:
    simulation = carom.Simulation(fluid)
    drift = [0.3, 0.0, -0.2]
    simulation.velocities = simulation.velocities + drift
    directions = simulation.velocities - drift
    simulation.rescale(4.0)
    assert simulation.temperature == pytest.approx(4.0, rel=1e-12)
    assert simulation.momentum == pytest.approx(108 * np.array(drift), abs=1e-9), "what all have in common stays"
    assert simulation.velocities - drift == pytest.approx(2.0 * directions, rel=1e-9)
    at_rest = carom.Simulation(fluid)
    at_rest.velocities = 0.0 * at_rest.velocities
    for none in (at_rest, carom.Simulation(mixture)):
        velocities = none.velocities
        with pytest.raises(ValueError, match="temperature"):
            none.rescale(1.0)
        assert np.array_equal(none.velocities, velocities)


def test_rescaling_in_a_loop_equals_the_thermostat_of_a_run(fluid: dict) -> None:
    wells = {**fluid, "interaction": [{**fluid["interaction"][0], "potential": "square-well", "lambda": 1.5, "well_depth": 1.0}]}
    scaled = {"kind": "rescaling", "temperature": 1.2, "interval": 0.25}
    run = carom.run({**wells, "run": {"until_time": 2.0, "thermostat": scaled}})
    simulation = carom.Simulation({**wells, "run": {"until_time": 2.0}})
    for step in range(8):
        simulation.rescale(1.2)
        simulation.advance(until=0.25 * (step + 1))
    assert np.array_equal(simulation.positions, run.frames[-1].positions)


def test_assigned_heat_bath_acts_like_that_of_a_scene(fluid: dict) -> None:
    bath = {"kind": "andersen", "temperature": 2.0, "rate": 3.0, "axes": ["x", "z"]}
    plan = {"until_events": 1, "thermostat": bath}
    planned, plain = carom.Simulation({**fluid, "run": plan}), carom.Simulation(fluid)
    assert planned.thermostat == bath and plain.thermostat is None
    plain.thermostat = planned.thermostat
    assert plain.thermostat == bath
    plain.advance(20.0)
    assert plain.event_counts["thermostat"] > 3000
    axes = (plain.velocities**2).mean(axis=0)
    assert plain.temperature == pytest.approx(2.0, rel=0.25) and axes[1] == pytest.approx(axes[0], rel=0.6)
    # The bath acts along x and z, so only the momentum along y is conserved.
    kinetic = plain.energy["kinetic"] - 0.5 * plain.momentum[1] ** 2 / 108
    assert plain.temperature == pytest.approx(2.0 * kinetic / (3 * 108 - 1), rel=1e-12)
    plain.thermostat = None
    done = plain.event_counts["thermostat"]
    plain.advance(1.0)
    assert plain.event_counts["thermostat"] == done and plain.thermostat is None
    kinetic = plain.energy["kinetic"] - 0.5 * (plain.momentum**2).sum() / 108
    assert plain.temperature == pytest.approx(2.0 * kinetic / (3 * 108 - 3), rel=1e-12)
    assert carom.Simulation({**fluid, "run": plan}, plan=False).thermostat is None


def test_each_heat_bath_has_its_own_random_numbers(fluid: dict) -> None:
    def heated(simulation: carom.Simulation) -> np.ndarray:
        simulation.thermalize(1.0, seed=1)
        simulation.positions = simulation.scene.positions
        simulation.set_thermostat(1.0, rate=1.0)
        before = simulation.time
        simulation.advance(0.5)
        assert simulation.time == pytest.approx(before + 0.5)
        return simulation.velocities

    simulation = carom.Simulation(fluid)
    first, second = heated(simulation), heated(simulation)
    assert not np.allclose(first, second)
    assert np.array_equal(heated(carom.Simulation(fluid)), first)
    # A heat bath of a call and a heat bath of the scene use different random numbers.
    planned = {**fluid, "run": {"until_events": 1, "thermostat": {"kind": "andersen", "temperature": 1.0, "rate": 1.0}}}
    own, copied = carom.Simulation(planned), carom.Simulation(planned)
    copied.thermostat = own.thermostat
    own.advance(0.5), copied.advance(0.5)
    assert not np.allclose(own.velocities, copied.velocities)


@pytest.mark.parametrize(
    ("kind", "message", "call"),
    [
        (ValueError, "temperature", lambda it: it.thermalize(0.0, seed=1)),
        (ValueError, "temperature", lambda it: it.thermalize(-1.0, seed=1)),
        (ValueError, "finite", lambda it: it.thermalize(math.nan, seed=1)),
        (TypeError, "temperature", lambda it: it.thermalize("1", seed=1)),
        (TypeError, "seed", lambda it: it.thermalize(1.0)),
        (TypeError, "seed", lambda it: it.thermalize(1.0, seed=0.5)),
        (ValueError, "seed", lambda it: it.thermalize(1.0, seed=-1)),
        (ValueError, "temperature", lambda it: it.rescale(-1.0)),
        (TypeError, "temperature", lambda it: it.rescale(True)),
        (ValueError, "rate", lambda it: it.set_thermostat(1.0)),
        (ValueError, "rate", lambda it: it.set_thermostat(1.0, rate=0.0)),
        (ValueError, "temperature", lambda it: it.set_thermostat(0.0, rate=1.0)),
        (ValueError, "axes", lambda it: it.set_thermostat(1.0, rate=1.0, axes=["w"])),
        (ValueError, "axes", lambda it: it.set_thermostat(1.0, rate=1.0, axes=[])),
        (TypeError, "dictionary", lambda it: setattr(it, "thermostat", 1.0)),
        (ValueError, "rescale", lambda it: setattr(it, "thermostat", {"kind": "rescaling", "temperature": 1.0})),
        (ValueError, "interval", lambda it: setattr(it, "thermostat", {"kind": "andersen", "interval": 1.0})),
        (ValueError, "expected the key temperature", lambda it: setattr(it, "thermostat", {"kind": "andersen"})),
    ],
)
def test_invalid_arguments_are_rejected_without_changes(kind: type[Exception], message: str, call: Any, fluid: dict) -> None:
    simulation, other = carom.Simulation(fluid), carom.Simulation(fluid)
    for it in (simulation, other):
        it.set_thermostat(1.0, rate=2.0)
    with pytest.raises(kind, match=message):
        call(simulation)
    simulation.advance(2.0), other.advance(2.0)
    assert simulation.thermostat == other.thermostat and np.array_equal(simulation.velocities, other.velocities)


def test_simulation_without_moving_particles_has_no_temperature(fluid: dict) -> None:
    post = {
        **fluid,
        "species": [{"name": "sphere", "mass": 1.0, "diameter": 1.0}, {"name": "post", "static": True, "diameter": 1.0}],
        "space": {"size": [4.0, 4.0, 4.0]},
        "interaction": [*fluid["interaction"], {"species": ["sphere", "post"], "potential": "hard-sphere"}],
        "fill": [],
        "particle": [{"species": "post", "position": [2, 2, 2]}],
    }
    simulation = carom.Simulation(post)
    for call in (lambda: simulation.thermalize(1.0, seed=1), lambda: simulation.rescale(1.0), lambda: simulation.set_thermostat(1.0, rate=1.0)):
        with pytest.raises(ValueError, match="moving|temperature"):
            call()


def test_simulation_keeps_the_box_of_a_stage_at_constant_pressure(fluid: dict) -> None:
    barostat = {"pressure": 5.0, "interval": 0.02, "amplitude": 0.05}
    bath = {"kind": "andersen", "temperature": 1.0, "rate": 1.0}
    stage = {"name": "compress", "until_events": 5_000, "thermostat": bath, "barostat": barostat}
    simulation = carom.Simulation.prepared({**fluid, "stage": [stage]})
    run = carom.run({**fluid, "stage": [stage]}, observe={"edge": lambda frame: frame.size[0]}, every=0.1)
    edges = run.frames[-1].size
    assert edges[0] < 0.99 * simulation.scene.size[0]
    assert run.observables["edge"].mean == pytest.approx(edges[0], rel=1e-12)
    simulation.save("compressed.simulation")
    again = [simulation, simulation.copy(), pickle.loads(pickle.dumps(simulation)), carom.Simulation.load("compressed.simulation")]
    for it in again:
        frame = it.frame()
        assert np.array_equal(it.size, edges) and np.array_equal(frame.size, edges)
        moved = frame.positions + frame.images * edges
        assert np.array_equal(frame.unwrapped, moved)
    with carom.Writer("compressed.xyz") as writer:
        writer.write(simulation)
    assert np.array_equal(carom.Trajectory("compressed.xyz")[0].size, edges)
    apart = frame.positions[:, None] - frame.positions
    apart -= edges * np.round(apart / edges)
    assert np.sqrt((apart**2).sum(-1))[np.triu_indices(len(frame), 1)].min() > 1.0 - 1e-12
