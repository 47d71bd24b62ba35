"""Results of a folder can be pickled, sent to other processes, and read back unchanged."""

from __future__ import annotations

import copy
import gc
import os
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import carom


def again(thing: Any) -> Any:
    return pickle.loads(pickle.dumps(thing))


def read_all(run: carom.Run) -> None:
    """Reads everything that a run loads on demand."""
    run.frames, run.frames.times, run.thermo, run.curves, run.observables, run.stages, run.scene, run.parameters, run.events


def test_pickled_run_is_small_and_can_be_read_elsewhere(fluid: dict, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = carom.run(fluid, "run", set={"output.events": True, "measure.radial_distribution": True})
    read_all(run)
    pickled = pickle.dumps(run)
    assert len(pickled) < 50_000, "a folder, and not what was read from it"
    os.mkdir("elsewhere")
    monkeypatch.chdir("elsewhere")
    same = pickle.loads(pickled)
    read_all(same)
    assert same.folder == tmp_path / "run" and same.observables == run.observables
    assert (same.frames[-1].positions == carom.open(tmp_path / "run").frames[-1].positions).all()


def test_parts_of_a_run_are_pickled(fluid: dict, tmp_path: Path) -> None:
    run = carom.run(fluid, tmp_path / "run", set={"output.events": True})
    frames, events = again(run.frames), again(run.events)
    assert len(frames) == len(run.frames) and frames[-1].time == run.frames[-1].time
    assert (events["time"] == run.events["time"]).all() and isinstance(events["time"], np.memmap)  # type: ignore[index]
    frame = again(run.frames[0])
    assert (frame.positions == run.frames[0].positions).all() and frame.species_names == ["sphere"]


def test_pickle_of_a_temporary_run_does_not_keep_its_folder(fluid: dict) -> None:
    run = carom.run(fluid, set={"measure.radial_distribution": True})
    frames = run.frames
    sent = again(run)
    assert len(sent.frames) == len(frames)
    # Copies of a temporary run keep its folder alive. Pickles do not.
    copies = [copy.copy(run), copy.deepcopy(run)]
    del run, frames
    gc.collect()
    assert [len(it.frames) for it in copies] == [len(sent.frames)] * 2
    del copies
    gc.collect()
    assert sent.observables["temperature"].mean == 1.0 and list(sent.curves) == ["radial_distribution"]
    for read in (lambda: sent.thermo, lambda: sent.parameters, lambda: sent.events, lambda: sent.report):
        with pytest.raises(carom.FolderError, match="pass out= to carom.run"):
            read()


def curves_of(scene: dict) -> carom.Run:
    return carom.run(scene, set={"measure.radial_distribution": True})


def test_a_temporary_run_comes_from_another_process_with_its_results(fluid: dict) -> None:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        run = executor.submit(curves_of, fluid).result()
    assert list(run.curves) == ["radial_distribution"] and run.is_sound


def test_sweeps_and_exchanges_are_pickled(fluid: dict, tmp_path: Path) -> None:
    from test_documentation import PAIR

    result = carom.sweep(fluid, seeds=2, out=tmp_path / "sweep")
    result.points, result.table, result.runs
    same = again(result)
    assert same.points == result.points and same.runs[1].summary["seed"] == 2
    exchange = carom.exchange({**PAIR, "run": {"until_time": 100.0}}, tmp_path / "exchange")
    exchange.frames, exchange.populations, exchange.attempts
    assert (again(exchange).potential_energies == exchange.potential_energies).all()
    assert len(again(exchange).frames[2]) == len(exchange.frames[2])
