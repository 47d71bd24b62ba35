"""Means of correlated series."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from carom import _carom
from carom._observable import Observable

__all__ = ["is_stationary", "mean_and_error"]


def is_stationary(verdict: str) -> bool | None:
    """Returns the verdict of the compiled part on stationarity, or ``None`` if it is unknown."""
    return {"stationary": True, "constant": True, "drifting": False}.get(verdict)


def mean_and_error(series: ArrayLike, unit: str = "1") -> Observable:
    """Computes the mean of a correlated series, with its standard error and a verdict on stationarity.

    The method is the same as for the observables of a run. The values are averaged in at most 1024 blocks of
    equal length. The variance of the mean of ``n`` blocks is ``S(0) / n``, where ``S(0)`` is the spectral
    density at frequency zero, which is the sum of all autocovariances. It is estimated by fitting the most
    likely sum of white noise, relaxations, and differences that cancel between neighbours (P. Whittle, Ark.
    Mat. 2, 423 (1953)). If there are few independent values, the error is enlarged according to Student's
    distribution.

    The errors are conservative. For autoregressive series, they exceed the exact errors by 6 % if the series
    is long, and by 20 to 30 % if it is equivalent to 25 to 50 independent values.

    The series is stationary if the means of its first quarter and its second half differ by no more than
    chance (J. Geweke, in Bayesian Statistics 4, Oxford University Press, 1992, p. 169).

    Parameters
    ----------
    series : array, shape (m,)
        Values at equally spaced times, in chronological order. All values must belong to the measurement,
        because none are discarded.
    unit : str
        Unit of the values.

    Returns
    -------
    Observable
        The error is ``None`` if the series is equivalent to fewer than eight independent values. The verdict
        is ``None`` if the series is too short for a verdict.

    Raises
    ------
    ValueError, TypeError
        If the series does not have exactly one axis, is empty, or contains values that are not finite or not
        real.

    Examples
    --------
    The pressure between the rows of a run, except the first row, which has no pressure, and the last row,
    which covers a shorter time:

    >>> run = carom.run(fluid)
    >>> found = carom.mean_and_error(run.thermo["pressure"][1:-1], run.thermo.units["pressure"])
    >>> found
    <Observable 2.277 +- 0.015 [energy / length^3]>
    >>> found.is_stationary
    True
    """
    array = np.asarray(series)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"series: expected real numbers, found an array of {array.dtype}")
    if array.ndim != 1 or not len(array):
        raise ValueError(f"series: expected an array of shape (m,) with at least one value, found {array.shape}")
    if np.ma.is_masked(series) or not np.isfinite(array).all():
        at = int(np.argmin(np.isfinite(np.ma.filled(np.ma.asarray(series, dtype=float), np.nan))))
        raise ValueError(f"series: the value at index {at} is not finite: remove it, or start after it")
    mean, error, verdict = _carom.mean_and_error(array.astype(np.float64).tobytes())
    return Observable(mean, error, unit, is_stationary(verdict), verdict == "constant")
