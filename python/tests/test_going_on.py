"""Simulations that continue from the end of a run."""

from __future__ import annotations

import gc
from pathlib import Path

import numpy as np
import pytest

import carom


def staged_growth(fluid: dict) -> dict:
    """Spheres that grow in the first stage, are heated in the second, and equilibrate before a measurement with a thermostat."""
    scaled = {"kind": "rescaling", "temperature": 1.0, "interval": 0.1}
    bath = {"kind": "andersen", "temperature": 2.0, "rate": 1.0}
    stages = [
        {"name": "grow", "grow": {"rate": 0.05, "packing_fraction": 0.35}, "thermostat": scaled},
        {"name": "heat", "until_events": 500, "thermostat": bath, "measure": True},
    ]
    plan = {"equilibration_events": 700, "until_events": 2_000, "thermostat": bath}
    return {**fluid, "stage": stages, "run": plan}


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
    assert carom.Simulation(carom.run(fluid), set={"dynamics.gravity": [0, 0, -1]}).temperature is None


def test_finished_stages_and_fills_are_left_out(fluid: dict, tmp_path: Path) -> None:
    staged = {**fluid, "stage": [{"name": "warm", "until_events": 500}], "run": {"equilibration_events": 500, "until_events": 2_000}}
    simulation = carom.Simulation(carom.run(staged, tmp_path / "run"))
    assert simulation.advance(events=100) == "events"
    with pytest.raises(carom.SceneError, match="stage"):
        carom.Simulation(staged)
    # The fills of the scene are ignored. The walls and the gravity are kept.
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


def test_simulation_keeps_the_heat_bath_of_its_run(fluid: dict) -> None:
    bath = {"kind": "andersen", "temperature": 2.0, "rate": 1.0}
    run = carom.run({**fluid, "run": {"until_events": 2_000, "thermostat": bath}})
    simulation = carom.Simulation(run)
    simulation.advance(5.0)
    assert simulation.event_counts["thermostat"] > 0


