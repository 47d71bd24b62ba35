"""The package gives the same bits and the same files as the program."""

from __future__ import annotations

import filecmp
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

import carom
from conftest import ROOT

#: All example scenes without replica exchange.
SCENES = sorted(path.stem for path in (ROOT / "configs").glob("*.toml") if "\n[exchange]" not in path.read_text())
SHORT = {"run.until_events": 2000, "run.equilibration_events": 500}
#: Scenes with stages get fewer particles or events, so that the test stays short.
FEWER = {
    "anneal": {f"stage.{stage}.{key.removeprefix('run.')}": value for stage in range(4) for key, value in SHORT.items()},
    "glass_former": {"stage.1.until_time": 20},
    "outlet": {"fill.0.count": 150},
    "random_packing": {"fill.0.count": 250},
    "rotating_drum": {"fill.0.count": 150},
    "silo": {"fill.0.count": 150},
    "tilting_box": {"fill.0.count": 150},
}


def files(folder: Path) -> list[str]:
    """Files of a run, without the previous checkpoint: the clock decides whether there is one."""
    paths = (path for path in folder.rglob("*") if path.is_file() and path.name != "checkpoint.previous")
    return sorted(str(path.relative_to(folder)) for path in paths)


def alike(a: Path, b: Path) -> list[str]:
    """Files that differ, except in values of the clock."""
    assert files(a) == files(b)
    different = [name for name in files(a) if not filecmp.cmp(a / name, b / name, shallow=False)]
    summaries = [json.loads((folder / "summary.json").read_text()) for folder in (a, b)]
    for summary in summaries:
        del summary["speed"]
        for stage in summary.get("stages", []):
            del stage["speed"]
    if summaries[0] == summaries[1]:
        different.remove("summary.json")
    # The report contains the speed of the run, and the checkpoints contain the wall time.
    return [name for name in different if name not in ("report.txt", "checkpoint", ".carom")]


@pytest.mark.skipif(not SCENES, reason="there are no scenes beside the package")
@pytest.mark.parametrize("scene", SCENES)
def test_run_equals_that_of_the_program(scene: str, program: str, tmp_path: Path) -> None:
    path = ROOT / "configs" / f"{scene}.toml"
    changes = SHORT | FEWER.get(scene, {})
    sets = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
    subprocess.run([program, "run", path, *sets, "--out", tmp_path / "a", "--quiet"], check=True, capture_output=True)
    carom.run(path, tmp_path / "b", set=changes)
    assert alike(tmp_path / "a", tmp_path / "b") == []


def test_threads_change_no_bit(long_fluid: dict, tmp_path: Path) -> None:
    carom.run(long_fluid, tmp_path / "one")
    for name, threads in (("three", 3), ("auto", "auto")):
        carom.run(long_fluid, tmp_path / name, threads=threads)
        assert alike(tmp_path / "one", tmp_path / name) == [], name
    one = carom.resume(tmp_path / "one", until_events=30_000)
    two = carom.resume(tmp_path / "three", until_events=30_000, threads=2)
    said = " of the steps in windows near the faces of slabs"
    assert said in two.report and said not in one.report
    assert alike(tmp_path / "one", tmp_path / "three") == []
    simulations = [carom.Simulation(long_fluid, plan=False, threads=threads) for threads in (1, 2)]
    for simulation in simulations:
        simulation.advance(events=20_000)
    assert (simulations[0].positions == simulations[1].positions).all()


def test_simulation_equals_a_run(mixture: dict, tmp_path: Path) -> None:
    run = carom.run(mixture, tmp_path / "run")
    simulation = carom.Simulation(mixture)
    events = np.concatenate(list(simulation.events(events=5_000, batch=777)))
    last = run.frames[-1]
    assert simulation.time == last.time
    for name in ("positions", "velocities", "images", "species"):
        assert (getattr(simulation, name) == getattr(last, name)).all(), name
    assert run.events is not None and len(run.events["time"]) == len(events) == 5_000
    for name in run.events:
        assert (run.events[name] == events[name]).all(), name
    assert len(set(events["kind"])) >= 5


def test_copies_and_stops_change_no_bit(mixture: dict) -> None:
    whole = carom.Simulation(mixture)
    assert whole.advance(events=3_000) == "events"
    parts = carom.Simulation(mixture)
    parts.advance(0.25)
    other = parts.copy()
    assert other.advance(events=10**6, kinds="wall", stop=lambda event: event["particle"] == 7) == "stop"
    parts = other.copy()
    for _ in parts.events(events=100, kinds=["core"], batch=3):
        parts.energy, parts.positions, parts.captured_pairs
        break
    parts.advance(events=3_000 - sum(parts.event_counts[it] for it in ("core", "capture", "release", "bounce", "wall")))
    assert whole.time == parts.time
    assert (whole.velocities == parts.velocities).all()


def test_resumed_run_equals_an_uninterrupted_one(mixture: dict, tmp_path: Path) -> None:
    whole = carom.run(mixture, tmp_path / "whole")
    carom.run(mixture, tmp_path / "parts", until_events=1_700)
    parts = carom.resume(tmp_path / "parts", until_events=5_000)
    assert (whole.frames[-1].positions == parts.frames[-1].positions).all()
    assert (whole.folder / "thermo.csv").read_bytes() == (parts.folder / "thermo.csv").read_bytes()


def test_a_sweep_goes_on_with_that_of_the_program(program: str, fluid: dict, tmp_path: Path) -> None:
    scene = tmp_path / "fluid.toml"
    scene.write_text(carom.Scene(fluid).to_toml())
    key = "fill.0.packing_fraction"
    arguments = ["--vary", f"{key}=0.05..0.25/3", "--vary", "seed=1..2", "--quiet", "--jobs", "1"]
    run = lambda *more: subprocess.run([program, "sweep", scene, *arguments, *more], check=True, capture_output=True)  # noqa: E731
    run("--out", tmp_path / "whole")
    run("--out", tmp_path / "half", "--array", "1/2")
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "half").glob("*/summary.json")}
    assert len(before) == 3
    result = carom.sweep(scene, {key: np.linspace(0.05, 0.25, 3)}, seeds=2, out=tmp_path / "half")
    assert all(path.stat().st_mtime_ns == time for path, time in before.items())
    for name in ("sweep.csv", "sweep-mean.csv", "sweep-columns.csv", "sweep.toml"):
        assert filecmp.cmp(tmp_path / "whole" / name, tmp_path / "half" / name, shallow=False), name
    assert len(result) == 6 and not result.failures
    done = subprocess.run([program, "sweep", result.folder], check=True, capture_output=True, text=True)
    assert "6 were there already" in done.stdout


def test_exchange_equals_that_of_the_program(program: str, tmp_path: Path) -> None:
    from test_documentation import PAIR

    scene = tmp_path / "pair.toml"
    scene.write_text(carom.Scene(PAIR).to_toml())
    subprocess.run([program, "exchange", scene, "--out", tmp_path / "a", "--quiet"], check=True, capture_output=True)
    carom.exchange(scene, tmp_path / "b", jobs=1)
    for name in ("exchange.csv", "energies.csv", "curves.csv", "trajectory-1.xyz"):
        assert filecmp.cmp(tmp_path / "a" / name, tmp_path / "b" / name, shallow=False), name
