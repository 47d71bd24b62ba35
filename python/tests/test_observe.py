"""User functions measure a run and change nothing in it."""

from __future__ import annotations

import filecmp
import json
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import carom

STAGED: dict[str, Any] = {
    "run": {"equilibration_time": 3.0, "until_time": 20.0},
    "stage": [{"name": "warm", "measure": True, "until_time": 2.0}],
    "output": {"frame_interval": 0.25, "thermo_interval": 0.25, "events": True},
}


def first_speed(frame: carom.Frame) -> float:
    return float((frame.velocities**2).sum(axis=1)[:10].mean())


def test_observing_changes_nothing(fluid: dict, tmp_path: Path) -> None:
    scene = {**fluid, **STAGED, "measure": {"radial_distribution": True}}
    plain = carom.run(scene, tmp_path / "plain")
    seen = carom.run(scene, tmp_path / "seen", observe={"v2": first_speed}, every=0.1)
    names = sorted(str(path.relative_to(plain.folder)) for path in plain.folder.rglob("*") if path.is_file())
    others = {"summary.json", "measurements.json", "checkpoint", ".carom", "report.txt"}
    equal, differ, missing = filecmp.cmpfiles(plain.folder, seen.folder, [name for name in names if name not in others], shallow=False)
    assert len(equal) > 10 and not differ and not missing
    one, two = (json.loads((run.folder / "summary.json").read_text()) for run in (plain, seen))
    for timed in (one, two, *one["stages"], *two["stages"]):
        timed.pop("speed", None)
    assert one == two
    measured = json.loads((seen.folder / "measurements.json").read_text())
    without = json.loads((plain.folder / "measurements.json").read_text())
    for kind in ("numbers", "curves"):
        assert [it for it in measured[kind] if it["name"] != "v2"] == without[kind]
    assert measured["stages"] == without["stages"]


def test_functions_see_the_frames_of_the_measurement(fluid: dict, tmp_path: Path) -> None:
    frames: list[carom.Frame] = []

    def keep(frame: carom.Frame) -> float:
        frames.append(frame)
        return frame.time

    run = carom.run({**fluid, **STAGED}, tmp_path / "run", observe={"kept": keep, "v2": first_speed}, every=0.25)
    assert [frame.time for frame in frames] == list(run.curves["kept"].x) == list(run.curves["kept"].y)
    assert np.allclose([frame.time for frame in frames], 5.0 + 0.25 * np.arange(1, 81), atol=1e-12)
    written = {round(frame.time, 9): frame for frame in run.frames}
    for frame in frames:
        other = written[round(frame.time, 9)]
        for name in ("positions", "velocities", "images", "ids", "species", "radii", "species_masses", "lower", "size", "periodic", "bonds"):
            assert np.array_equal(getattr(frame, name), getattr(other, name)), name
        assert frame.species_names == other.species_names and not frame.positions.flags.writeable
    assert (run.curves["v2"].y == [first_speed(frame) for frame in frames]).all()


def test_observed_values_are_ordinary_results(fluid: dict, tmp_path: Path) -> None:
    run = carom.run(fluid, tmp_path / "run", observe={"v2": first_speed, "drift": lambda frame: frame.time}, every=0.1)
    for read in (run, carom.open(tmp_path / "run")):
        series = read.curves["v2"]
        found = read.observables["v2"]
        assert found == carom.mean_and_error(series.y) and found.unit == "1" and found.is_stationary is True
        assert abs(found.mean - 3.0 * 107 / 108) < 5.0 * found.error and found.error > 0.0
        assert read.observables["drift"].is_stationary is False
    assert (run.folder / "measurements" / "v2.csv").exists() and "v2" in run.page()
    assert carom.Simulation(run).advance(events=100) == "events"
    again = carom.run(fluid, tmp_path / "run", seed=2, force=True)
    assert "v2" not in again.observables and not (run.folder / "measurements").exists()


def test_observed_values_do_not_depend_on_threads(long_fluid: dict) -> None:
    observed = {"observe": {"v2": first_speed}, "every": 0.02}
    series = [carom.run(long_fluid, **observed, threads=threads).curves["v2"].y for threads in (1, 2)]
    assert (series[0] == series[1]).all() and len(series[0]) > 30


