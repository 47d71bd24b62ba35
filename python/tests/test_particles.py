"""Scenes with particles from arrays, frames and other packages have the same checks and bits, and are stored with the run."""

from __future__ import annotations

import os
import pickle
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import carom

BOX: dict[str, Any] = {
    "name": "box",
    "space": {"size": [12.0, 12.0, 12.0]},
    "species": [{"name": "A", "mass": 1.0, "diameter": 1.0}, {"name": "B", "mass": 2.0, "diameter": 0.8}],
    "interaction": [
        {"species": ["A", "A"], "potential": "hard-sphere"},
        {"species": ["A", "B"], "potential": "hard-sphere"},
        {"species": ["B", "B"], "potential": "square-well", "lambda": 1.5, "well_depth": 0.5},
    ],
    "run": {"until_events": 2000},
}


def arrays() -> dict[str, np.ndarray]:
    """A lattice of two moving species."""
    positions = 2.0 * np.indices((6, 6, 6)).reshape(3, -1).T + 0.125
    velocities = np.random.default_rng(7).normal(size=positions.shape)
    return {"species": np.array(["A", "B"])[np.arange(216) % 2], "positions": positions, "velocities": velocities}


def same_bits(one: Path, other: Path) -> None:
    for name in ("trajectory.xyz", "thermo.csv"):
        assert (one / name).read_bytes() == (other / name).read_bytes(), name


def test_particles_are_those_of_the_arrays() -> None:
    given = arrays()
    scene = carom.Scene(BOX, particles=given)
    assert (scene.positions == given["positions"]).all() and (scene.velocities == given["velocities"]).all()
    assert (np.array(scene.species_names)[scene.species] == given["species"]).all()
    listed = [
        {"species": str(kind), "position": position, "velocity": velocity}
        for kind, position, velocity in zip(*given.values(), strict=True)
    ]
    same = carom.Scene({**BOX, "particle": listed})
    one, other = carom.Simulation(scene), carom.Simulation(same)
    for simulation in (one, other):
        simulation.advance(3.0)
    assert (one.positions == other.positions).all() and (one.velocities == other.velocities).all()


@pytest.mark.parametrize(
    "species",
    ["B", np.arange(216) % 2, ["A", "B"] * 108, np.array(["A", "B"] * 108, dtype=object), np.zeros(216, dtype=np.uint8)],
)
def test_species_are_names_or_numbers(species: Any) -> None:
    scene = carom.Scene(BOX, particles={**arrays(), "species": species})
    numbers = {"A": 0, "B": 1}
    expected = [numbers.get(it, it) for it in ([species] * 216 if isinstance(species, str) else species)]
    assert scene.species.tolist() == expected


def test_planes_accept_arrays_with_two_columns() -> None:
    flat = {**BOX, "space": {"size": [12.0, 12.0, 0.0], "lower": [0.0, 0.0, 0.5], "z": "flat"}}
    positions = 2.0 * np.indices((6, 6)).reshape(2, -1).T
    velocities = np.ones((36, 2), dtype=np.float32)
    scene = carom.Scene(flat, particles={"species": "A", "positions": positions, "velocities": velocities})
    assert scene.dimensions == 2 and (scene.positions[:, :2] == positions).all() and (scene.positions[:, 2] == 0.5).all()
    assert scene.velocities[0].tolist() == [1.0, 1.0, 0.0]
    again = carom.Scene.from_toml(scene.to_toml())
    assert (again.positions == scene.positions).all()
    assert (pickle.loads(pickle.dumps(scene)).positions == scene.positions).all()
    run = carom.run(scene, "flat", until_events=500)
    assert (run.scene.positions == scene.positions).all()
    with pytest.raises(carom.SceneError, match="positions have two columns, but z is not flat"):
        carom.Scene(BOX, particles={"species": "A", "positions": positions})


def replaced(**values: Any) -> dict[str, Any]:
    return {**arrays(), **values}


def changed(name: str, row: int, value: Any) -> dict[str, Any]:
    found = arrays()
    found[name][row] = value
    return found


