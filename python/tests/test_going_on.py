"""Simulations that go on from the end of a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import carom


def test_a_simulation_goes_on_from_a_run(fluid: dict, tmp_path: Path) -> None:
    run = carom.run(fluid, tmp_path / "run")
    longer = carom.run(fluid, tmp_path / "longer", until_events=25_000)
    simulation = carom.Simulation(run)
    assert simulation.time == run.summary["time"] and simulation.event_counts["core"] == 0
    assert simulation.temperature == pytest.approx(1.0, rel=1e-12)
    frame = run.frames[-1]
    assert np.array_equal(simulation.positions, frame.positions) and np.array_equal(simulation.images, frame.images)
    simulation.advance(events=5_000)
    assert np.array_equal(simulation.positions, longer.frames[-1].positions)
    assert np.array_equal(simulation.velocities, longer.frames[-1].velocities)
    # Values can be replaced, and a temporary run does.
    assert carom.Simulation(carom.run(fluid), set={"dynamics.gravity": [0, 0, -1]}).temperature is None


def test_what_is_over_is_left_out(fluid: dict, tmp_path: Path) -> None:
    staged = {**fluid, "stage": [{"name": "warm", "until_events": 500}], "run": {"equilibration_events": 500, "until_events": 2_000}}
    simulation = carom.Simulation(carom.run(staged, tmp_path / "run"))
    assert simulation.advance(events=100) == "events"
    with pytest.raises(carom.SceneError, match="stage"):
        carom.Simulation(staged)
    # So are fills, in boxes that they have made; walls, wells and gravity stay.
    chain = carom.run(
        {
            **fluid,
            "space": {"size": [8.0, 8.0, 8.0], "z": "walls"},
            "dynamics": {"gravity": [0.0, 0.0, -0.1]},
            "fill": [{"species": "sphere", "arrangement": "random", "count": 60, "temperature": 1.0}],
        }
    )
    simulation = carom.Simulation(chain)
    simulation.advance(events=1_000)
    assert simulation.event_counts["wall"] > 0 and len(simulation) == 60


def test_a_heat_bath_stays(fluid: dict) -> None:
    bath = {"kind": "andersen", "temperature": 2.0, "rate": 1.0}
    run = carom.run({**fluid, "run": {"until_events": 2_000, "thermostat": bath}})
    simulation = carom.Simulation(run)
    simulation.advance(5.0)
    assert simulation.event_counts["thermostat"] > 0


def test_runs_that_are_not_over(fluid: dict, tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        carom.run(fluid, tmp_path / "run", observe={"a": lambda frame: 1 / 0}, every=1.0)
    with pytest.raises(carom.SceneError, match="resume"):
        carom.Simulation(carom.open(tmp_path / "run"))


def test_the_temperature_is_that_of_a_run(fluid: dict, mixture: dict) -> None:
    wells = {**fluid, "interaction": [{**fluid["interaction"][0], "potential": "square-well", "lambda": 1.5, "well_depth": 0.5}]}
    for scene in (wells, {**wells, "space": {"x": "walls"}}):
        scene = {**scene, "fill": [{**scene["fill"][0], "arrangement": "random", "packing_fraction": 0.2}]}
        run = carom.run(scene)
        simulation = carom.Simulation(scene)
        for time, expected in list(zip(run.thermo["time"], run.thermo["temperature"]))[::20]:
            simulation.advance(until=time)
            assert simulation.temperature == pytest.approx(expected, rel=1e-12)
    assert carom.Simulation(mixture).temperature is None
