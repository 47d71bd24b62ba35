"""Annotations and stubs are true."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mypy")


def mypy(*words: str, tmp_path: Path) -> None:
    cache = ["--cache-dir", str(tmp_path / "cache")] if words[0] == "mypy" else []
    done = subprocess.run([sys.executable, "-m", *words, *cache], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_annotations_hold(tmp_path: Path) -> None:
    settings = Path(__file__).parents[1] / "pyproject.toml"
    mypy("mypy", "--strict", "--config-file", str(settings), "--package", "carom", tmp_path=tmp_path)


def test_stubs_are_those_of_the_compiled_part(tmp_path: Path) -> None:
    mypy("mypy.stubtest", "carom._carom", tmp_path=tmp_path)