@pytest.mark.parametrize(
    ("particles", "key", "message"),
    [
        (changed("positions", 7, [np.nan, 0.0, 0.0]), "particles.positions[7][0]", "NaN, expected a finite number"),
        (changed("velocities", 9, [0.0, np.inf, 0.0]), "particles.velocities[9][1]", "inf, expected a finite number"),
        (changed("positions", 8, arrays()["positions"][3]), "particles", "particles 3 and 8 overlap at the start"),
        (changed("species", 5, "C"), "particles.species[5]", "unknown species `C`"),
    ],
)
def test_a_wrong_particle_is_named(particles: dict[str, Any], key: str, message: str) -> None:
    with pytest.raises(carom.SceneError, match=message.replace("[", r"\[")) as caught:
        carom.Scene(BOX, particles=particles)
    assert caught.value.key == key and caught.value.line is None


@pytest.mark.parametrize(
    ("particles", "kind", "message"),
    [
        (replaced(positions=np.zeros((216, 4))), ValueError, r"particles: positions: expected an array of shape \(n, 3\) or \(n, 2\)"),
        (replaced(positions=np.zeros(216)), ValueError, "expected an array of shape"),
        (replaced(positions=np.zeros((216, 3), dtype=complex)), TypeError, "expected real numbers"),
        (replaced(positions=np.ma.masked_array(np.zeros((216, 3)), mask=True)), ValueError, "masked"),
        (replaced(velocities=np.zeros((215, 3))), ValueError, r"velocities: expected an array of shape \(216, 3\)"),
        (replaced(species=np.zeros(3, dtype=int)), ValueError, "a name for each of 216 particles"),
        (replaced(species=np.full(216, 2)), ValueError, "particle 0 has the species number 2, expected one from 0 to 1"),
        (replaced(species=np.full(216, -1)), ValueError, "particle 0 has the species number -1"),
        (replaced(species=np.zeros(216)), TypeError, "expected names or numbers of species"),
        (replaced(mass=1.0), ValueError, "unknown key 'mass'"),
        ({"positions": np.zeros((1, 3))}, ValueError, "'species' is missing"),
        ([1, 2], TypeError, "expected a dictionary"),
        (replaced(bonds=[[0, 216]], bond="b"), ValueError, "from 0 to 215"),
        (replaced(positions=[[1.0, 2.0, 3.0], [1.0, 2.0]]), ValueError, "positions: expected an array, found rows of unequal lengths"),
    ],
)
def test_invalid_particle_arrays_are_rejected(particles: Any, kind: type[Exception], message: str) -> None:
    with pytest.raises(kind, match=message):
        carom.Scene(BOX, particles=particles)


def test_a_particle_in_a_wall_is_named() -> None:
    walls = {**BOX, "space": {**BOX["space"], "y": "walls"}}
    with pytest.raises(carom.SceneError, match="particle 0 extends .* beyond the lower wall of y"):
        carom.Scene(walls, particles=arrays())
    assert len(carom.Scene({**walls, "allow_invalid_start": True}, particles=arrays())) == 216


def test_a_run_keeps_its_arrays_and_is_repeated(program: str) -> None:
    scene = carom.Scene(BOX, particles=arrays(), set={"output.frame_interval": 0.5})
    run = carom.run(scene, "first")
    assert run.parameters["file"] == [{"path": "particles.xyz", "checksum": run.parameters["file"][0]["checksum"]}]
    os.rename("first", "moved")
    subprocess.run([program, "run", "moved/scene.toml", "--out", "second", "--quiet"], check=True)
    same_bits(Path("moved"), Path("second"))
    again = carom.run("moved/scene.toml", "third")
    same_bits(Path("moved"), again.folder)
    carom.run(carom.Scene(BOX, particles=arrays()), "moved", force=True)
    assert Path("moved/particles.xyz").exists()
    carom.run({**BOX, "particle": [{"species": "A", "position": [1, 1, 1], "velocity": [1, 0, 0]}], "run": {"until_time": 1.0}}, "moved", force=True)
    assert not Path("moved/particles.xyz").exists()


