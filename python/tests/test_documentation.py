"""Every public name has a docstring with an example, and every example gives the printed result."""

from __future__ import annotations

import copy
import doctest
import importlib.util
import inspect
import types
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import carom

from conftest import FLUID

PAIR = {
    "name": "pair",
    "space": {"size": [4.0, 4.0, 4.0]},
    "species": [{"name": "A", "mass": 1.0, "diameter": 1.0}],
    "interaction": [{"species": ["A", "A"], "potential": "square-well", "lambda": 1.5, "well_depth": 1.0}],
    "particle": [{"species": "A", "position": [1, 1, 1]}, {"species": "A", "position": [3, 3, 3]}],
    "exchange": {"temperatures": [0.4, 0.6, 1.0], "interval": 2.0, "rate": 1.0},
    "run": {"equilibration_time": 20.0, "until_time": 4000.0},
}

#: Packages that some examples need.
OPTIONAL = {"ASE": "ase", "MDANALYSIS": "MDAnalysis", "FREUD": "freud", "GSD": "gsd", "PANDAS": "pandas", "MATPLOTLIB": "matplotlib"}
FLAGS = {doctest.register_optionflag(flag): module for flag, module in OPTIONAL.items()}


def documented() -> Iterator[tuple[str, Any]]:
    """All public names that can have a docstring, including members of classes."""
    for name in carom.__all__:
        thing = getattr(carom, name)
        if not (inspect.isclass(thing) or inspect.isfunction(thing)):
            continue
        yield name, thing
        if not inspect.isclass(thing):
            continue
        for base in [thing, *(it for it in thing.__mro__[1:] if it.__module__.startswith("carom"))]:
            for part, value in vars(base).items():
                is_method = isinstance(value, (types.FunctionType, classmethod, staticmethod, property)) or hasattr(value, "func")
                if not part.startswith("_") and is_method:
                    yield f"{name}.{part}", getattr(value, "__func__", value)


NAMES = dict(documented())


def test_public_names_are_found() -> None:
    assert len(NAMES) > 90
    assert {"Simulation.positions", "Run.frames", "sweep", "Run.observables", "Scene.from_toml"} <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_public_name_is_documented_with_an_example(name: str) -> None:
    text = inspect.getdoc(NAMES[name]) or ""
    first = text.split("\n\n")[0]
    assert first.endswith((".", ":")) and len(first) > 15, "a first line with a description"
    assert ">>>" in text, "an example"
    if callable(NAMES[name]) and not inspect.isclass(NAMES[name]):
        arguments = [it for it in inspect.signature(NAMES[name]).parameters.values() if it.name not in ("self", "cls")]
        is_other = "as for" in text.lower() or "as :meth:" in text.lower()
        assert not arguments or "Parameters" in text or is_other or text.startswith("Reads a table"), "its arguments"


@pytest.mark.parametrize("name", NAMES)
def test_docstring_example_gives_the_printed_result(name: str) -> None:
    text = inspect.getdoc(NAMES[name]) or ""
    given = {"carom": carom, "np": np, "fluid": copy.deepcopy(FLUID), "pair": copy.deepcopy(PAIR)}
    examples = doctest.DocTestParser().get_doctest(text, given, name, None, 0)
    missing = {flag for flag, module in FLAGS.items() if importlib.util.find_spec(module) is None}
    examples.examples = [it for it in examples.examples if not any(it.options.get(flag) for flag in missing)]
    shown: list[str] = []
    flags = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
    results = doctest.DocTestRunner(optionflags=flags).run(examples, out=shown.append)
    assert results.failed == 0, "".join(shown)


def test_package_docstring_has_the_scene_of_the_examples() -> None:
    text = carom.__doc__ or ""
    code = text[text.index("fluid = {") : text.index("They also use ``pair``")]
    found: dict[str, Any] = {}
    exec(inspect.cleandoc(code), found)  # noqa: S102
    assert found["fluid"] == FLUID
