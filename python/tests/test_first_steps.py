"""The first steps of a new user, the messages for them, and small properties of results."""

from __future__ import annotations

import contextlib
import gc
import threading
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import carom


def test_events_are_aligned_records(mixture: dict) -> None:
    assert carom.EVENT.isalignedstruct and carom.EVENT.itemsize == 232
    (batch,) = carom.Simulation(mixture).events(events=200)
    for name in carom.EVENT.names or ():
        assert batch[name].flags.aligned
        assert all(stride % batch[name].itemsize == 0 for stride in batch[name].strides)
    assert np.isfinite(batch["time"]).all() and (np.diff(batch["time"]) >= 0.0).all()
    assert set(batch["particle"]) <= set(range(100)) and set(batch["partner"]) <= set(range(-1, 100))


def test_events_come_by_columns(mixture: dict) -> None:
    (batch,) = carom.Simulation(mixture).events(events=200)
    (columns,) = carom.Simulation(mixture).events(events=200, columns=["time", "velocities_after", "kind"])
    assert list(columns) == ["time", "velocities_after", "kind"]
    for name, column in columns.items():
        assert np.array_equal(column, batch[name]) and column.flags.c_contiguous and column.flags.writeable
        assert np.array_equal(np.from_dlpack(column), column)
    with pytest.raises(ValueError, match="columns: expected some of time, kind, .*found 'speed'"):
        carom.Simulation(mixture).events(events=1, columns=["speed"])


def test_a_run_at_constant_pressure_goes_on_as_a_simulation(fluid: dict) -> None:
    bath = {"kind": "andersen", "temperature": 1.0, "rate": 1.0}
    barostat = {"pressure": 4.0, "interval": 0.02}
    plan = {"thermostat": bath, "barostat": barostat, "equilibration_time": 1.0, "until_time": 1.0}
    run = carom.run({**fluid, "run": plan})
    simulation = carom.Simulation(run)
    assert np.array_equal(simulation.size, run.frames[-1].size) and simulation.size[0] < 5.73
    assert simulation.thermostat is not None
    assert simulation.advance(events=1000) == "events"


def test_a_run_with_swap_moves_goes_on_as_a_simulation(fluid: dict) -> None:
    sizes = {"distribution": "uniform", "lower": 0.9, "upper": 1.1, "classes": 2}
    species = [{**fluid["species"][0], "diameter": sizes}]
    scene = {**fluid, "species": species, "run": {"until_time": 1.0, "swap": {"interval": 0.1}}}
    run = carom.run(scene)
    simulation = carom.Simulation(run)
    assert np.array_equal(simulation.frame().species, run.frames[-1].species)
    assert simulation.advance(events=1000) == "events"
    with pytest.raises(ValueError, match="swap moves"):
        carom.Simulation(scene)


def test_a_simulation_is_shown_while_another_thread_advances_it(fluid: dict) -> None:
    simulation = carom.Simulation(fluid)
    inside, go_on = threading.Event(), threading.Event()
    core = simulation._core

    class Enough(Exception):
        """Ends the advance."""

    def callback(*_: Any) -> None:
        inside.set()
        go_on.wait()
        raise Enough

    def advance() -> None:
        with contextlib.suppress(Enough):
            core.advance(float("inf"), 2**62, callback)

    thread = threading.Thread(target=advance)
    thread.start()
    inside.wait()
    try:
        texts = [repr(simulation), simulation._repr_html_()]
    finally:
        go_on.set()
        thread.join()
    for text in texts:
        assert "fluid" in text and "108 particles" in text


def test_a_temporary_run_goes_without_a_warning(fluid: dict) -> None:
    run = carom.run(fluid)
    folder = run.folder
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        del run
        gc.collect()
    assert not folder.exists()


def test_a_run_that_was_interrupted_says_so(fluid: dict) -> None:
    def interrupt(frame: carom.Frame) -> float:
        if frame.time > 1.0:
            raise KeyboardInterrupt
        return 0.0

    with pytest.raises(KeyboardInterrupt):
        carom.run({**fluid, "run": {"until_time": 5.0}}, "cut", observe={"none": interrupt}, every=0.5)
    assert "interrupted: carom.resume continues it" in repr(carom.open("cut"))
    assert "interrupted" not in repr(carom.run(fluid))


def test_pressure_tensor_does_not_change_the_verdict_on_pressure(fluid: dict) -> None:
    plain = carom.run(fluid).observables["pressure"]
    beside = carom.run(fluid, set={"measure.pressure_tensor": True}).observables["pressure"]
    assert plain.is_stationary is not None and beside.is_stationary == plain.is_stationary


def test_an_observation_that_never_happens_is_a_warning(fluid: dict) -> None:
    with pytest.warns(carom.CaromWarning, match="observe: speed has no value, because the measurement is shorter than every = 1e"):
        carom.run(fluid, observe={"speed": lambda frame: frame.velocities[0, 0]}, every=1e6)
    with pytest.warns(carom.CaromWarning, match="observe: speed has no value in 2 of 2 runs"):
        carom.sweep(fluid, seeds=2, out="sweep", observe={"speed": lambda frame: frame.velocities[0, 0]}, every=1e6)


def test_common_mistakes_get_helpful_errors(fluid: dict) -> None:
    with pytest.raises(TypeError, match="set: expected a dictionary"):
        carom.Simulation(fluid, set=[("run.until_time", 1)])  # type: ignore[arg-type]
    with pytest.raises(carom.SceneError, match=r"carom.example\('hopper'\)"):
        carom.Simulation("hopper")
    Path("file.py").write_text("import carom\n")
    with pytest.raises(carom.FolderError, match="file.py is a file"):
        carom.open("file.py")
    Path("fluid.toml").write_text(carom.Scene(fluid).to_toml())
    with pytest.raises(carom.FolderError, match="run it with carom.run"):
        carom.open("fluid.toml")
    with pytest.raises(carom.SceneError, match='z = "flat"'):
        carom.Scene({**fluid, "fill": [], "space": {"size": [4.0, 4.0, 0.0]}})
