"""Every mistake raises an exception of the right type with its cure, and leaves nothing half done."""

from __future__ import annotations

import copy
import pickle
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import carom
from conftest import FALLING

N = 108
GOOD = np.zeros((N, 3))


def changed(scene: dict, key: str, value: Any) -> dict:
    """The scene with one value changed; the path of the value has dots."""
    *path, last = key.split(".")
    inner: Any = scene
    for step in path:
        inner = inner[int(step)] if step.isdigit() else inner[step]
    inner[last] = value
    return scene


@pytest.mark.parametrize(
    ("key", "value", "kind", "words"),
    [
        ("sead", 3, carom.SceneError, "did you mean `seed`"),
        ("species.0.mass", -1.0, carom.SceneError, "expected a positive finite number"),
        ("species.0.mass", float("nan"), carom.SceneError, "expected a positive finite number"),
        ("species.0.mass", None, TypeError, "leave the key out"),
        ("species.0.mass", 1j, TypeError, "species.0.mass: expected a number"),
        ("species.0.mass", b"1", TypeError, "a scene cannot contain a value of type bytes"),
        ("species.0.name", bytearray(b"A"), TypeError, "a scene cannot contain a value of type bytearray"),
        ("interaction.0.species", {"sphere"}, TypeError, "a scene cannot contain a value of type set; use a list"),
        ("seed", 2**70, OverflowError, "from -2^63"),
        ("fill.0.count", 1.5, carom.SceneError, "count"),
        ("fill.0.packing_fraction", 0.9, carom.SceneError, "0.7"),
        ("species", {1: 2}, TypeError, "keys that are strings"),
        ("interaction.0.species", ["sphere", "cube"], carom.SceneError, "cube"),
    ],
)
def test_invalid_values_in_a_scene_are_rejected(fluid: dict, key: str, value: Any, kind: type, words: str) -> None:
    with pytest.raises(kind, match=words.replace("^", r"\^").replace("`", ".")):
        carom.Scene(changed(fluid, key, value))


def test_scene_rejects_unreadable_files_and_wrong_types(fluid: dict, tmp_path: Path) -> None:
    with pytest.raises(carom.SceneError, match="cannot read"):
        carom.Scene("no/such/file.toml")
    with pytest.raises(TypeError, match="from_toml"):
        carom.Scene("seed = 1\nspecies = []")
    for bad in (3, None, ["a"]):
        with pytest.raises(TypeError, match="expected the path"):
            carom.Scene(bad)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="expected the text"):
        carom.Scene.from_toml(b"seed = 1")  # type: ignore[arg-type]
    (tmp_path / "latin.toml").write_bytes(b"name = '\xff'")
    with pytest.raises(carom.SceneError, match="cannot read"):
        carom.Scene(tmp_path / "latin.toml")
    for seed, kind in ((-1, ValueError), (1.5, TypeError), ("one", TypeError), (True, TypeError), (2**64, ValueError)):
        with pytest.raises(kind, match="seed: expected a whole number"):
            carom.Scene(fluid, seed=seed)  # type: ignore[arg-type]


def test_scene_error_has_line_problem_and_cure(fluid: dict) -> None:
    text = "seed = 1\nsead = 2\n"
    with pytest.raises(carom.SceneError) as caught:
        carom.Scene.from_toml(text, name="mine.toml")
    error = caught.value
    assert (error.line, error.problem) == (2, "unknown key `sead`")
    assert "mine.toml:2:1" in str(error) and error.cure == "did you mean `seed`?"
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again), again.line, again.cure) == (carom.SceneError, str(error), 2, error.cure)
    with pytest.raises(ValueError):
        carom.Scene.from_toml(text)