def test_a_run_with_arrays_goes_on() -> None:
    scene = carom.Scene(BOX, particles=arrays())
    whole = carom.run(scene, "whole", until_events=4000)
    carom.run(scene, "parts", until_events=2000)
    carom.resume("parts", until_events=4000)
    assert Path("parts/particles.xyz").read_bytes() == (whole.folder / "particles.xyz").read_bytes()
    assert (carom.open("parts").frames[-1].positions == whole.frames[-1].positions).all()  # type: ignore[union-attr]


#: A source for beads with individual diameters.
BEADS: dict[str, Any] = {
    "name": "beads",
    "space": {"size": [12.0, 12.0, 12.0]},
    "species": [{"name": "bead", "mass": 1.0, "diameter": 1.0, "diameters": "individual"}],
    "interaction": [{"species": ["bead", "bead"], "potential": "hard-sphere"}],
    "run": {"until_events": 2000},
}


def test_individual_diameters_come_from_arrays_and_return_in_frames() -> None:
    given = arrays()
    diameters = np.random.default_rng(3).uniform(0.4, 1.6, size=216)
    scene = carom.Scene(BEADS, particles={**given, "species": "bead", "diameters": diameters})
    simulation = carom.Simulation(scene)
    simulation.advance(1.0)
    frame = simulation.frame()
    assert (2.0 * frame.radii == diameters).all() and np.isnan(frame.masses).all()
    assert np.isclose(scene.packing_fraction, np.pi / 6.0 * (diameters**3).sum() / 12.0**3)
    run = carom.run(scene, "beads")
    assert run.is_sound and (2.0 * run.frames[-1].radii == diameters).all()
    same_bits(Path("beads"), carom.run("beads/scene.toml", "again").folder)
    onwards = carom.Scene(BEADS, frame=run.frames[-1])
    assert (2.0 * carom.Simulation(onwards).frame().radii == diameters).all()


def test_wrong_individual_diameters_are_rejected() -> None:
    given = {**arrays(), "species": "bead"}
    with pytest.raises(ValueError, match="expected diameters of shape"):
        carom.Scene(BEADS, particles={**given, "diameters": np.ones(5)})
    with pytest.raises(carom.SceneError, match=r"`diameter` is missing: the species `bead` has individual diameters"):
        carom.Scene(BEADS, particles=given)
    wrong = np.ones(216)
    wrong[7] = -1.0
    with pytest.raises(carom.SceneError, match=r"diameters\[7\]"):
        carom.Scene(BEADS, particles={**given, "diameters": wrong})


def test_a_changed_file_of_particles_is_found() -> None:
    run = carom.run(carom.Scene(BOX, particles=arrays()), "run")
    text = (run.folder / "particles.xyz").read_text()
    (run.folder / "particles.xyz").write_text(text.replace("0.125", "0.25", 1))
    with pytest.raises(carom.SceneError, match="has changed"):
        run.scene  # noqa: B018


def test_scenes_with_arrays_are_pickled_and_changed() -> None:
    scene = carom.Scene(BOX, particles=arrays())
    again = pickle.loads(pickle.dumps(scene))
    assert (again.positions == scene.positions).all() and (again.species == scene.species).all()
    larger = carom.Scene(again, seed=5, set={"space.size": [20.0, 20.0, 20.0]})
    assert larger.seed == 5 and larger.size.tolist() == [20.0, 20.0, 20.0] and (larger.positions == scene.positions).all()
    other = carom.Scene(larger, particles={"species": "A", "positions": [[1.0, 2.0, 3.0]]})
    assert len(other) == 1 and other.seed == 5


def test_scene_text_contains_particles_from_arrays() -> None:
    bonded = {**BOX, "interaction": [*BOX["interaction"], {"name": "link", "potential": "bond", "lambda": 2.5}]}
    source = {**bonded, "particle": [{"species": "A", "position": [1.125, 1.125, 1.125]}]}
    scene = carom.Scene(source, particles={**arrays(), "bonds": [[0, 1], [1, 2]], "bond": "link"})
    assert scene.bonds.tolist() == [[1, 2], [2, 3]] and len(scene) == 217
    for again in (carom.Scene.from_toml(scene.to_toml()), carom.Scene(scene.to_dict()), carom.run(scene, "run").scene):
        assert (again.positions == scene.positions).all() and (again.velocities == scene.velocities).all()
        assert (again.bonds == scene.bonds).all() and (again.species == scene.species).all()


