"""Replica exchange in umbrella windows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import carom

DEPTH, TEMPERATURE = 0.9, 0.6
PAIR = {
    "name": "pair",
    "space": {"size": [6.0, 6.0, 6.0]},
    "species": [{"name": "A", "mass": 1.3, "diameter": 1.0}],
    "interaction": [{"species": ["A", "A"], "potential": "square-well", "lambda": 1.5, "well_depth": DEPTH}],
    "particle": [{"species": "A", "position": [1, 1, 1]}, {"species": "A", "position": [3, 3, 3]}],
    "exchange": {
        "ensemble": "umbrella",
        "temperatures": [TEMPERATURE],
        "interval": 1.0,
        "rate": 0.7,
        "umbrella": {"between": [[0], [1]], "windows": [[1.0, 1.5], [1.3, 2.0], [1.8, 2.8]], "bins": 20},
    },
    "run": {"equilibration_time": 200.0, "until_time": 8000.0},
}


def test_the_potential_of_mean_force_of_a_pair_is_its_potential(tmp_path: Path) -> None:
    result = carom.exchange(PAIR, tmp_path / "pair", progress=False)
    assert result.windows.tolist() == [[1.0, 1.5], [1.3, 2.0], [1.8, 2.8]]
    assert result.temperatures.tolist() == [TEMPERATURE] * 3 and "3 windows" in repr(result)
    distances = result.distances
    assert distances.shape == (3, 8000)
    for row, (lower, upper), mean in zip(distances, result.windows, result.observable("distance"), strict=True):
        assert row.min() >= lower and row.max() <= upper and mean.unit == "length"
        assert abs(row.mean() - mean.mean) < 1e-9
    w = result.potential_of_mean_force
    inside = w["distance"] < 1.5
    potential, error = w["potential_of_mean_force"], w["potential_of_mean_force_error"]
    # The potential of mean force is relative to the last window, which lies outside of the well.
    deviations = (potential - np.where(inside, -DEPTH, 0.0)) / error
    assert np.abs(deviations).max() < 4.5 and (deviations**2).mean() < 3.0
    difference = w["potential_of_mean_force"] - w["free_energy"]
    of_shells = 2.0 * TEMPERATURE * np.log(w["distance"])
    assert np.ptp(difference - of_shells) < 0.01
    assert carom.Exchange(tmp_path / "pair").potential_of_mean_force["distance"].shape == w["distance"].shape
    for name in ("populations", "curves", "density_of_states"):
        with pytest.raises(carom.FolderError, match="it is an exchange between windows of a distance"):
            getattr(result, name)


def test_exchange_without_windows_has_no_potential_of_mean_force() -> None:
    plain = {"temperatures": [0.5, 1.0], "interval": 1.0, "rate": 0.7}
    result = carom.exchange(PAIR | {"exchange": plain}, set={"run.until_time": 50.0}, progress=False)
    assert result.windows.shape == (0, 2) and result.distances.size == 0
    with pytest.raises(carom.FolderError, match="has no potential of mean force: it is an exchange between temperatures"):
        _ = result.potential_of_mean_force


def test_a_window_that_cannot_be_reached_is_named() -> None:
    # This high step keeps the pair out of the first window. A scene with a hard core there would be rejected.
    step = {"species": ["A", "A"], "potential": "penetrable", "height": 500.0}
    windows = [[0.5, 0.9], [0.8, 2.0]]
    changed = {"exchange.umbrella": {"between": [[0], [1]], "windows": windows}, "run.until_time": 10.0}
    with pytest.raises(carom.SimulationError, match=r"window 1, from 0.5 to 0.9, was not reached: after half .* the distance is still 1\.") as raised:
        carom.exchange(PAIR | {"interaction": [step]}, set=changed, progress=False)
    assert "longer equilibration_time" in str(raised.value)