@pytest.mark.parametrize(
    ("value", "kind", "words"),
    [
        (np.zeros((N, 2)), ValueError, r"an array of shape \(108, 3\), found \(108, 2\)"),
        (np.zeros((N - 1, 3)), ValueError, r"found \(107, 3\)"),
        (np.zeros(3 * N), ValueError, r"found \(324,\)"),
        (np.zeros((N, 3), dtype=complex), TypeError, "real numbers, found an array of complex128"),
        (np.full((N, 3), "a"), TypeError, "real numbers"),
        (np.full((N, 3), None), TypeError, "real numbers, found an array of object"),
        (np.zeros((N, 3), dtype=bool), TypeError, "real numbers, found an array of bool"),
        (np.where(np.arange(3 * N).reshape(N, 3) == 7, np.nan, 0.0), ValueError, "particle 2 is not a number"),
        (np.where(np.arange(3 * N).reshape(N, 3) == 7, np.inf, 0.0), ValueError, "particle 2 is not a number"),
        (5.0, ValueError, r"found \(\)"),
        (None, TypeError, "real numbers"),
        (np.ma.masked_less(np.arange(3.0 * N).reshape(N, 3), 1.0), ValueError, "masked"),
    ],
)
def test_invalid_arrays_are_rejected_without_changes(fluid: dict, value: Any, kind: type, words: str) -> None:
    simulation = carom.Simulation(fluid)
    before = simulation.velocities, simulation.positions
    with pytest.raises(kind, match="velocities: .*" + words):
        simulation.velocities = value
    with pytest.raises(kind, match="positions: .*" + words):
        simulation.positions = value
    assert (simulation.velocities == before[0]).all() and (simulation.positions == before[1]).all()
    assert simulation.advance(events=10) == "events"


def test_arrays_of_any_layout_are_taken(fluid: dict) -> None:
    simulation = carom.Simulation(fluid)
    wanted = np.arange(3 * N, dtype=float).reshape(N, 3) % 5 - 2
    big_endian = wanted.astype(">f8")
    for array in (wanted, np.asfortranarray(wanted), big_endian, wanted.astype(np.int8), wanted[::-1][::-1], wanted.tolist()):
        simulation.velocities = array
        assert (simulation.velocities == wanted).all()
    simulation.velocities = wanted.astype(np.float32)
    assert (simulation.velocities == wanted).all()


def test_overlaps_are_refused(fluid: dict) -> None:
    simulation = carom.Simulation(fluid)
    with pytest.raises(ValueError, match="overlaps with particle"):
        simulation.positions = GOOD
    assert simulation.deepest_overlap < 1e-12


@pytest.mark.parametrize(
    ("keywords", "kind", "words"),
    [
        ({}, ValueError, "expected a duration"),
        ({"duration": -1.0}, ValueError, "at least 0"),
        ({"duration": float("nan")}, ValueError, "finite"),
        ({"duration": float("inf")}, ValueError, "finite"),
        ({"duration": "long"}, TypeError, "expected a number"),
        ({"duration": 1j}, TypeError, "expected a number"),
        ({"duration": "1"}, TypeError, "duration: expected a number, found '1'"),
        ({"duration": b"1"}, TypeError, "duration: expected a number"),
        ({"duration": True}, TypeError, "duration: expected a number, found True"),
        ({"duration": np.True_}, TypeError, "duration: expected a number"),
        ({"duration": np.str_("1")}, TypeError, "duration: expected a number"),
        ({"duration": np.complex128(1)}, TypeError, "duration: expected a number"),
        ({"duration": np.array([1.0])}, TypeError, "duration: expected a number"),
        ({"duration": 10**400}, ValueError, "duration: expected a finite number"),
        ({"until": "1"}, TypeError, "until: expected a number"),
        ({"until": True}, TypeError, "until: expected a number"),
        ({"events": True}, TypeError, "whole number"),
        ({"events": np.True_}, TypeError, "whole number"),
        ({"events": np.array(2.7)}, TypeError, "whole number"),
        ({"events": -1}, ValueError, "from 0"),
        ({"events": 1.5}, TypeError, "whole number"),
        ({"events": "many"}, TypeError, "whole number"),
        ({"until": -5.0}, ValueError, "the current time"),
        ({"events": 1, "stop": 3}, TypeError, "a function"),
        ({"events": 1, "kinds": "core"}, ValueError, "has no effect without stop"),
        ({"events": 1, "stop": bool, "kinds": "kore"}, ValueError, "'kore'"),
    ],
)
def test_advance_rejects_invalid_ends(fluid: dict, keywords: dict, kind: type, words: str) -> None:
    with pytest.raises(kind, match=words):
        carom.Simulation(fluid).advance(**keywords)