def test_fills_find_room_beside_arrays() -> None:
    source = {**BOX, "fill": [{"species": "A", "arrangement": "random", "count": 50, "temperature": 1.0}]}
    scene = carom.Scene(source, particles=arrays())
    assert len(scene) == 266 and (scene.positions[:216] == arrays()["positions"]).all()
    run = carom.run(scene, "run", until_events=500)
    assert (run.scene.positions == scene.positions).all() and (run.scene.velocities == scene.velocities).all()


def test_start_from_a_run_rejects_particle_arrays() -> None:
    carom.run(carom.Scene(BOX, particles=arrays()), "first", until_events=500)
    with pytest.raises(carom.SceneError, match="the particles come from the run"):
        carom.Scene({"start": {"from": "first"}, "run": {"until_events": 10}}, particles=arrays())


def test_sweeps_and_exchanges_have_arrays() -> None:
    small = {"species": "B", "positions": arrays()["positions"][:8], "velocities": arrays()["velocities"][:8]}
    scene = carom.Scene(BOX, particles=small, set={"run.until_events": 200})
    table = carom.sweep(scene, {"species.1.mass": [1.0, 2.0]}, out="swept", progress=False)
    assert len(table.runs) == 2 and all(run.summary["particles"] == 8 for run in table.runs)
    exchange = {"exchange": {"temperatures": [0.6, 1.0], "interval": 2.0, "rate": 1.0}, "run": {"until_time": 100.0}}
    for _ in range(2):
        found = carom.exchange(carom.Scene({**BOX, **exchange}, particles=small), out="exchanged", progress=False)
    listed = [{"species": "B", "position": place, "velocity": motion} for place, motion in zip(small["positions"], small["velocities"])]
    same = carom.exchange({**BOX, **exchange, "particle": listed}, out="listed", progress=False)
    assert np.array_equal(found.potential_energies, same.potential_energies)


def test_scene_can_start_from_a_frame(mixture: dict) -> None:
    run = carom.run(mixture, "run")
    frame = run.frames[3]
    scene = carom.Scene({**mixture, "fill": []}, frame=frame)
    assert (scene.velocities == frame.velocities).all() and np.allclose(scene.positions, frame.positions, atol=1e-12)
    assert (np.array(scene.species_names)[scene.species] == np.array(frame.species_names)[frame.species]).all()
    # A scene without a box takes the box of the frame.
    fluid = {"species": [{"name": "A", "mass": 1.0, "diameter": 1.0}], "interaction": BOX["interaction"][:1], "run": {"until_time": 1.0}}
    start = carom.Simulation({**fluid, "space": {"size": [9.0, 8.0, 7.0], "lower": [1.0, 2.0, 3.0]}, "particle": [{"species": "A", "position": [2, 3, 4]}]})
    scene = carom.Scene(fluid, frame=start.frame())
    assert scene.size.tolist() == [9.0, 8.0, 7.0] and scene.lower.tolist() == [1.0, 2.0, 3.0] and scene.periodic.all()
    again = carom.Scene.from_toml(scene.to_toml())
    assert again.size.tolist() == [9.0, 8.0, 7.0] and again.lower.tolist() == [1.0, 2.0, 3.0]
    with pytest.raises(carom.SceneError, match="a radius of 0.5, but the species `A` of the scene has 0.45"):
        carom.Scene(fluid, frame=start.frame(), set={"species.0.diameter": 0.9})
    with pytest.raises(TypeError, match="found both"):
        carom.Scene(fluid, frame=start.frame(), particles=arrays())
    with pytest.raises(TypeError, match="expected a carom.Frame"):
        carom.Scene(fluid, frame=arrays())  # type: ignore[arg-type]


