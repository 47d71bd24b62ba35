"""Read-only arrays.

These arrays are copies of the data. They are read-only, because an assignment to their elements would be lost
silently.
"""

from __future__ import annotations

from typing import Any, TypeVar

from numpy.typing import NDArray

__all__ = ["fixed"]

_Array = TypeVar("_Array", bound=NDArray[Any])


def fixed(array: _Array) -> _Array:
    """Makes the array read-only and returns it. ``array.copy()`` is writable."""
    array.flags.writeable = False
    return array