class Stop(Exception):
    pass


def test_an_exception_ends_the_run_that_can_go_on(fluid: dict, tmp_path: Path) -> None:
    calls = 0

    def failing(frame: carom.Frame) -> float:
        nonlocal calls
        calls += 1
        if calls == 20:
            raise Stop("no more")
        return first_speed(frame)

    whole = carom.run(fluid, tmp_path / "whole", observe={"v2": first_speed}, every=0.5)
    with pytest.raises(Stop, match="no more"):
        carom.run(fluid, tmp_path / "run", observe={"v2": failing}, every=0.5)
    assert calls == 20
    cut = carom.open(tmp_path / "run")
    assert cut.summary["ending"] == "interrupted" and len(cut.curves["v2"].x) == 19
    before = {path.name: path.read_bytes() for path in (tmp_path / "run").iterdir() if path.is_file()}
    for observe in ({}, {"other": first_speed}):
        with pytest.raises(carom.SimulationError, match="`v2`.*\n.*pass observe"):
            carom.resume(tmp_path / "run", observe=observe, every=0.5 if observe else None, until_events=20_000)
    assert before == {path.name: path.read_bytes() for path in (tmp_path / "run").iterdir() if path.is_file()}
    resumed = carom.resume(tmp_path / "run", observe={"v2": first_speed}, every=0.5, until_events=20_000)
    assert (resumed.frames[-1].positions == whole.frames[-1].positions).all()
    missing = np.isin(whole.curves["v2"].x, resumed.curves["v2"].x, invert=True)
    assert missing.sum() >= 1 and missing[19] and not missing[:19].any()
    assert (whole.curves["v2"].y[~missing] == resumed.curves["v2"].y).all()


def test_observing_function_may_start_a_run(fluid: dict) -> None:
    def nested(frame: carom.Frame) -> float:
        inner = carom.run(fluid, until_events=200, observe={"inner": first_speed}, every=0.05, progress=False)
        return inner.observables["inner"].mean

    run = carom.run(fluid, observe={"outer": nested}, every=10.0)
    assert len(run.curves["outer"].y) == 3 and np.ptp(run.curves["outer"].y) == 0.0


@pytest.mark.parametrize(
    ("observe", "every", "kind", "words"),
    [
        ({"a": first_speed}, None, ValueError, "every: expected the simulated time"),
        ({}, 0.5, ValueError, "has no effect without functions in observe"),
        (None, 0.5, ValueError, "has no effect without functions in observe"),
        ({"a": first_speed}, 0.0, ValueError, "every: expected a time"),
        ({"a": first_speed}, float("nan"), ValueError, "every"),
        ({"a": first_speed}, "1", TypeError, "every"),
        (first_speed, 1.0, TypeError, "observe: expected a dictionary"),
        ({"a": 3.0}, 1.0, TypeError, "observe: expected a function of a frame for a, found 3.0"),
        ({"": first_speed}, 1.0, ValueError, "observe: expected names"),
        ({"a/b": first_speed}, 1.0, ValueError, "observe: expected names"),
        ({3: first_speed}, 1.0, ValueError, "observe: expected names"),
        ({"pressure": first_speed}, 1.0, ValueError, "the name of a built-in observable"),
        ({"a": lambda frame: float("nan")}, 1.0, ValueError, "observe: a: expected a finite number, found nan"),
        ({"a": lambda frame: frame.positions}, 1.0, TypeError, "observe: a: expected a number"),
        ({"a": lambda frame: None}, 1.0, TypeError, "observe: a: expected a number, found None"),
        ({"a": lambda: 1.0}, 1.0, TypeError, "argument"),
    ],
)
def test_run_rejects_invalid_observe_arguments(fluid: dict, observe: Any, every: Any, kind: type, words: str) -> None:
    with pytest.raises(kind, match=words):
        carom.run(fluid, observe=observe, every=every)


def of_thread(frame: carom.Frame) -> float:
    threading.current_thread()
    return first_speed(frame)


def broken(frame: carom.Frame) -> float:
    if frame.time > 1.0:
        raise ZeroDivisionError("mine")
    return 1.0