def test_simulation_rejects_an_unfinished_run(fluid: dict, tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        carom.run(fluid, tmp_path / "run", observe={"a": lambda frame: 1 / 0}, every=1.0)
    with pytest.raises(carom.SceneError, match="resume"):
        carom.Simulation(carom.open(tmp_path / "run"))


def test_simulation_has_the_temperatures_of_a_run(fluid: dict, mixture: dict) -> None:
    wells = {**fluid, "interaction": [{**fluid["interaction"][0], "potential": "square-well", "lambda": 1.5, "well_depth": 0.5}]}
    for scene in (wells, {**wells, "space": {"x": "walls"}}):
        scene = {**scene, "fill": [{**scene["fill"][0], "arrangement": "random", "packing_fraction": 0.2}]}
        run = carom.run(scene)
        simulation = carom.Simulation(scene)
        for time, expected in list(zip(run.thermo["time"], run.thermo["temperature"]))[::20]:
            simulation.advance(until=time)
            assert simulation.temperature == pytest.approx(expected, rel=1e-12)
    assert carom.Simulation(mixture).temperature is None


def test_prepared_carries_out_stages_and_equilibration(fluid: dict, tmp_path: Path) -> None:
    scene = staged_growth(fluid)
    run = carom.run(scene, tmp_path / "run")
    simulation = carom.Simulation.prepared(scene, progress=False)
    frame = simulation.frame()
    assert simulation.thermostat == {"kind": "andersen", "temperature": 2.0, "rate": 1.0, "axes": ["x", "y", "z"]}
    assert frame.radii[0] > 0.5 and (frame.radii == run.frames[-1].radii).all()
    before = simulation.event_counts["core"]
    assert before > 1200, "growth, a stage and an equilibration"
    assert simulation.advance(events=2_000) == "events"
    assert simulation.time == run.summary["time"]
    assert np.array_equal(simulation.positions, run.frames[-1].positions)
    assert np.array_equal(simulation.velocities, run.frames[-1].velocities)
    assert simulation.deepest_overlap < 1e-12
    simulation.positions = simulation.positions + [0.1, 0.0, 0.0]


def test_prepared_rejects_unsuitable_plans(fluid: dict) -> None:
    plain = carom.Simulation.prepared(fluid, seed=4, progress=False)
    assert plain.time == 0.0 and np.array_equal(plain.positions, carom.Simulation(fluid, seed=4).positions)
    scaled = {"kind": "rescaling", "temperature": 1.0, "interval": 1.0}
    with pytest.raises(carom.SceneError, match="rescale"):
        carom.Simulation.prepared({**fluid, "run": {"until_events": 10, "thermostat": scaled}})
    random = [{**fluid["fill"][0], "arrangement": "random"}]
    jam = {**fluid, "fill": random, "stage": [{"name": "grow", "grow": {"rate": 10.0, "packing_fraction": 0.74}}]}
    with pytest.raises(carom.SimulationError, match="jam") as error:
        carom.Simulation.prepared(jam, progress=False)
    assert error.value.cure
    with pytest.raises(TypeError):
        carom.Simulation.prepared(fluid, progress="no")  # type: ignore[arg-type]


def test_scene_of_a_simulation_needs_no_end(fluid: dict, tmp_path: Path) -> None:
    expected = carom.Simulation(fluid)
    expected.advance(1.0)
    plan = fluid.pop("run")
    bath = {"kind": "andersen", "temperature": 1.0, "rate": 2.0}
    for lacking, missing in ((fluid, "run"), ({**fluid, "run": {"thermostat": bath}}, "run.until_time")):
        with pytest.raises(carom.SceneError, match="run") as lacks:
            carom.Scene(lacking)
        assert lacks.value.missing == missing
    text = carom.Scene({**fluid, "run": plan}).to_toml().replace("[run]\nuntil_events = 20000\n", "")
    assert "[run]" not in text
    (tmp_path / "endless.toml").write_text(text)
    for scene in (fluid, tmp_path / "endless.toml"):
        simulation = carom.Simulation(scene)
        simulation.advance(1.0)
        assert np.array_equal(simulation.positions, expected.positions)
    bathed = carom.Simulation({**fluid, "run": {"thermostat": bath}})
    assert bathed.thermostat == {**bath, "axes": ["x", "y", "z"]}
    assert carom.Simulation(fluid, set={"run.thermostat": bath}).thermostat == bathed.thermostat
    with pytest.raises(carom.SceneError, match="sead") as error:
        carom.Simulation({**fluid, "sead": 1})
    assert error.value.key == "sead" and error.value.missing is None
    with pytest.raises(carom.SceneError, match="mass"):
        carom.Simulation(fluid, set={"species.0.mass": -1.0})
    with pytest.raises(carom.SceneError, match="until_events"):
        carom.Simulation({**fluid, "run": {"until_events": -5}})
    with pytest.raises(carom.SceneError, match="until_tim"):
        carom.Simulation({**fluid, "run": {"until_tim": 1.0}})


def test_resume_accepts_a_run_object(fluid: dict, tmp_path: Path) -> None:
    run = carom.run(fluid)
    folder = run.folder
    longer = carom.resume(run, until_events=25_000, force=True)
    assert longer.folder == folder and longer.summary["events"]["total"] == 25_000
    del run
    gc.collect()
    assert len(longer.frames) > 0, "the folder goes with the last of them"
    whole = carom.run(fluid, tmp_path / "run", until_events=25_000)
    assert np.array_equal(whole.frames[-1].positions, longer.frames[-1].positions)
    longer.close()
    assert not folder.exists()
    with pytest.raises(ValueError, match="closed"):
        carom.resume(longer, until_events=30_000)
    with pytest.raises(TypeError, match="force"):
        carom.resume(whole, until_events=30_000, force=1)  # type: ignore[arg-type]
