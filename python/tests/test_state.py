"""Simulations that are saved, pickled or copied continue with the same bits. Damaged files are rejected."""

from __future__ import annotations

import copy
import os
import pickle
import zlib
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import carom

from test_going_on import staged_growth

#: A scene that uses every kind of internal state of the engine.
CHAINS = {
    "name": "chains",
    "space": {"size": [9.0, 9.0, 9.0]},
    "species": [{"name": "A", "mass": 1.0, "diameter": 1.0}],
    "interaction": [
        {"species": ["A", "A"], "potential": "square-well", "lambda": 1.4, "well_depth": 1.0},
        {"name": "link", "potential": "bond", "shortest": 0.9, "longest": 1.2},
    ],
    "chain": [{"species": "A", "bond": "link", "count": 6, "length": 5, "temperature": 1.0}],
    "run": {"until_events": 1000, "thermostat": {"kind": "andersen", "temperature": 0.8, "rate": 0.5}},
}


def lattice_of_arrays() -> dict[str, Any]:
    positions = 2.0 * np.indices((4, 4, 4)).reshape(3, -1).T
    return {"species": "sphere", "positions": positions, "velocities": np.random.default_rng(1).normal(size=positions.shape)}


def same(one: carom.Simulation, other: carom.Simulation, events: int = 2000) -> None:
    """Both simulations are at the same event, and continue with the same bits."""
    for _ in range(2):
        assert one.time == other.time and one.event_counts == other.event_counts and one.energy == other.energy
        for name in ("positions", "velocities", "images", "captured_pairs", "species"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
        assert one.advance(events=events) == other.advance(events=events)


def simulations(fluid: dict, mixture: dict) -> list[carom.Simulation]:
    box = {**fluid, "fill": [], "space": {"size": [8.0, 8.0, 8.0]}}
    made = [carom.Simulation(scene) for scene in (fluid, mixture, CHAINS)]
    made.append(carom.Simulation(carom.Scene(box, particles=lattice_of_arrays())))
    made.append(carom.Simulation(carom.run(fluid)))
    made.append(carom.Simulation.prepared(staged_growth(fluid), progress=False))
    return made


@pytest.mark.parametrize("how", ["file", "pickle", "copy", "deepcopy"])
def test_restored_simulation_continues_with_the_same_bits(how: str, fluid: dict, mixture: dict, tmp_path: Path) -> None:
    for at, simulation in enumerate(simulations(fluid, mixture)):
        simulation.advance(events=1500)
        if how == "file":
            simulation.save(tmp_path / f"{at}")
            again = carom.Simulation.load(tmp_path / f"{at}")
        else:
            again = {"pickle": lambda it: pickle.loads(pickle.dumps(it)), "copy": copy.copy, "deepcopy": copy.deepcopy}[how](simulation)
        assert len(again) == len(simulation) and again.engine == simulation.engine
        assert again.scene.to_toml() == simulation.scene.to_toml()
        assert np.array_equal(again.frame().radii, simulation.frame().radii)
        same(simulation, again)


def test_thermostat_is_saved(fluid: dict, tmp_path: Path) -> None:
    simulation = carom.Simulation(fluid)
    simulation.set_thermostat(2.0, rate=1.0)
    simulation.advance(1.0)
    simulation.save("a")
    again = carom.Simulation.load("a")
    assert again.thermostat == simulation.thermostat
    same(simulation, again)
    # A new heat bath uses different random numbers. They depend on the number of heat baths so far, which is saved.
    for it in (simulation, again):
        it.set_thermostat(2.0, rate=1.0)
    same(simulation, again)


def test_saved_simulation_loads_in_another_folder(fluid: dict, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("box.stl").write_text(
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 1 1 1\nvertex 3 1 1\nvertex 1 3 1\nendloop\nendfacet\nendsolid a\n"
    )
    ball = {
        **fluid,
        "fill": [],
        "space": {"size": [6.0, 6.0, 6.0]},
        "particle": [{"species": "sphere", "position": [1.5, 1.5, 3], "velocity": [0, 0, -1]}],
        "surface": [{"name": "tile", "shape": "mesh", "path": "box.stl"}],
    }
    simulation = carom.Simulation(ball)
    simulation.save("a")
    os.mkdir("elsewhere")
    monkeypatch.chdir("elsewhere")
    again = carom.Simulation.load("../a")
    assert carom.Simulation(carom.Scene(again.scene, seed=3)).scene.seed == 3
    # The saved file contains the mesh, so the original file is not needed.
    os.remove("../box.stl")
    same(simulation, carom.Simulation.load("../a"), events=5)


def advanced(simulation: carom.Simulation) -> carom.Simulation:
    simulation.advance(events=2000)
    return simulation


def test_simulation_can_be_sent_to_another_process(fluid: dict) -> None:
    simulation = carom.Simulation(fluid)
    simulation.advance(events=500)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        there = executor.submit(advanced, simulation).result()
    same(advanced(simulation), there)


def test_simulation_saved_on_two_threads_equals_a_serial_one(long_fluid: dict) -> None:
    one, two = carom.Simulation(long_fluid), carom.Simulation(long_fluid, threads=2)
    for it in (one, two):
        it.advance(events=5_000)
    two.save("a")
    same(one, carom.Simulation.load("a", threads=2), events=5_000)


def resealed(content: bytes) -> bytes:
    """The content with a correct checksum."""
    return content[:-4] + zlib.crc32(content[:-4]).to_bytes(4, "little")


def test_what_is_damaged_is_refused(fluid: dict, tmp_path: Path) -> None:
    simulation = carom.Simulation(fluid)
    simulation.save("good")
    good = Path("good").read_bytes()
    assert simulation._core.to_bytes(simulation.scene._core) == good
    flipped = bytearray(good)
    flipped[len(good) // 2] ^= 4
    carom.run(fluid, "run")
    wrong = {
        "its end is missing": good[:-1],
        "end is missing": good[:20],
        "checksum is wrong": bytes(flipped),
        "first bytes are wrong": Path("run/checkpoint").read_bytes(),
        "first bytes are": b"",
        "carom 9.9.9": resealed(good[:16] + b"9.9.9".ljust(12, b"\0") + good[28:]),
        "which may continue differently": resealed(good[:28] + bytes([good[28] ^ 1]) + good[29:]),
        "or is damaged": resealed(good[:36] + bytes(200) + (200).to_bytes(8, "little") + b"1234"),
    }
    for message, content in wrong.items():
        Path("bad").write_bytes(content)
        with pytest.raises(carom.FolderError, match=message) as error:
            carom.Simulation.load("bad")
        assert error.value.cure and "bad" in str(error.value)
        with pytest.raises(carom.FolderError, match=message):
            carom._carom.Simulation.from_bytes(content)
    for path in ("none", "run", "no/such/folder/a"):
        with pytest.raises(carom.FolderError, match="cannot read"):
            carom.Simulation.load(path)
    if os.path.exists("/dev/null"):
        with pytest.raises(carom.FolderError, match="not a plain file"):
            carom.Simulation.load("/dev/null")


def test_other_files_are_replaced_only_if_asked(fluid: dict, tmp_path: Path) -> None:
    simulation = carom.Simulation(fluid)
    Path("notes.txt").write_text("mine")
    with pytest.raises(carom.FolderError, match="force=True"):
        simulation.save("notes.txt")
    assert Path("notes.txt").read_text() == "mine" and os.listdir() == ["notes.txt"]
    simulation.save("notes.txt", force=True)
    simulation.advance(1.0)
    simulation.save("notes.txt")
    assert carom.Simulation.load("notes.txt").time == 1.0 and os.listdir() == ["notes.txt"]
    with pytest.raises(carom.FolderError, match="cannot write"):
        simulation.save("no/such/folder/a")
    with pytest.raises(carom.FolderError, match="cannot write"):
        simulation.save(tmp_path)
    with pytest.raises(TypeError, match="force"):
        simulation.save("a", force="no")  # type: ignore[arg-type]


def test_everything_public_is_pickled_and_copied(fluid: dict, tmp_path: Path) -> None:
    from test_documentation import PAIR

    run = carom.run({**fluid, "stage": [{"name": "warm", "measure": True, "until_events": 500}]}, tmp_path / "run", set={"output.events": True, "measure.radial_distribution": True})
    run.frames, run.thermo, run.events
    exchange = carom.exchange({**PAIR, "run": {"until_time": 50.0}}, tmp_path / "exchange")
    sweep = carom.sweep(fluid, seeds=2, out=tmp_path / "sweep")
    things = {
        "Run": run,
        "Stage": run.stages[0],
        "Observable": run.observables["pressure"],
        "Curve": run.curves["radial_distribution"],
        "Table": run.thermo,
        "Trajectory": run.frames,
        "EventLog": run.events,
        "Frame": run.frames[-1],
        "Proof": run.verify(events=20, progress=False),
        "FileComparison": run.verify(events=20, progress=False).files,
        "Exchange": exchange,
        "AtTemperature": exchange.results[0],
        "Sweep": sweep,
        "Scene": run.scene,
        "Simulation": carom.Simulation(fluid),
        "observables": run.observables,
        "curves": run.curves,
        "energy": carom.Simulation(fluid).energy,
        "EVENT": carom.EVENT,
    }
    for error in (carom.CaromError, carom.SceneError, carom.SweepError, carom.FolderError, carom.SimulationError):
        things[error.__name__] = error("wrong", cure="right")
    missing = set(carom.__all__) - set(things) - {"EVENT_KINDS", "CaromWarning", "Writer", "__version__"}
    assert all(not isinstance(getattr(carom, name), type) for name in missing), missing
    for name, thing in things.items():
        for how in (copy.copy, copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))):
            again = how(thing)
            assert type(again) is type(thing) and repr(again) == repr(thing), name
    again = copy.deepcopy(run)
    assert len(again.frames) == len(run.frames) and again.frames[-1].time == run.frames[-1].time
    assert (copy.deepcopy(run.frames[-1]).positions == run.frames[-1].positions).all()
    assert (copy.deepcopy(run.curves)["radial_distribution"].y == run.curves["radial_distribution"].y).all()
    first = run.frames[-1].positions[0, 0]
    for copied in (copy.deepcopy(run.frames[-1]).positions, pickle.loads(pickle.dumps(run.frames[-1])).positions):
        copied[0, 0] = first + 1.0
        assert run.frames[-1].positions[0, 0] == first
