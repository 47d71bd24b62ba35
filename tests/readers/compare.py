"""Comparison of numbers with the native trajectory."""

import numpy as np

EXACT = 0.0
# OVITO reads decimal numbers and ASE converts units, both with errors in the last bits.
ROUNDED = 4 * np.finfo(np.float64).eps
SINGLE = np.finfo(np.float32).eps


class Difference(Exception):
    """A reader and the native trajectory disagree."""


def same(what, found, expected, tolerance=EXACT):
    """Compares numbers, relative to the largest one."""
    found, expected = np.asarray(found), np.asarray(expected)
    if found.shape != expected.shape:
        raise Difference(f"{what}: shape {found.shape}, expected {expected.shape}")
    if expected.dtype.kind != "f":
        if not np.array_equal(found, expected):
            raise Difference(f"{what}: {found}, expected {expected}")
        return
    allowed = tolerance * np.abs(expected).max(initial=0.0)
    largest = np.abs(found - expected).max(initial=0.0)
    if not largest <= allowed:
        raise Difference(f"{what}: differs by {largest}, allowed {allowed}")
