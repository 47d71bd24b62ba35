"""Scenes and runs that all tests start from."""

from __future__ import annotations

import copy
import os
import shutil
from pathlib import Path

import pytest

#: Path of the repository, if the tests run in it.
ROOT = Path(__file__).parents[2]

FLUID = {
    "name": "fluid",
    "seed": 1,
    "species": [{"name": "sphere", "mass": 1.0, "diameter": 1.0}],
    "interaction": [{"species": ["sphere", "sphere"], "potential": "hard-sphere"}],
    "fill": [{"species": "sphere", "arrangement": "fcc", "count": 108, "packing_fraction": 0.3, "temperature": 1.0}],
    "run": {"until_events": 20_000},
}

#: A ball that bounces infinitely often in a finite time. A run of this scene fails.
FALLING = {
    "name": "stack",
    "species": [{"name": "ball", "mass": 1.0, "diameter": 1.0}],
    "space": {"size": [4.0, 4.0, 4.0], "z": {"lower": "wall", "upper": "open", "restitution": 0.5}},
    "dynamics": {"gravity": [0.0, 0.0, -1.0]},
    "particle": [{"species": "ball", "position": [2.0, 2.0, 1.5]}],
    "run": {"until_time": 100.0},
}

#: A scene that fills every column of the outputs.
MIXTURE = {
    "name": "mixture",
    "seed": 3,
    "space": {"size": [9.0, 8.0, 12.0], "z": "walls"},
    "dynamics": {"gravity": [0.0, 0.0, -0.3]},
    "species": [{"name": "A", "mass": 1.3, "diameter": 1.0}, {"name": "B", "mass": 0.7, "diameter": 0.8}],
    "interaction": [
        {"species": ["A", "A"], "potential": "square-well", "lambda": 1.4, "well_depth": 0.9, "restitution": 0.95},
        {"species": ["A", "B"], "potential": "hard-sphere"},
        {"species": ["B", "B"], "potential": "hard-sphere"},
    ],
    "fill": [
        {"species": "A", "arrangement": "random", "count": 60, "temperature": 1.1},
        {"species": "B", "arrangement": "random", "count": 40, "temperature": 1.1},
    ],
    "run": {"until_events": 5_000},
    "output": {"events": True, "frame_interval": 0.5, "thermo_interval": 0.1},
}


@pytest.fixture
def fluid() -> dict:
    return copy.deepcopy(FLUID)


@pytest.fixture
def long_fluid() -> dict:
    """A fluid that is large enough, and in a box that is long enough, for several threads."""
    fill = {"species": "sphere", "arrangement": "random", "count": 4_500, "temperature": 1.0}
    return copy.deepcopy(FLUID) | {"space": {"size": [120.0, 8.0, 8.0]}, "fill": [fill]}


@pytest.fixture
def mixture() -> dict:
    return copy.deepcopy(MIXTURE)


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs each test in its own folder."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="session")
def program() -> str:
    """Path of the program: `CAROM` if it is set, otherwise from the search path."""
    found = os.environ.get("CAROM") or shutil.which("carom")
    if found is None:
        pytest.skip("there is no program carom: CAROM=path/to/carom names one")
    return str(Path(found).absolute())


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fails the session if a test was skipped while `CAROM_REQUIRE` is set."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if os.environ.get("CAROM_REQUIRE") and reporter is not None and reporter.stats.get("skipped"):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