def test_numbers_of_any_kind_are_taken(fluid: dict) -> None:
    from decimal import Decimal
    from fractions import Fraction

    simulation = carom.Simulation(fluid)
    for duration in (1, 1.0, np.float32(1.0), np.int8(1), np.array(1.0), Fraction(2, 2), Decimal(1)):
        simulation.advance(duration)
    assert simulation.time == 7.0
    before = simulation.event_counts["core"]
    for events in (2, 2.0, np.float32(2.0), np.uint8(2), np.array(2)):
        simulation.advance(events=events)
    assert simulation.event_counts["core"] == before + 10


def test_wrong_types_of_numbers_and_flags_are_rejected(fluid: dict, tmp_path: Path) -> None:
    carom.run(fluid, tmp_path / "run")
    calls = [
        ("checkpoint_every", lambda: carom.run(fluid, tmp_path / "new", checkpoint_every="300")),
        ("checkpoint_every", lambda: carom.run(fluid, tmp_path / "new", checkpoint_every=True)),
        ("checkpoint_every", lambda: carom.resume(tmp_path / "run", checkpoint_every="300")),
        ("checkpoint_every", lambda: carom.sweep(fluid, seeds=1, out=tmp_path / "new", checkpoint_every=True)),
        ("until_time", lambda: carom.run(fluid, tmp_path / "new", until_time=np.True_)),
        # A string must not be used as `force=True`, which would delete the existing run.
        ("force", lambda: carom.run(fluid, tmp_path / "run", seed=2, force="no")),
        ("force", lambda: carom.sweep(fluid, seeds=1, out=tmp_path / "new", force="no")),
        ("plan", lambda: carom.Simulation(fluid, plan="no")),
        ("keep_states", lambda: carom.Simulation(fluid).set_positions(carom.Scene(fluid).positions, keep_states="no")),
        ("frame", lambda: carom.open(tmp_path / "run").frames["0"]),
    ]
    for name, call in calls:
        with pytest.raises(TypeError, match=name if name != "frame" else "integer"):
            call()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run"]
    assert carom.open(tmp_path / "run").summary["seed"] == 1


def test_empty_path_is_rejected(fluid: dict, tmp_path: Path) -> None:
    for call in (lambda: carom.run(fluid, ""), lambda: carom.sweep(fluid, seeds=1, out=""), lambda: carom.open("")):
        with pytest.raises(ValueError, match="empty string"):
            call()
    assert not list(tmp_path.iterdir())


def test_events_rejects_invalid_arguments(fluid: dict) -> None:
    simulation = carom.Simulation(fluid)
    for keywords, kind in (({"events": 1, "batch": 0}, ValueError), ({}, ValueError), ({"events": 1, "kinds": 3}, TypeError)):
        with pytest.raises(kind):
            simulation.events(**keywords)  # type: ignore[arg-type]
    assert list(simulation.events(events=0)) == []


def test_simulation_rejects_a_scene_with_a_run_plan(fluid: dict) -> None:
    planned = changed(fluid, "run.equilibration_events", 100)
    with pytest.raises(carom.SceneError, match="use carom.run"):
        carom.Simulation(planned)
    assert carom.Simulation(planned, plan=False).time == 0.0


def test_a_scene_is_pickled_with_its_start(fluid: dict) -> None:
    simulation = carom.Simulation(fluid)
    scene = pickle.loads(pickle.dumps(simulation.scene))
    assert (carom.Simulation(scene).positions == simulation.positions).all()
    assert (copy.deepcopy(simulation).positions == simulation.positions).all()


