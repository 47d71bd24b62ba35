"""Means of correlated series."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from carom import _carom
from carom._observable import Observable

__all__ = ["is_stationary", "mean_and_error"]


def is_stationary(verdict: str) -> bool | None:
    """Verdict of the compiled part; ``None`` where that cannot be told."""
    return {"stationary": True, "constant": True, "drifting": False}.get(verdict)


def mean_and_error(series: ArrayLike, unit: str = "1") -> Observable:
    """The mean of a correlated series, with the standard error and the verdict that runs have.

    Values are gathered in at most 1024 blocks of equal length. The variance of the mean of ``n`` of them is ``S(0) / n``, with the spectral
    density ``S`` at frequency zero, the sum of all autocovariances: that of the most likely sum of white noise, relaxations and differences that
    cancel between neighbours (P. Whittle, Ark. Mat. 2, 423 (1953)). An error that comes from few independent values is larger by what Student's
    distribution says of them. Errors are on the safe side: larger than the exact ones of autoregressive series by 6 % where these are long, by 20
    to 30 % where they are worth 25 to 50 independent values. The series is stationary if the means of its first quarter and of its second half
    differ by no more than chance (J. Geweke, in Bayesian Statistics 4, Oxford University Press, 1992, p. 169).

    Parameters
    ----------
    series : array, shape (m,)
        Values at even times, in the order of time, all from the measurement: nothing is left out.
    unit : str
        Their unit.

    Returns
    -------
    Observable
        The error is ``None`` for series that are worth fewer than eight independent values, and the verdict for those that are too short for one.

    Raises
    ------
    ValueError, TypeError
        If it has not one axis, no values, or some that are not finite or not real.

    Examples
    --------
    The pressure between the rows of a run, but for the first, which has none, and the last, which stands for a shorter time:

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
        raise ValueError(f"series: expected an array of the shape (m,) with at least one value, found {array.shape}")
    if np.ma.is_masked(series) or not np.isfinite(array).all():
        at = int(np.argmin(np.isfinite(np.ma.filled(np.ma.asarray(series, dtype=float), np.nan))))
        raise ValueError(f"series: expected finite numbers, found none at the place {at}: leave it out, or begin behind it")
    mean, error, verdict = _carom.mean_and_error(array.astype(np.float64).tobytes())
    return Observable(mean, error, unit, is_stationary(verdict), verdict == "constant")
