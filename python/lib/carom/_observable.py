"""Means with standard errors, and arithmetic with them."""

from __future__ import annotations

import hashlib
import json
import math
import uuid
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from carom import _units
from carom._arguments import is_number, shown
from carom._html import unit

__all__ = ["Observable", "measured", "source"]

#: Number of significant decimal digits that a double can hold.
_DIGITS = 15


@dataclass(frozen=True, repr=False)
class Observable:
    """A mean with its standard error.

    Observables can be added, subtracted, multiplied, divided and raised to powers, with each other and with
    numbers. Errors propagate to first order. Each result carries its derivatives with respect to the measured
    values from which it was calculated. The error of ``2 * (z - 1) / z`` is therefore ``2 / z**2`` times the
    error of ``z``, and ``z - z`` is exactly 0. Different measured values are treated as independent. This is
    correct for values of different runs. It is not correct for two observables of the same run, such as the
    pressure and the energy: their covariance is unknown, and the error of a function of both may be too large
    or too small.

    A measured value keeps its identity in copies, pickles and arrays. An observable of a run is the same
    measured value each time the run is opened, and two runs of the same scene with the same seed give the
    same measured values. An ``Observable`` that the caller constructs, and each result of
    :func:`mean_and_error`, is a new measured value, independent of all others. ``==`` compares only the
    attributes, not this identity.

    Units are multiplied and divided symbolically, without conversion. The terms of a sum must have the same
    unit; a number that is added takes the unit of the other term. A result is stationary if all values from
    which it was calculated are stationary, and conserved if all of them are conserved.

    Attributes
    ----------
    mean : float
    error : float or None
        Standard error of the mean; 0 for a conserved quantity, ``None`` if the run is too short to estimate
        the error.
    unit : str
        Unit; ``1`` for a pure number.
    is_stationary : bool or None
        Whether the quantity was stationary during the measurement; ``None`` if this cannot be determined.
    is_conserved : bool
        Whether the quantity was exactly constant.

    Raises
    ------
    ValueError
        If units are incompatible, or if a power has no real result.
    ZeroDivisionError
        If the mean of a divisor is 0.

    Examples
    --------
    >>> z = carom.run(fluid).observables["compressibility_factor"]
    >>> print(z)
    3.972 +- 0.025 [1]
    >>> other = carom.run(fluid, seed=2).observables["compressibility_factor"]
    >>> 0.5 * (z + other) - 1
    <Observable 2.958 +- 0.019 [1]>
    >>> carom.Observable(8.0, 0.1, "length^2 / time") ** 0.5
    <Observable 2.828 +- 0.018 [length / time^0.5]>
    """

    mean: float
    error: float | None
    unit: str
    is_stationary: bool | None = None
    is_conserved: bool = False
    #: Measured values on which this value depends, by unique keys. Each entry contains the derivative of this value,
    #: and the standard error of the measured value.
    _terms: Mapping[str, tuple[float, float | None]] = field(init=False, compare=False)

    #: Makes NumPy scalars use the operators of this class.
    __array_ufunc__: ClassVar[None] = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "_terms", {} if self.error == 0.0 else {uuid.uuid4().hex: (1.0, self.error)})

    def __add__(self, other: Observable | float) -> Observable:
        that = _observable(other, self.unit)
        return NotImplemented if that is None else _result(self.mean + that.mean, _common(self, that), (1.0, self), (1.0, that))

    __radd__ = __add__

    def __sub__(self, other: Observable | float) -> Observable:
        that = _observable(other, self.unit)
        return NotImplemented if that is None else _result(self.mean - that.mean, _common(self, that), (1.0, self), (-1.0, that))

    def __rsub__(self, other: float) -> Observable:
        return -self + other

    def __mul__(self, other: Observable | float) -> Observable:
        that = _observable(other)
        if that is None:
            return NotImplemented
        of_both = _units.product((self.unit, 1), (that.unit, 1))
        return _result(self.mean * that.mean, of_both, (that.mean, self), (self.mean, that))

    __rmul__ = __mul__

    def __truediv__(self, other: Observable | float) -> Observable:
        that = _observable(other)
        if that is None:
            return NotImplemented
        mean, of_both = self.mean / that.mean, _units.product((self.unit, 1), (that.unit, -1))
        return _result(mean, of_both, (1.0 / that.mean, self), (-mean / that.mean, that))

    def __rtruediv__(self, other: float) -> Observable:
        that = _observable(other)
        return NotImplemented if that is None else that / self

    def __pow__(self, other: Observable | float) -> Observable:
        that = _observable(other)
        return NotImplemented if that is None else _power(self, that)

    def __rpow__(self, other: float) -> Observable:
        that = _observable(other)
        return NotImplemented if that is None else _power(that, self)

    def __neg__(self) -> Observable:
        return _result(-self.mean, self.unit, (-1.0, self))

    def __pos__(self) -> Observable:
        return self

    def __abs__(self) -> Observable:
        return -self if self.mean < 0.0 else self

    def __float__(self) -> float:
        return self.mean

    def __str__(self) -> str:
        if not self.error:
            conserved = " (conserved)" if self.is_conserved and self.mean != 0.0 else ""
            return f"{self.mean:.6g}{conserved} [{self.unit}]"
        size = max(abs(self.mean), self.error)
        if self.error < 10.0**-_DIGITS * size:
            return f"{self.mean:.{_DIGITS}g} +- {self.error:.2g} [{self.unit}]"
        largest = _exponent(size)
        is_plain = -5 < largest < 7
        scale = 1.0 if is_plain else 10.0**largest
        digits = max(0, 1 - _exponent(float(f"{self.error / scale:.1e}")))
        text = f"{self.mean / scale:.{digits}f} +- {self.error / scale:.{digits}f}"
        return f"{text} [{self.unit}]" if is_plain else f"({text})e{largest} [{self.unit}]"

    def __repr__(self) -> str:
        return f"<Observable {self}>"

    def _repr_html_(self) -> str:
        value = str(self).rpartition(" [")[0].replace("+-", "&plusmn;")
        drifts = ", not stationary" if self.is_stationary is False else ""
        return f"<span>{value} {unit(self.unit)}{drifts}</span>"