def test_simulation_in_use_by_another_thread_raises(fluid: dict) -> None:
    simulation = carom.Simulation(fluid)
    done = threading.Event()

    def work() -> None:
        simulation.advance(events=3_000_000)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    errors = 0
    while not done.is_set():
        try:
            simulation.time
        except RuntimeError as error:
            assert "another thread" in str(error)
            errors += 1
        time.sleep(0.001)
    thread.join()
    # Python code ran at the same time, so the simulation did not hold the lock of Python.
    assert errors > 10
    assert simulation.event_counts["core"] == 3_000_000


class Late(Exception):
    pass


def interrupted_after(seconds: float, call: Any, ready: Callable[[], bool] = lambda: True) -> None:
    """Calls the function and sends it a signal, as soon as all is ready for it."""

    def ring(*_: object) -> None:
        if ready():
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            raise Late

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds, 0.02)
    try:
        with pytest.raises(Late):
            call()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_a_signal_ends_a_call_and_nothing_is_lost(fluid: dict) -> None:
    simulation = carom.Simulation(fluid)
    interrupted_after(0.2, lambda: simulation.advance(events=10**12))
    count = simulation.event_counts["core"]
    assert count > 100
    other = carom.Simulation(fluid)
    other.advance(events=count)
    assert (other.positions == simulation.copy().positions).all() or other.time <= simulation.time
    simulation = carom.Simulation(fluid)
    interrupted_after(0.2, lambda: next(iter(simulation.events(events=10**12, batch=10**9))))
    with pytest.raises(ValueError, match="call events"):
        simulation.advance(events=1)
    count = simulation.event_counts["core"]
    found = np.concatenate(list(simulation.events(events=7)))
    expected = np.concatenate(list(carom.Simulation(fluid).events(events=count + 7)))
    assert len(found) == count + 7 and (found == expected).all()


def test_a_signal_ends_a_run_that_can_go_on(fluid: dict, tmp_path: Path) -> None:
    long = changed(fluid, "run.until_events", 10**12)
    interrupted_after(0.5, lambda: carom.run(long, tmp_path / "run"))
    cut = carom.open(tmp_path / "run")
    assert cut.summary["ending"] == "interrupted" and not cut.is_sound
    events = cut.summary["events"]["total"] + 1000
    resumed = carom.resume(tmp_path / "run", until_events=events)
    whole = carom.run(long, tmp_path / "whole", until_events=events)
    assert (resumed.frames[-1].positions == whole.frames[-1].positions).all()


def test_a_signal_ends_a_sweep_that_can_go_on(fluid: dict, tmp_path: Path) -> None:
    long = changed(fluid, "run.until_events", 2_000_000)
    begun = lambda: len(list((tmp_path / "sweep").glob("*/thermo.csv.partial"))) == 2  # noqa: E731
    interrupted_after(0.02, lambda: carom.sweep(long, seeds=2, out=tmp_path / "sweep", jobs=2), begun)
    assert set(carom.open(tmp_path / "sweep").table["state"]) == {"begun"}
    finished = carom.sweep(long, seeds=2, out=tmp_path / "sweep")
    alone = carom.run(long, tmp_path / "alone", seed=2)
    assert finished.runs[1] is not None
    assert (finished.runs[1].frames[-1].positions == alone.frames[-1].positions).all()


def test_a_signal_ends_an_exchange_that_can_go_on(tmp_path: Path) -> None:
    from test_documentation import PAIR

    pair = changed(copy.deepcopy(PAIR), "run.until_time", 40_000.0)
    begun = (tmp_path / "parts" / "exchange.csv.partial").exists
    interrupted_after(0.02, lambda: carom.exchange(pair, tmp_path / "parts", jobs=2), begun)
    with pytest.raises(carom.FolderError, match="continue it with carom.exchange"):
        carom.open(tmp_path / "parts")
    parts, whole = (carom.exchange(pair, tmp_path / name) for name in ("parts", "whole"))
    assert (parts.potential_energies == whole.potential_energies).all()


