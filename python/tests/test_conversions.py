"""Conversions of frames for other packages keep times, distances, velocities and names."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import carom

SHEARED = {
    "species": [{"name": "A", "mass": 2.0, "diameter": 1.0}],
    "interaction": [{"species": ["A", "A"], "potential": "hard-sphere"}],
    "space": {"shear_rate": 0.7},
    "fill": [{"species": "A", "arrangement": "fcc", "count": 32, "packing_fraction": 0.1, "temperature": 1.0}],
    "run": {"until_time": 10.0},
}


@pytest.mark.parametrize("kind", ["mixture", "sheared"])
def test_ase_has_the_same_distances(kind: str, mixture: dict) -> None:
    pytest.importorskip("ase")
    simulation = carom.Simulation(mixture if kind == "mixture" else SHEARED)
    simulation.advance(1.3)
    frame = simulation.frame()
    atoms = frame.to_ase()
    assert np.allclose(atoms.get_velocities(), frame.velocities, atol=1e-14)
    assert np.isclose(atoms.get_kinetic_energy(), simulation.energy["kinetic"], rtol=1e-12)
    assert np.allclose(atoms.get_all_distances(mic=True)[0], distances(frame)[0], atol=1e-9)


def distances(frame: carom.Frame) -> np.ndarray:
    """Nearest-image distances, by trying all images."""
    separation = frame.positions[:, None] - frame.positions[None]
    steps = [(-1, 0, 1) if periodic else (0,) for periodic in frame.periodic]
    shifts = [np.array([i, j, k]) @ frame.cell for i in (*steps[0], -2, 2) for j in steps[1] for k in steps[2]]
    return np.min([np.linalg.norm(separation + shift, axis=2) for shift in shifts], axis=0)


@pytest.mark.parametrize("kind", ["fluid", "sheared"])
def test_freud_has_the_same_distances(kind: str, fluid: dict) -> None:
    pytest.importorskip("freud")
    simulation = carom.Simulation(fluid if kind == "fluid" else SHEARED)
    simulation.advance(1.3)
    box, points = simulation.to_freud()
    expected = distances(simulation.frame())
    found = box.compute_all_distances(points, points)
    # In a tilted box, freud finds the nearest image only at distances below about half of the shortest edge.
    near = expected < 0.48 * simulation.scene.size.min()
    assert np.allclose(found[near], expected[near], atol=1e-4) and near.sum() > 100
    assert np.isclose(box.volume, np.prod(simulation.scene.size))


def test_mdanalysis_has_all_frames(mixture: dict, tmp_path: Path) -> None:
    pytest.importorskip("MDAnalysis")
    from MDAnalysis.lib.distances import distance_array

    run = carom.run(mixture, tmp_path / "run", until_events=2000)
    # MDAnalysis treats all axes of a box as periodic, so distances may cross the walls.
    with pytest.warns(carom.CaromWarning, match="not periodic along z"):
        universe = run.to_mdanalysis()
    assert universe.trajectory.n_frames == len(run.frames) > 3
    assert set(universe.atoms.types) == {"A", "B"} and np.isclose(universe.atoms.masses[0], 1.3)
    for step, frame in zip(universe.trajectory, run.frames):
        assert np.allclose(step.positions, frame.positions, atol=1e-5)
        assert np.allclose(step.velocities, frame.velocities, atol=1e-5)
    periodic_in_all = carom.Simulation(SHEARED)
    periodic_in_all.advance(1.0)
    frame = periodic_in_all.frame()
    universe = frame.to_mdanalysis()
    found = distance_array(universe.atoms, universe.atoms, box=universe.dimensions)
    assert np.allclose(found, distances(frame), atol=1e-4)


def test_mdanalysis_has_the_times(fluid: dict, tmp_path: Path) -> None:
    pytest.importorskip("MDAnalysis")
    from MDAnalysis.analysis.base import AnalysisFromFunction

    # The last frame is at the end of the run, after a shorter interval.
    run = carom.run(fluid, tmp_path / "run", set={"output.frame_interval": 0.25, "run.until_events": 20_000})
    times = run.frames.times
    assert len(times) > 5 and 0.0 < times[-1] - times[-2] < 0.25
    universe = run.to_mdanalysis()
    for same in (universe, universe.copy(), pickle.loads(pickle.dumps(universe))):
        assert [step.time for step in same.trajectory] == times.tolist()
        assert same.trajectory.dt == 0.25
        assert [same.trajectory[at].time for at in (3, -1, 0)] == [times[3], times[-1], times[0]]
        assert [step.time for step in same.trajectory[1:4:2]] == [times[1], times[3]]
    analysis = AnalysisFromFunction(lambda atoms: atoms.positions.mean(), universe.atoms).run()
    assert (analysis.times == times).all()
    late = run.frames[-1].to_mdanalysis()
    assert late.trajectory.time == times[-1]


def test_mdanalysis_positions_follow_straight_flights(tmp_path: Path) -> None:
    pytest.importorskip("MDAnalysis")
    alone = {
        "species": [{"name": "A", "mass": 1.0, "diameter": 1.0}],
        "interaction": [{"species": ["A", "A"], "potential": "hard-sphere"}],
        "space": {"size": [100.0, 100.0, 100.0]},
        "particle": [{"species": "A", "position": [1.0, 2.0, 3.0], "velocity": [1.5, 2.0, 0.25]}],
        "run": {"until_time": 4.0},
        "output": {"frame_interval": 0.05},
    }
    universe = carom.run(alone, tmp_path / "run").to_mdanalysis()
    steps = [(step.time, step.positions[0].copy(), step.velocities[0].copy()) for step in universe.trajectory]
    speeds = [(b - a) / (t - s) for (s, a, _), (t, b, _) in zip(steps, steps[1:])]
    assert np.allclose(speeds, [1.5, 2.0, 0.25], rtol=1e-3) and np.allclose([v for *_, v in steps], [1.5, 2.0, 0.25])


def test_mdanalysis_has_no_box_where_nothing_is_periodic(fluid: dict) -> None:
    pytest.importorskip("MDAnalysis")
    walls = {
        **fluid,
        "space": {"size": [6.0, 6.0, 6.0], "x": "walls", "y": "walls", "z": "walls"},
        "fill": [{"species": "sphere", "arrangement": "random", "count": 20, "temperature": 1.0}],
    }
    assert carom.Simulation(walls).to_mdanalysis().dimensions is None
    # Unlike an axis with walls, a flat axis does not prevent a periodic box.
    flat = {**walls, "space": {"size": [12.0, 12.0, 0.0], "z": "flat"}}
    dimensions = carom.Simulation(flat).to_mdanalysis().dimensions
    assert dimensions[:2].tolist() == [12.0, 12.0]


def surface(fluid: dict) -> dict:
    """Spheres above static spheres of another species."""
    return {
        **fluid,
        "space": {"lower": [-2.0, -1.0, 0.0], "size": [8.0, 8.0, 8.0], "z": "open"},
        "species": [*fluid["species"], {"name": "floor", "static": True, "diameter": 1.0}],
        "interaction": [
            {"species": ["sphere", "sphere"], "potential": "hard-sphere"},
            {"species": ["sphere", "floor"], "potential": "hard-sphere"},
        ],
        "fill": [],
        "particle": [
            {"species": "sphere", "position": [0.5, 0.5, 4.0], "velocity": [0.25, 0.5, -1.0]},
            {"species": "sphere", "position": [3.5, 0.5, 4.0], "velocity": [0.0, 0.0, 0.0]},
            {"species": "floor", "position": [0.5, 0.5, 1.0]},
        ],
        "run": {"until_time": 1.0},
    }


def test_files_written_by_ase_keep_all_arrays(fluid: dict, tmp_path: Path) -> None:
    pytest.importorskip("ase")
    from ase.io import read

    simulation = carom.Simulation(surface(fluid))
    simulation.advance(0.5)
    frame, atoms = simulation.frame(), simulation.to_ase()
    for name in ("frame.extxyz", "frame.xyz", "frame.traj", "frame.json"):
        atoms.write(tmp_path / name)
        again = read(tmp_path / name)
        assert np.allclose(again.get_velocities(), frame.velocities, atol=1e-7), name
        assert np.allclose(again.positions, frame.positions - frame.lower, atol=1e-7) and (again.pbc == frame.periodic).all()
    again = read(tmp_path / "frame.extxyz")
    assert again.arrays["ids"].tolist() == [0, 1, 2] and np.allclose(again.arrays["radii"], 0.5)
    assert again.arrays["species_names"].tolist() == ["sphere", "sphere", "floor"]
    assert again.info["time"] == 0.5 and again.info["origin"].tolist() == [-2.0, -1.0, 0.0]


def test_static_particles_are_at_rest_and_fixed_in_ase(fluid: dict) -> None:
    pytest.importorskip("ase")
    simulation = carom.Simulation(surface(fluid))
    atoms = simulation.to_ase()
    assert np.isfinite(atoms.get_velocities()).all()
    assert np.isclose(atoms.get_kinetic_energy(), simulation.energy["kinetic"], rtol=1e-12)
    assert atoms.constraints[0].index.tolist() == [2]
    assert carom.Simulation(fluid).to_ase().constraints == []


def test_velocities_of_unknown_masses_are_kept(tmp_path: Path) -> None:
    pytest.importorskip("ase")
    (tmp_path / "other.xyz").write_text(
        '1\nLattice="3.0 0.0 0.0 0.0 3.0 0.0 0.0 0.0 3.0" Properties=species:S:1:pos:R:3:velo:R:3 pbc="T T T"\nA 1.0 1.0 1.0 0.5 0.25 0.125\n'
    )
    frame = carom.Trajectory(tmp_path / "other.xyz")[0]
    assert np.isnan(frame.species_masses).all()
    assert frame.to_ase().get_velocities().tolist() == [[0.5, 0.25, 0.125]]


def test_unwrapped_positions_in_a_sheared_box_follow_straight_flights(tmp_path: Path) -> None:
    # A single particle has no contacts. It flies in a straight line, even across the sides of the sheared box.
    alone = {
        "species": [{"name": "A", "mass": 1.0, "diameter": 1.0}],
        "interaction": [{"species": ["A", "A"], "potential": "hard-sphere"}],
        "space": {"size": [5.0, 6.0, 7.0], "shear_rate": 0.4},
        "particle": [{"species": "A", "position": [1.0, 2.0, 3.0], "velocity": [0.5, 1.25, 0.25]}],
        "run": {"until_time": 20.0},
        "output": {"frame_interval": 0.5},
    }
    frames = carom.run(alone, tmp_path / "run").frames
    positions = frames.positions()[:, 0]
    expected = positions[0] + np.outer(frames.times, [0.5, 1.25, 0.25])
    assert np.allclose(positions[:, 1:], expected[:, 1:], atol=1e-9)
    assert np.allclose(positions[:, 0], expected[:, 0], atol=1e-9)