SWEPT = {"fill.0.packing_fraction": [0.1, 0.2, 0.3]}


@pytest.mark.parametrize("how", ["threads", "executor of threads", "processes"])
def test_all_points_of_a_sweep_are_observed(how: str, fluid: dict, tmp_path: Path) -> None:
    fluid["run"] = {"until_time": 4.0}
    plain = carom.sweep(fluid, SWEPT, seeds=2, out=tmp_path / "plain")
    own: dict[str, Any] = {"observe": {"v2": of_thread}, "every": 0.1}
    if how == "threads":
        seen = carom.sweep(fluid, SWEPT, seeds=2, out=tmp_path / "seen", jobs=3, **own)
    elif how == "processes":
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
            seen = carom.sweep(fluid, SWEPT, seeds=2, out=tmp_path / "seen", executor=executor, **own)
    else:
        with ThreadPoolExecutor(2) as executor:
            seen = carom.sweep(fluid, SWEPT, seeds=2, out=tmp_path / "seen", executor=executor, **own)
    assert not seen.failures and len(seen) == 6
    for at, (one, other) in enumerate(zip(plain.runs, seen.runs)):
        assert one is not None and other is not None
        assert filecmp.cmp(one.folder / "trajectory.xyz", other.folder / "trajectory.xyz", shallow=False)
        alone = carom.run(other.scene, observe={"v2": first_speed}, every=0.1)
        assert other.observables["v2"] == alone.observables["v2"]
        assert (other.curves["v2"].y == alone.curves["v2"].y).all() and len(other.curves["v2"].y) == 40
        assert seen.table["v2"][at] == pytest.approx(other.observables["v2"].mean, rel=1e-6)
    assert seen.mean["v2"].shape == (3,) and "v2" in seen.page()
    # All points have the observable `v2`, so `broken` is never called. New observables cannot be added to a sweep.
    with_others = carom.sweep(fluid, SWEPT, seeds=2, out=tmp_path / "seen", observe={"v2": broken}, every=0.1)
    assert (with_others.mean["v2"] == seen.mean["v2"]).all()
    for out in ("plain", "seen"):
        with pytest.raises(carom.SweepError, match="without speed in observe"):
            carom.sweep(fluid, SWEPT, seeds=2, out=tmp_path / out, observe={"speed": first_speed}, every=0.1)


@pytest.mark.parametrize("is_given", [False, True])
def test_an_exception_ends_a_sweep_which_goes_on(is_given: bool, fluid: dict, tmp_path: Path) -> None:
    fluid["run"] = {"until_time": 4.0}
    with ThreadPoolExecutor(2) as executor:
        given: dict[str, Any] = {"executor": executor} if is_given else {"jobs": 2}
        with pytest.raises(ZeroDivisionError, match="mine"):
            carom.sweep(fluid, SWEPT, out=tmp_path / "sweep", observe={"v2": broken}, every=0.1, **given)
        assert not carom.Sweep(tmp_path / "sweep").failures, "it was interrupted"
        result = carom.sweep(fluid, SWEPT, out=tmp_path / "sweep", observe={"v2": lambda frame: 1.0}, every=0.1, **given)
    assert not result.failures and (result.table["v2"] == 1.0).all()


def test_observed_points_continue_only_with_their_functions(fluid: dict, tmp_path: Path) -> None:
    fluid["run"] = {"until_time": 4.0}
    with pytest.raises(ZeroDivisionError):
        carom.sweep(fluid, SWEPT, out=tmp_path / "sweep", observe={"v2": broken}, every=0.1, jobs=1)
    with pytest.warns(carom.CaromWarning, match="v2"):
        carom.sweep(fluid, SWEPT, out=tmp_path / "sweep")


def test_sweep_rejects_invalid_observe_arguments_before_it_starts(fluid: dict, tmp_path: Path) -> None:
    for given, message in (({"observe": {"v2": first_speed}}, "every"), ({"every": 0.5}, "observe"), ({"observe": {"pressure": first_speed}, "every": 1.0}, "pressure")):
        with pytest.raises(ValueError, match=message):
            carom.sweep(fluid, SWEPT, out=tmp_path / "sweep", **given)
        assert not (tmp_path / "sweep").exists()