def test_invalid_folders_are_rejected(fluid: dict, tmp_path: Path) -> None:
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "thesis.tex").write_text("")
    with pytest.raises(carom.FolderError, match="thesis"):
        carom.run(fluid, tmp_path / "thesis")
    assert [path.name for path in (tmp_path / "thesis").iterdir()] == ["thesis.tex"]
    carom.run(fluid, tmp_path / "run")
    with pytest.raises(carom.FolderError) as caught:
        carom.run(fluid, tmp_path / "run")
    assert caught.value.cure
    carom.run(fluid, tmp_path / "run", seed=2, force=True)
    assert carom.open(tmp_path / "run").summary["seed"] == 2
    for bad, kind in (("nowhere", carom.FolderError), (3, TypeError), ("a\0b", ValueError), (tmp_path / "thesis", carom.FolderError)):
        with pytest.raises(kind):
            carom.open(bad)  # type: ignore[arg-type]
    with pytest.raises(carom.FolderError):
        carom.resume(tmp_path / "thesis")
    (tmp_path / "run" / "summary.json").write_text("{")
    with pytest.raises(carom.FolderError, match="cannot read"):
        carom.open(tmp_path / "run")


@pytest.mark.parametrize(
    ("keywords", "kind"),
    [
        ({"until_time": -1.0}, ValueError),
        ({"until_time": float("nan")}, ValueError),
        ({"until_time": "1"}, TypeError),
        ({"until_events": 0}, ValueError),
        ({"until_events": 0.5}, TypeError),
        ({"checkpoint_every": 0.0}, ValueError),
        ({"threads": 0}, ValueError),
        ({"threads": 65}, ValueError),
        ({"threads": "all"}, ValueError),
        ({"threads": 1.5}, TypeError),
        ({"threads": True}, TypeError),
        ({"set": {3: 4}}, TypeError),
        ({"set": {"run.until_evnets": 4}}, carom.SceneError),
    ],
)
def test_run_rejects_invalid_arguments(fluid: dict, keywords: dict, kind: type, tmp_path: Path) -> None:
    with pytest.raises(kind):
        carom.run(fluid, tmp_path / "run", **keywords)
    assert not (tmp_path / "run").exists()


def test_closed_run_rejects_further_reading(fluid: dict) -> None:
    with carom.run(fluid) as run:
        folder = run.folder
        assert len(run.thermo["time"]) > 1
    assert not folder.exists()
    assert len(run.thermo["time"]) > 1
    for read in (lambda: run.frames, lambda: run.folder, lambda: run.report, lambda: run.page(), lambda: run.events):
        with pytest.raises(ValueError, match="closed"):
            read()


def test_temporary_run_lives_as_long_as_its_frames(fluid: dict) -> None:
    frames = carom.run(fluid).frames
    assert frames[-1].positions.shape == (N, 3)
    for bad in (len(frames), -len(frames) - 1):
        with pytest.raises(IndexError):
            frames[bad]


def test_failed_run_raises_an_error_with_its_folder(fluid: dict, tmp_path: Path) -> None:
    with pytest.raises(carom.SimulationError) as caught:
        carom.run(FALLING, tmp_path / "run")
    assert caught.value.folder == tmp_path / "run"
    assert not carom.open(caught.value.folder).is_sound


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ({"seed": [1, 1]}, "twice"),
        ({"seed": "3..1"}, "backwards"),
        ({"seed": []}, "seed has no values"),
        ({("seed", "run.until_events"): []}, "have no values"),
        ({}, "nothing varies"),
        ({"fill.0.packing_fractoin": [0.1]}, "packing_fraction"),
        ({"fill.0.packing_fraction": ["dense"]}, "dense|number"),
        ({"fill.0.packing_fraction": [float("nan")]}, "finite"),
        ({"fill.0.packing_fraction": ["0.1"]}, "string"),
        ({"run.until_events": ["100", "200"]}, "string"),
        ({("seed", "run.until_events"): [(1, 2), (3,)]}, "a list of tuples"),
    ],
)
def test_sweep_rejects_invalid_axes(fluid: dict, vary: dict, words: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=words):
        carom.sweep(fluid, vary, out=tmp_path / "sweep")
    assert not (tmp_path / "sweep").exists()