def test_bonds_of_frames_keep_their_names() -> None:
    polymer = {
        "species": [{"name": "bead", "mass": 1.0, "diameter": 1.0}],
        "interaction": [
            {"species": ["bead", "bead"], "potential": "hard-sphere"},
            {"name": "link", "potential": "bond", "lambda": 1.5},
        ],
        "space": {"size": [15.0, 15.0, 15.0]},
        "chain": [{"species": "bead", "length": 5, "count": 6, "bond": "link", "temperature": 1.0}],
        "run": {"until_events": 2000},
    }
    run = carom.run(polymer, "run")
    for frame in (run.frames[-1], carom.Simulation(polymer).frame()):
        scene = carom.Scene({**polymer, "chain": [], "space": {}}, frame=frame)
        assert (scene.bonds == frame.bonds).all() and len(scene.bonds) == 24
        assert frame.bond_names == ["link"]
    with pytest.raises(carom.SceneError, match="unknown interaction `glue`"):
        carom.Scene({**polymer, "chain": []}, frame=run.frames[-1], bond="glue")


def test_scene_can_start_from_a_frame_of_a_sheared_box() -> None:
    sheared = {
        "species": [{"name": "A", "mass": 1.0, "diameter": 1.0}],
        "interaction": [{"species": ["A", "A"], "potential": "hard-sphere"}],
        "space": {"shear_rate": 0.7},
        "fill": [{"species": "A", "arrangement": "fcc", "count": 32, "packing_fraction": 0.1, "temperature": 1.0}],
        "run": {"until_time": 1.0},
    }
    simulation = carom.Simulation(sheared)
    simulation.advance(1.3)
    scene = carom.Scene({**sheared, "fill": []}, frame=simulation.frame())
    assert carom.Simulation(scene).frame().displacement == simulation.frame().displacement != 0.0
    run = carom.run(scene, "run")
    assert (run.scene.positions == scene.positions).all()
    with pytest.raises(carom.SceneError, match="displaced"):
        scene.to_toml()


def test_ase_atoms_convert_back_to_a_scene(mixture: dict) -> None:
    pytest.importorskip("ase")
    simulation = carom.Simulation({**mixture, "space": {**mixture["space"], "lower": [1.0, 2.0, 3.0]}})
    simulation.advance(1.0)
    atoms = simulation.to_ase()
    # ASE has no walls, so the scene must define them.
    scene = carom.Scene.from_ase(atoms, {**mixture, "fill": [], "space": {"z": "walls"}})
    assert np.allclose(scene.positions, simulation.positions, atol=1e-12) and np.allclose(scene.velocities, simulation.velocities, atol=1e-12)
    assert (scene.species == simulation.frame().species).all() and np.allclose(scene.lower, [1.0, 2.0, 3.0])
    with pytest.raises(carom.SceneError, match="the box that comes with the particles is not periodic along this axis"):
        carom.Scene.from_ase(atoms, {**mixture, "fill": [], "space": {}})
    atoms.set_masses(np.full(len(atoms), 2.0))
    with pytest.raises(carom.SceneError, match="has a mass of 2"):
        carom.Scene.from_ase(atoms, {**mixture, "fill": [], "space": {"z": "walls"}})


@pytest.mark.parametrize("is_flat", [False, True])
def test_trajectory_read_by_ase_converts_back_to_a_scene(mixture: dict, tmp_path: Path, is_flat: bool) -> None:
    io = pytest.importorskip("ase.io")
    source = dict(mixture)
    if is_flat:
        disks = {"species": "A", "arrangement": "random", "count": 20, "temperature": 1.0}
        size = [12.0, 12.0, 0.0]
        source = {**mixture, "dynamics": {}, "fill": [disks], "space": {"size": size, "lower": [1.0, 2.0, 0.0], "z": "flat"}}
    run = carom.run({**source, "output": {"frame_interval": 0.5}}, "run")
    frame = run.frames[-1]
    io.write(str(tmp_path / "again.xyz"), io.read("run/trajectory.xyz", index=-1), format="extxyz")
    for path in ("run/trajectory.xyz", str(tmp_path / "again.xyz")):
        atoms = io.read(path, index=-1)
        scene = carom.Scene.from_ase(atoms, {**source, "fill": [], "space": {"z": source["space"].get("z", "periodic")}})
        # ASE writes numbers with eight decimals.
        allowed = 0.0 if path.startswith("run") else 1e-8
        assert np.allclose(scene.positions, frame.positions, atol=allowed, rtol=0.0)
        assert np.allclose(scene.velocities, frame.velocities, atol=allowed, rtol=0.0) and np.abs(scene.velocities).max() > 0.1
        assert (scene.species == frame.species).all() and np.allclose(scene.size, frame.size, atol=allowed, rtol=0.0)


