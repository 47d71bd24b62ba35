"""User-defined functions of a frame that are evaluated during a run."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from carom import _carom
from carom._arguments import finite, shown
from carom._frame import Frame

__all__ = ["Functions", "observed"]

#: Functions of a frame, by the name of the measured quantity.
Functions = Mapping[str, Callable[[Frame], float]]


def observed(observe: Functions | None, every: float | None) -> tuple[list[tuple[str, Callable[[dict[str, Any]], float]]], float]:
    """Returns the functions and the time between two calls, in the form that the compiled part expects."""
    if not observe:
        if every is not None:
            raise ValueError("every: has no effect without functions in observe: add functions, or omit every")
        return [], 1.0
    if not isinstance(observe, Mapping):
        raise TypeError(f"observe: expected a dictionary of functions, found {shown(observe)}")
    if every is None:
        raise ValueError("every: expected the simulated time between two calls of the functions in observe, such as every=0.5")
    taken = _carom.observable_units(3)
    for name, function in observe.items():
        if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z0-9_-]{1,50}", name):
            raise ValueError(f"observe: expected names of up to 50 letters, digits, - and _, found {shown(name)}")
        if name in taken:
            raise ValueError(f"observe: {name} is the name of a built-in observable: choose another name")
        if not callable(function):
            raise TypeError(f"observe: expected a function of a frame for {name}, found {shown(function)}")
    return [(name, _called(name, function)) for name, function in observe.items()], finite("every", every)


def _called(name: str, function: Callable[[Frame], float]) -> Callable[[dict[str, Any]], float]:
    return lambda parts: finite(f"observe: {name}", function(Frame._of(parts)))