def _exponent(number: float) -> int:
    return math.floor(math.log10(number))


def _observable(value: Any, unit: str = "1") -> Observable | None:
    """Returns an observable unchanged, a number as an observable without error, and ``None`` for other types."""
    if isinstance(value, Observable):
        return value
    return Observable(float(value), 0.0, unit, True, True) if is_number(value) else None


def _common(one: Observable, other: Observable) -> str:
    if _units.powers(one.unit) != _units.powers(other.unit):
        raise ValueError(f"expected observables with the same unit, found {shown(one.unit)} and {shown(other.unit)}")
    return one.unit


def _power(base: Observable, power: Observable) -> Observable:
    if _units.powers(power.unit) or (power.error != 0.0 and _units.powers(base.unit)):
        raise ValueError(f"a power must have no unit; if it has an error, its base must have no unit, too; found {base!r} to the power {power!r}")
    exact = float(power.mean).is_integer() and power.error == 0.0
    if base.mean < 0.0 and not exact:
        raise ValueError(f"a fractional power needs a base of at least 0, found {base!r} to the power {power!r}")
    mean = base.mean**power.mean
    slope = power.mean * base.mean ** (power.mean - 1.0) if power.mean else 0.0
    by_power = mean * math.log(base.mean) if power.error != 0.0 else 0.0
    return _result(mean, _units.product((base.unit, power.mean)), (slope, base), (by_power, power))


def _result(mean: float, unit: str, *terms: tuple[float, Observable]) -> Observable:
    """Result of a function of observables, given its mean and its derivative with respect to each observable."""
    verdicts = [it.is_stationary for _, it in terms]
    is_stationary = False if False in verdicts else None if None in verdicts else True
    sources: dict[str, tuple[float, float | None]] = {}
    for slope, it in terms:
        for name, (inner, error) in it._terms.items():
            before = sources.get(name, (0.0, error))[0]
            sources[name] = (before + slope * inner, error)
    # If the derivative is zero, an unknown error does not matter.
    found = {name: (slope, error) for name, (slope, error) in sources.items() if slope != 0.0}
    errors = [None if error is None else slope * error for slope, error in found.values()]
    known = [error for error in errors if error is not None]
    error = math.hypot(*known) if len(known) == len(errors) else None
    return _with(found, Observable(mean, error, unit, is_stationary, all(it.is_conserved for _, it in terms)))


def _with(terms: Mapping[str, tuple[float, float | None]], observable: Observable) -> Observable:
    object.__setattr__(observable, "_terms", terms)
    return observable


def source(*what: Any) -> str:
    """Identifier of a measured value: a digest of the data that determine it."""
    return hashlib.sha256(json.dumps(what, sort_keys=True, default=str).encode()).hexdigest()[:32]


def measured(name: str, observable: Observable) -> Observable:
    """The observable as the measured value with this name. Equal names denote the same measured value."""
    return _with({} if observable.error == 0.0 else {name: (1.0, observable.error)}, observable)
