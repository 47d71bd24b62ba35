"""Checks of user arguments: strings and booleans are not numbers, and numbers are not booleans."""

from __future__ import annotations

import math
import operator
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["finite", "flag", "is_number", "path_of", "real", "shown", "threads_of", "vectors", "whole"]


def shown(value: Any) -> str:
    """Text of a value for a message: for a long array or list, only the beginning and the type."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 80 else f"{text[:60]} ... of type {type(value).__name__}"


def is_number(value: Any) -> bool:
    """Whether the value is a real number, including NumPy scalars.

    NumPy strings are not numbers, although they have ``__float__``.
    """
    if isinstance(value, bool) or not (hasattr(value, "__float__") or hasattr(value, "__index__")):
        return False
    kind = getattr(getattr(value, "dtype", None), "kind", "f")
    return kind in "fiu" and getattr(value, "ndim", 0) == 0


def real(name: str, value: Any) -> float:
    """Checks that the value is a real number and returns it."""
    if not is_number(value):
        raise TypeError(f"{name}: expected a number, found {shown(value)}")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{name}: expected a finite number, found {shown(value)}") from None


def finite(name: str, value: Any) -> float:
    """Checks that the value is a finite real number and returns it."""
    number = real(name, value)
    if not math.isfinite(number):
        raise ValueError(f"{name}: expected a finite number, found {number}")
    return number


def whole(name: str, value: Any, least: int = 0) -> int:
    """Checks that the value is a whole number and returns it. Floats such as ``1e6`` are accepted."""
    wrong = TypeError(f"{name}: expected a whole number, found {shown(value)}")
    if not is_number(value):
        raise wrong
    try:
        number = operator.index(value)
    except TypeError:
        if not float(value).is_integer():
            raise wrong from None
        number = int(value)
    if not least <= number < 2**63:
        raise ValueError(f"{name}: expected a whole number from {least} to 2^63 - 1, found {number}")
    return number


def threads_of(value: Any) -> str | None:
    """Checks a number of threads, ``"auto"``, or ``None`` for the setting of the scene."""
    if value is None or (isinstance(value, str) and value == "auto"):
        return value
    if isinstance(value, str):
        raise ValueError(f"threads: expected a number from 1 to 64 or 'auto', found {shown(value)}")
    number = whole("threads", value, 1)
    if number > 64:
        raise ValueError(f"threads: expected a number from 1 to 64 or 'auto', found {number}")
    return str(number)


def flag(name: str, value: Any) -> bool:
    """Checks that the value is a boolean and returns it. Strings are rejected, because ``"no"`` is true in Python."""
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name}: expected True or False, found {shown(value)}")
    return bool(value)


def path_of(name: str, path: Any) -> Path:
    """Checks a path and returns it. An empty path is rejected, because it would refer to the working directory."""
    if not isinstance(path, (str, os.PathLike)):
        raise TypeError(f"{name}: expected a path, found {type(path).__name__}")
    text = os.fspath(path)
    if not text:
        raise ValueError(f"{name}: expected a path, found an empty string; '.' is the folder where the program runs")
    if "\0" in text:
        raise ValueError(f"{name}: a path cannot contain a null character")
    return Path(path)


def vectors(name: str, value: ArrayLike, count: int) -> bytes:
    """Checks an array with three real numbers for each particle, and returns its bytes."""
    array = np.asarray(value)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name}: expected real numbers, found an array of {array.dtype}")
    if array.shape != (count, 3):
        raise ValueError(f"{name}: expected an array of shape ({count}, 3), found {array.shape}")
    if np.ma.is_masked(value):
        raise ValueError(f"{name}: expected real numbers, found a masked array with masked values")
    return array.astype(np.float64).tobytes()
