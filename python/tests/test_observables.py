"""Arithmetic of observables: errors agree with the scatter of samples, units with a table, and digits with the error."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import carom
from carom import Observable
from carom._units import powers, product

X = Observable(2.5, 0.02, "length", True)
Y = Observable(-1.3, 0.03, "length", True)
N = Observable(1.7, 0.01, "1", True)

FUNCTIONS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "sum": lambda x, y, n: x + y - 3.0,
    "difference": lambda x, y, n: 2.0 - (x - y),
    "product": lambda x, y, n: 3.0 * x * y,
    "quotient": lambda x, y, n: x / y / 7,
    "inverse": lambda x, y, n: 1.0 / x,
    "power": lambda x, y, n: x**1.5,
    "negative power": lambda x, y, n: y**-2,
    "power of an observable": lambda x, y, n: (x / y) ** 2 * n**n,
    "power of a number": lambda x, y, n: 2**n,
    "absolute": lambda x, y, n: abs(-y) + n,
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_errors_match_the_scatter_of_samples(name: str) -> None:
    function = FUNCTIONS[name]
    generator = np.random.default_rng(5)
    many = [generator.normal(it.mean, it.error, 100_000) for it in (X, Y, N)]
    found = function(*(Observable(it.mean, it.error, "1", True) for it in (X, Y, N)))
    assert found.mean == pytest.approx(function(X.mean, Y.mean, N.mean), rel=1e-12)
    assert found.error == pytest.approx(function(*many).std(), rel=0.02)
    assert found.is_stationary is True and not found.is_conserved


def test_observable_is_fully_correlated_with_itself() -> None:
    assert (X * X).error == pytest.approx(2.0 * X.mean * 0.02, rel=1e-12)
    assert (X + X).error == pytest.approx(0.04, rel=1e-12)
    assert (X - X).error == 0.0 and (X / X).error == 0.0


OF_ONE: dict[str, tuple[Callable[[Any], Any], Callable[[float], float]]] = {
    "second virial coefficient": (lambda z: 2 * (z - 1) / z, lambda z: 2 / z**2),
    "value in both terms": (lambda z: z**2 + 3 * z, lambda z: 2 * z + 3),
    "rational": (lambda z: (1 + z + z**2 - z**3) / (1 - z) ** 3, lambda z: (4 + 4 * z - 2 * z**2) / (1 - z) ** 4),
    "powers": (lambda z: z**z / z, lambda z: z ** (z - 1) * (math.log(z) + 1 - 1 / z)),
}


@pytest.mark.parametrize("name", OF_ONE)
def test_functions_of_one_value_have_the_error_of_their_derivative(name: str) -> None:
    function, derivative = OF_ONE[name]
    z = Observable(3.972, 0.025, "1", True)
    assert function(z).error == pytest.approx(abs(derivative(3.972)) * 0.025, rel=1e-12)


def test_what_cancels_leaves_no_error() -> None:
    for found in (X - X * 1, 2 * X - X - X, -X + X, abs(X) - X):
        assert (found.mean, found.error) == (0.0, 0.0)
    unknown = Observable(2.0, None, "length")
    assert (unknown - unknown).error == 0.0 and (2 * unknown - unknown).error is None


def test_sums_distinguish_equal_and_independent_values() -> None:
    assert sum([X, X]).error == pytest.approx(0.04, rel=1e-12)
    assert sum([X, Y]).error == pytest.approx(math.hypot(0.02, 0.03), rel=1e-12)
    # The sum and the difference are correlated: the result is 2 Y, with twice the error of Y.
    assert ((X + Y) - (X - Y)).error == pytest.approx(0.06, rel=1e-12)
    values = np.array([X, X, Y], dtype=object)
    assert values.sum().error == pytest.approx(math.hypot(0.04, 0.03), rel=1e-12)
    assert (values - values)[0].error == 0.0


def test_copies_and_pickles_are_the_same_value() -> None:
    for again in (copy.copy(X), copy.deepcopy(X), pickle.loads(pickle.dumps(X)), copy.deepcopy([X])[0]):
        assert again == X and (again - X).error == 0.0
    product = pickle.loads(pickle.dumps(X * Y))
    assert (product / X - Y).error == pytest.approx(0.0, abs=1e-15)
    # Means and errors are equal, so `other == X`. The values are independent, so `other - X` has an error.
    other = Observable(2.5, 0.02, "length", True)
    assert other == X and (other - X).error == pytest.approx(0.02 * math.sqrt(2.0), rel=1e-12)


def test_observables_of_one_run_are_equal_wherever_they_are_read(fluid: dict) -> None:
    run = carom.run(fluid, "one")
    other = carom.run(fluid, seed=2)
    p = run.observables["pressure"]
    for again in (carom.open("one"), pickle.loads(pickle.dumps(run)), carom.run(fluid)):
        assert (again.observables["pressure"] - p).error == 0.0
    assert p.error is not None and other.observables["pressure"].error is not None
    assert (other.observables["pressure"] - p).error == pytest.approx(math.hypot(p.error, other.observables["pressure"].error), rel=1e-12)


@pytest.mark.parametrize(
    ("one", "other", "of_product", "of_quotient"),
    [
        ("1", "1", "1", "1"),
        ("energy", "1", "energy", "energy"),
        ("energy / length^3", "length^3", "energy", "energy / length^6"),
        ("1 / time", "1 / time", "1 / time^2", "1"),
        ("mass / (length time)", "length^2", "mass length / time", "mass / (length^3 time)"),
        ("length^2 / time", "energy", "length^2 energy / time", "length^2 / (time energy)"),
        ("1 / (length time)", "length", "1 / time", "1 / (length^2 time)"),
    ],
)
def test_units_are_multiplied_and_divided(one: str, other: str, of_product: str, of_quotient: str) -> None:
    a, b = Observable(2.0, 0.1, one), Observable(4.0, 0.1, other)
    assert ((a * b).unit, (a / b).unit) == (of_product, of_quotient)
    assert powers((a * b / b).unit) == powers(one)
    assert (1 / (1 / a)).unit == one


def test_units_have_fractional_powers() -> None:
    assert product(("length^2 / time", 0.5)) == "length / time^0.5"
    third = Observable(8.0, 0.1, "energy") ** (1 / 3)
    assert third.unit == "energy^0.333333" and powers((third**3).unit) == {"energy": Fraction(1)}
    with pytest.raises(ValueError, match="expected a unit such as"):
        powers("length^two")


def test_all_units_of_carom_are_read() -> None:
    for dimensions in (1, 2, 3):
        for unit in carom._carom.observable_units(dimensions).values():
            assert product((unit, 1)) == unit and (unit == "1") == (powers(unit) == {})


def test_invalid_operations_raise() -> None:
    time = Observable(1.0, 0.1, "time")
    for wrong in (lambda: X + time, lambda: X - N, lambda: X**X, lambda: 2.0**X, lambda: X**N, lambda: Y**0.5, lambda: (Y / X) ** N):
        with pytest.raises(ValueError, match="expected|power"):
            wrong()
    for wrong in (lambda: X / 0.0, lambda: 1 / (X - X), lambda: Observable(0.0, 0.1, "1") ** 0.5):
        with pytest.raises(ZeroDivisionError):
            wrong()
    for operand in ("1", None, True, [1.0], np.zeros(2), 1j):
        for operation in (lambda it: X + it, lambda it: it * X, lambda it: X / it, lambda it: it - X, lambda it: X**it):
            with pytest.raises(TypeError):
                operation(operand)


def test_operations_accept_numpy_numbers() -> None:
    for number in (2, np.float64(2.0), np.int32(2), Fraction(2)):
        for found in (number * X, X * number):
            assert isinstance(found, Observable) and (found.mean, found.error, found.unit) == (5.0, 0.04, "length")
        assert (number - X).mean == -0.5 and (number / X).unit == "1 / length" and (number**N).mean == pytest.approx(2**1.7)


def test_what_is_not_known_stays_unknown() -> None:
    unknown, drifting = Observable(2.0, None, "length"), Observable(2.0, 0.1, "length", False)
    assert (X + unknown).error is None and (X + unknown).is_stationary is None
    assert (X * drifting).is_stationary is False and (drifting + unknown).is_stationary is False
    fixed = Observable(3.0, 0.0, "energy", True, True)
    assert (2 * fixed).is_conserved and (2 * fixed).error == 0.0 and not (fixed * X).is_conserved


@pytest.mark.parametrize(
    ("mean", "error", "text"),
    [
        (3.9718703261436397, 0.02541488079059699, "3.972 +- 0.025 [1]"),
        (2.0, 0.0996, "2.00 +- 0.10 [1]"),
        (5678.9, 123.4, "5679 +- 123 [1]"),
        (1.23456e-9, 2.5e-11, "(1.235 +- 0.025)e-9 [1]"),
        (1.23456e9, 2.5e7, "(1.235 +- 0.025)e9 [1]"),
        (0.1, 3.0, "0.1 +- 3.0 [1]"),
        (1.0, 1.25e-17, "1 +- 1.2e-17 [1]"),
        (1.0, 1e-14, "1.000000000000000 +- 0.000000000000010 [1]"),
        (0.0, 0.02, "0.000 +- 0.020 [1]"),
        (1 / 3, None, "0.333333 [1]"),
        (1 / 3, 0.0, "0.333333 [1]"),
    ],
)
def test_digits_are_those_of_the_error(mean: float, error: float | None, text: str) -> None:
    found = Observable(mean, error, "1")
    assert str(found) == text and repr(found) == f"<Observable {text}>"
    assert len(repr([found])) < 70


def test_observables_are_pickled_and_compared() -> None:
    again = pickle.loads(pickle.dumps(X * Y))
    assert again == X * Y and hash(again) == hash(X * Y) and math.isclose(float(again), -3.25)
