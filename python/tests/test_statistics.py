"""Errors of means agree with the errors of runs, and with the known errors of series."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import carom


def autoregressive(generator: np.random.Generator, correlation: float, count: int) -> np.ndarray:
    """A stationary series of variance 1 with the given correlation between successive values."""
    noise = generator.normal(size=count) * math.sqrt(1.0 - correlation**2)
    noise[0] /= math.sqrt(1.0 - correlation**2)
    series = np.empty(count)
    value = 0.0
    for at, kick in enumerate(noise):
        value = correlation * value + kick
        series[at] = value
    return series


def exact_variance(correlation: float, count: int) -> float:
    """Variance of the mean of such a series."""
    ratio = (1.0 + correlation) / (1.0 - correlation)
    ends = 2.0 * correlation * (1.0 - correlation**count) / (count * (1.0 - correlation) ** 2)
    return (ratio - ends) / count


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9, -0.5])
@pytest.mark.parametrize("count", [500, 3000])
def test_errors_are_the_exact_ones_of_autoregressive_series(correlation: float, count: int) -> None:
    generator = np.random.default_rng(7)
    found = [carom.mean_and_error(autoregressive(generator, correlation, count)) for _ in range(200)]
    means, errors = np.array([it.mean for it in found]), np.array([it.error for it in found], dtype=float)
    exact = math.sqrt(exact_variance(correlation, count))
    assert abs(means.std() / exact - 1.0) < 0.15, "the formula fits the series"
    # The estimated errors may be too large, by up to 12 %, or 25 % for the strongest correlation.
    assert 0.97 < np.median(errors) / exact < (1.25 if correlation == 0.9 else 1.12)
    # About two thirds of the means are within one standard error. The limits allow for 200 draws and for errors that
    # are too large.
    assert 0.58 < (abs(means) < errors).mean() < 0.82
    assert sum(it.is_stationary is False for it in found) <= 4


@pytest.mark.parametrize("column", ["pressure", "collision_rate"])
def test_mean_and_error_of_rows_equal_those_of_the_run(fluid: dict, column: str) -> None:
    wells = {**fluid, "interaction": [{**fluid["interaction"][0], "potential": "square-well", "lambda": 1.5, "well_depth": 0.5}]}
    for scene in (fluid, wells):
        # The average has fewer blocks than there are rows after the equilibration.
        scene = {**scene, "run": {"equilibration_time": 2.0, "until_time": 30.0}, "output": {"thermo_interval": 0.02, "frame_interval": 10.0}}
        run = carom.run(scene)
        rows = run.thermo[column][run.thermo["time"] > 2.0 + 1e-9]
        assert len(rows) == 1500
        found, expected = carom.mean_and_error(rows, run.thermo.units[column]), run.observables[column]
        assert found.mean == pytest.approx(expected.mean, rel=1e-12) and found.error == pytest.approx(expected.error, rel=1e-6)
        assert (found.unit, found.is_stationary, found.is_conserved) == (expected.unit, expected.is_stationary, False)


def test_stationarity_and_conservation_verdicts() -> None:
    generator = np.random.default_rng(3)
    noise = generator.normal(size=2000)
    assert carom.mean_and_error(noise).is_stationary is True
    assert carom.mean_and_error(noise + np.linspace(0.0, 2.0, 2000)).is_stationary is False
    constant = carom.mean_and_error(np.full(100, 3))
    assert (constant.mean, constant.error, constant.is_stationary, constant.is_conserved) == (3.0, 0.0, True, True)
    few = carom.mean_and_error([1.0, 2.0, 4.0])
    assert few.mean == pytest.approx(7 / 3) and few.error is None and few.is_stationary is None
    assert carom.mean_and_error(np.arange(200.0)).error is None


def test_series_of_any_number_type_give_equal_results() -> None:
    values = np.random.default_rng(1).integers(0, 100, 500)
    expected = carom.mean_and_error(values.astype(float), "length")
    for same in (values, values.tolist(), values.astype(">i4"), np.repeat(values, 2)[::2], values.astype(np.float32)):
        assert carom.mean_and_error(same, "length") == expected
    assert expected.unit == "length" and (2 * expected / carom.mean_and_error(values, "time")).unit == "length / time"


@pytest.mark.parametrize(
    ("series", "kind", "words"),
    [
        ([], ValueError, r"found \(0,\)"),
        (3.0, ValueError, r"found \(\)"),
        (np.zeros((3, 4)), ValueError, r"found \(3, 4\)"),
        ([1.0, 2.0, np.nan, np.inf], ValueError, "at index 2"),
        (np.ma.masked_less(np.arange(5.0), 1.0), ValueError, "at index 0"),
        (["1"], TypeError, "real numbers"),
        ([True], TypeError, "real numbers"),
        ([1j], TypeError, "real numbers"),
        (None, TypeError, "real numbers"),
    ],
)
def test_invalid_series_are_rejected(series: Any, kind: type, words: str) -> None:
    with pytest.raises(kind, match="series: .*" + words):
        carom.mean_and_error(series)
