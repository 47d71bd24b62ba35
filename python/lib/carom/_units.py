"""Units in the notation of Carom: ``mass / (length time)``, ``1 / time``, ``length^2``."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from carom import _carom

__all__ = ["powers", "product", "units_of"]

#: Largest denominator of an exponent. The text of a unit shows exponents as rounded decimals, which are converted to
#: fractions.
_LARGEST = 1000


def units_of(summary: Mapping[str, Any], dimensions: int) -> dict[str, str]:
    """Units of the observables by name, with the names of the scene."""
    names = summary.get("units")
    return _carom.observable_units(dimensions, names and (names["length"], names["mass"], names["time"]))


def powers(unit: str) -> dict[str, Fraction]:
    """Power of each name in a unit; empty for a pure number."""
    found: dict[str, Fraction] = {}
    upper, _, lower = unit.partition("/")
    for text, sign in ((upper, 1), (lower, -1)):
        for word in text.translate(str.maketrans("()/*", "    ")).split():
            name, _, power = word.partition("^")
            if name != "1":
                try:
                    found[name] = found.get(name, Fraction(0)) + sign * _fraction(power or 1)
                except ValueError:
                    raise ValueError(f"expected a unit such as 'mass / (length time)' or 'length^2', found {unit!r}") from None
    return {name: power for name, power in found.items() if power}


def product(*factors: tuple[str, float]) -> str:
    """Product of units, each raised to a power."""
    total: dict[str, Fraction] = {}
    for unit, power in factors:
        for name, of_unit in powers(unit).items():
            total[name] = total.get(name, Fraction(0)) + of_unit * _fraction(power)
    upper, lower = ([_word(name, abs(power)) for name, power in total.items() if sign * power > 0] for sign in (1, -1))
    below = f"({' '.join(lower)})" if len(lower) > 1 else " ".join(lower)
    return " ".join(upper or ["1"]) + (f" / {below}" if lower else "")


def _fraction(power: str | float) -> Fraction:
    return Fraction(power).limit_denominator(_LARGEST)


def _word(name: str, power: Fraction) -> str:
    return name if power == 1 else f"{name}^{float(power):g}"
