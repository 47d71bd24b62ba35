"""Results that are read back, and their use by other packages."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import carom
from conftest import ROOT


def test_scene_from_a_dictionary_equals_its_file(tmp_path: Path) -> None:
    scenes = sorted((ROOT / "configs").glob("*.toml"))
    if not scenes:
        pytest.skip("there are no scenes beside the package")
    for path in scenes:
        scene = carom.Scene(path)
        again = carom.Scene(scene.to_dict())
        assert again.to_toml() == scene.to_toml(), path
        for name in ("positions", "velocities", "species", "bonds", "size", "lower", "periodic", "masses", "diameters"):
            assert (getattr(again, name) == getattr(scene, name)).all(), (path, name)


def test_scene_accepts_numpy_numbers(fluid: dict) -> None:
    plain = carom.Scene(fluid).to_toml()
    fluid["species"][0]["mass"] = np.float64(1.0)
    fluid["fill"][0]["count"] = np.int32(108)
    fluid["seed"] = np.uint8(1)
    fluid["interaction"][0]["species"] = np.array(["sphere", "sphere"])
    assert carom.Scene(fluid).to_toml() == plain


def test_ledgers_of_events_agree_with_the_simulation(mixture: dict) -> None:
    simulation = carom.Simulation(mixture)
    scene = simulation.scene
    start, before = simulation.energy, simulation.velocities
    events = np.concatenate(list(simulation.events(events=4_000)))
    end, counts = simulation.energy, simulation.event_counts
    kinds = {name: int((events["kind"] == at).sum()) for at, name in enumerate(carom.EVENT_KINDS)}
    assert {name: kinds[name] for name in ("core", "capture", "release", "bounce")} == {
        name: counts[name] for name in ("core", "capture", "release", "bounce")
    }
    assert sum(count for name, count in kinds.items() if name.startswith("wall")) == counts["wall"] > 0
    assert np.isclose(events["dissipated"].sum(), end["dissipated"], rtol=1e-11) and end["dissipated"] > 0
    assert np.isclose(events["energy_step"].sum(), end["pair"] - start["pair"], atol=1e-11)
    total = lambda energy: energy["kinetic"] + energy["potential"] + energy["dissipated"]  # noqa: E731
    assert np.isclose(total(start), total(end), rtol=1e-11)
    mass = scene.masses[simulation.species][events["particle"]]
    gained = mass[:, None] * (events["velocities_after"][:, 0] - events["velocities_before"][:, 0])
    assert np.allclose(gained, events["impulse"][:, None] * events["normal"], atol=1e-12)
    assert np.allclose(np.linalg.norm(events["normal"], axis=1), 1.0)
    assert (before != simulation.velocities).any()


def test_tables_have_what_the_files_have(mixture: dict, tmp_path: Path) -> None:
    run = carom.run(mixture, tmp_path / "run", set={"measure.radial_distribution": True})
    rows = (run.folder / "thermo.csv").read_text().splitlines()
    assert list(run.thermo) == rows[0].split(",") and len(run.thermo["time"]) == len(rows) - 1
    for name, at in (("time", 0), ("kinetic", rows[0].split(",").index("kinetic"))):
        assert run.thermo[name].tolist() == [float(row.split(",")[at]) for row in rows[1:]]
    assert run.thermo.units["kinetic"] == "energy"
    with pytest.raises(KeyError, match="no column"):
        run.thermo["kinetik"]
    summary = json.loads((run.folder / "summary.json").read_text())
    for name, it in summary["observables"].items():
        if it["mean"] is not None:
            assert (run.observables[name].mean, run.observables[name].error) == (it["mean"], it["standard_error"])
    for curve in run.curves.values():
        table = np.genfromtxt(run.folder / "measurements" / f"{curve.name}.csv", delimiter=",", skip_header=1)
        assert np.array_equal(table[:, 0], curve.x) and np.array_equal(table[:, 1], curve.y, equal_nan=True)
    assert isinstance(run.events["positions"], np.memmap)
    assert run.scene.seed == 3 and run.parameters["species"][0]["mass"] == 1.3


def test_what_is_conserved_says_so(fluid: dict, tmp_path: Path) -> None:
    found = carom.run(fluid, tmp_path / "run").observables
    temperature = found["temperature"]
    assert (temperature.error, temperature.is_conserved) == (0.0, True)
    assert str(temperature) == "1 (conserved) [energy]" and not found["collision_rate"].is_conserved


def test_truncated_trajectories_keep_their_complete_frames(fluid: dict, tmp_path: Path) -> None:
    run = carom.run(fluid, tmp_path / "run")
    text = (run.folder / "trajectory.xyz").read_bytes()
    for cut, frames in ((len(text) - 400, len(run.frames) - 1), (3, 0), (0, 0)):
        (tmp_path / "cut.xyz").write_bytes(text[:cut])
        assert len(carom.Trajectory(tmp_path / "cut.xyz")) == frames
    (tmp_path / "bad.xyz").write_text("hello\n")
    for name in ("bad.xyz", "none.xyz"):
        with pytest.raises(carom.FolderError, match="cannot read"):
            carom.Trajectory(tmp_path / name)


def test_unwrapped_positions_follow_straight_flights(fluid: dict, tmp_path: Path) -> None:
    alone = {
        "species": [{"name": "A", "mass": 1.0, "diameter": 1.0}],
        "interaction": [{"species": ["A", "A"], "potential": "hard-sphere"}],
        "space": {"size": [5.0, 6.0, 7.0]},
        "particle": [{"species": "A", "position": [1.0, 2.0, 3.0], "velocity": [1.5, -2.0, 0.25]}],
        "run": {"until_time": 20.0},
        "output": {"frame_interval": 1.0},
    }
    frames = carom.run(alone, tmp_path / "run").frames
    expected = np.array([1.0, 2.0, 3.0]) + np.outer(frames.times, [1.5, -2.0, 0.25])
    assert np.allclose(frames.positions()[:, 0], expected, atol=1e-12)
    within = frames.positions(unwrapped=False)[:, 0]
    assert (within >= -1e-12).all() and (within <= np.array([5.0, 6.0, 7.0]) + 1e-12).all()


def test_pages_are_in_cells(fluid: dict, tmp_path: Path) -> None:
    run = carom.run(fluid)
    html = run._repr_html_()
    assert html.startswith("<iframe srcdoc=") and "<!DOCTYPE" not in html and "canvas" in html
    assert carom.sweep(fluid, seeds=1, out=tmp_path / "sweep")._repr_html_().startswith("<iframe")


def test_the_version_is_that_of_the_crate() -> None:
    manifest = ROOT / "Cargo.toml"
    if not manifest.exists():
        pytest.skip("the crate is not beside the package")
    assert f'version = "{carom.__version__}"' in manifest.read_text()
    from importlib.metadata import version

    assert version("carom") == carom.__version__