def test_sweep_rejects_arguments_of_wrong_types(fluid: dict, tmp_path: Path) -> None:
    for vary in ({"seed": 3}, {3: [1]}, {"seed": {"a": 1}}):
        with pytest.raises(TypeError):
            carom.sweep(fluid, vary, out=tmp_path / "sweep")
    with pytest.raises(TypeError, match="executor"):
        carom.sweep(fluid, seeds=2, out=tmp_path / "sweep", executor=3)  # type: ignore[arg-type]


def test_sweep_rejects_the_folder_of_another_sweep(fluid: dict, tmp_path: Path) -> None:
    carom.sweep(fluid, seeds=1, out=tmp_path / "sweep")
    with pytest.raises(carom.SweepError):
        carom.sweep(fluid, {"run.until_events": [10]}, out=tmp_path / "sweep")
    with pytest.raises(carom.SweepError):
        carom.sweep(changed(fluid, "species.0.mass", 2.0), seeds=1, out=tmp_path / "sweep")


def test_points_that_fail_are_named_and_the_others_are_there(fluid: dict, tmp_path: Path) -> None:
    with pytest.warns(carom.CaromWarning, match="1 of 2 runs failed"):
        result = carom.sweep(fluid, {"fill.0.packing_fraction": [0.1, 0.99]}, out=tmp_path / "sweep")
    assert list(result.failures) == ["packing_fraction-0.99"]
    first, second = result.runs
    assert first is not None and first.is_sound and second is None
    assert result.table["state"][0] == "done"


def test_runs_and_exchanges_reject_scenes_of_the_other_kind(fluid: dict) -> None:
    with pytest.raises(carom.SceneError, match="carom.run"):
        carom.exchange(fluid)
    with_one = {**fluid, "exchange": {"temperatures": [1.0, 1.2], "interval": 1.0, "rate": 1.0}, "run": {"until_time": 10.0}}
    with pytest.raises(carom.SceneError, match="carom.exchange"):
        carom.run(with_one)
    with pytest.raises(carom.SceneError, match="carom.exchange"):
        carom.Simulation(with_one)


def test_what_would_fill_the_disk_is_refused(fluid: dict, tmp_path: Path) -> None:
    # About 10^13 frames.
    large = {**fluid, "run": {"until_time": 1e4}, "output": {"frame_interval": 1e-9}}
    replicas = {**large, "exchange": {"temperatures": [1.0, 1.2], "interval": 1e-6, "rate": 1.0}, "output": {"frame_interval": 1e-6}}
    calls = [
        lambda **keywords: carom.run(large, tmp_path / "run", **keywords),
        lambda **keywords: carom.sweep(large, seeds=2, out=tmp_path / "sweep", **keywords),
        lambda **keywords: carom.exchange(replicas, tmp_path / "exchange", **keywords),
    ]
    for call in calls:
        with pytest.raises(carom.FolderError, match=r"would write about .* allowed without force=True\n.*force=True"):
            call()
        assert not list(tmp_path.iterdir())
    # With `force=True` there is no size limit. The calls fail because a file is in place of the folder.
    (tmp_path / "sweep").write_text("in the way")
    with pytest.raises(carom.CaromError, match="sweep"):
        calls[1](force=True)
    (tmp_path / "exchange").write_text("in the way")
    with pytest.raises(carom.CaromError, match="exchange"):
        calls[2](force=True)
    with pytest.raises(carom.FolderError, match="allowed without"):
        calls[1]()


def test_an_unknown_example_lists_those_that_there_are() -> None:
    with pytest.raises(ValueError, match="did you mean 'hopper'\\? The examples are anneal, ball, "):
        carom.example("hoper")
    assert carom.example("fluid", seed=5, set={"run.until_events": 10}).seed == 5
