"""Arrays that are copies of what they show: for reading only, so that a value that is assigned to a part of one is not lost without a word."""

from __future__ import annotations

from typing import Any, TypeVar

from numpy.typing import NDArray

__all__ = ["fixed"]

_Array = TypeVar("_Array", bound=NDArray[Any])


def fixed(array: _Array) -> _Array:
    """The array, for reading only from now on: ``array.copy()`` can be written to."""
    array.flags.writeable = False
    return array