def test_ase_symbols_and_cells_become_species_and_boxes() -> None:
    build = pytest.importorskip("ase.build")
    salt = build.bulk("NaCl", "rocksalt", a=2.4, cubic=True).repeat(3)
    source = {
        "species": [{"name": "Na", "mass": 1.0, "diameter": 1.0}, {"name": "Cl", "mass": 1.0, "diameter": 1.2}],
        "interaction": [{"species": list(pair), "potential": "hard-sphere"} for pair in (("Na", "Na"), ("Na", "Cl"), ("Cl", "Cl"))],
        "run": {"until_time": 1.0},
    }
    scene = carom.Scene.from_ase(salt, source)
    assert np.bincount(scene.species).tolist() == [108, 108] and np.allclose(scene.size, 7.2)
    with pytest.raises(ValueError, match="expected a rectangular box"):
        carom.Scene.from_ase(build.bulk("Ar", "fcc", a=2.0), source, species="Na")
    # The ASE cell has an extent along the flat axis, which is ignored.
    layer = build.fcc111("Ar", (4, 4, 1), a=2.0, orthogonal=True, vacuum=3.0)
    layer.positions[:, 2] = 0.0
    flat = carom.Scene.from_ase(layer, {**source, "space": {"z": "flat"}}, species="Na")
    assert flat.dimensions == 2 and flat.size[2] == 0.0
    with pytest.raises(TypeError, match="expected ase.Atoms"):
        carom.Scene.from_ase([1, 2], source)


def test_gsd_frames_convert_back_to_a_scene(mixture: dict) -> None:
    pytest.importorskip("gsd")
    run = carom.run({**mixture, "output": {"frame_interval": 0.5, "formats": ["gsd"]}}, "run")
    source = {**mixture, "fill": [], "space": {"z": "walls"}, "allow_invalid_start": True}
    for at in (0, 3, -1):
        scene, frame = carom.Scene.from_gsd(run.folder / "trajectory.gsd", source, frame=at), run.frames[at]
        assert np.allclose(scene.positions, frame.positions, atol=1e-5) and np.allclose(scene.velocities, frame.velocities, atol=1e-5)
        assert (scene.species == frame.species).all() and np.allclose(scene.size, [9.0, 8.0, 12.0])
    with pytest.raises(IndexError, match="of"):
        carom.Scene.from_gsd(run.folder / "trajectory.gsd", source, frame=1000)
    with pytest.raises(carom.FolderError, match="cannot read"):
        carom.Scene.from_gsd("none.gsd", source)


def test_mdanalysis_universes_convert_back_to_a_scene(mixture: dict) -> None:
    pytest.importorskip("MDAnalysis")
    simulation = carom.Simulation({**mixture, "space": {"size": [9.0, 8.0, 12.0]}})
    simulation.advance(1.0)
    universe = simulation.to_mdanalysis()
    source = {**mixture, "fill": [], "space": {}, "allow_invalid_start": True}
    scene = carom.Scene.from_mdanalysis(universe, source)
    assert np.allclose(scene.positions, simulation.positions, atol=1e-5) and np.allclose(scene.velocities, simulation.velocities, atol=1e-5)
    assert np.allclose(scene.size, [9.0, 8.0, 12.0]) and scene.periodic.all()
    some = carom.Scene.from_mdanalysis(universe.select_atoms("type B"), source)
    assert len(some) == 40 and (some.species == 1).all()
    with pytest.raises(TypeError, match="expected a Universe"):
        carom.Scene.from_mdanalysis("x", source)
