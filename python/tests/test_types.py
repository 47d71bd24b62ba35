"""Annotations and stubs are correct."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import carom

SETTINGS = Path(__file__).parents[1] / "pyproject.toml"


def mypy(*words: str, tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    cache = ["--cache-dir", str(tmp_path / "cache")] if words[0] == "mypy" else []
    done = subprocess.run([sys.executable, "-m", *words, *cache], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_annotations_pass_mypy_strict(tmp_path: Path) -> None:
    mypy("mypy", "--strict", "--config-file", str(SETTINGS), "--package", "carom", tmp_path=tmp_path)


def test_stubs_are_those_of_the_compiled_part(tmp_path: Path) -> None:
    mypy("mypy.stubtest", "carom._carom", tmp_path=tmp_path)


def test_pyright_finds_nothing(tmp_path: Path) -> None:
    pytest.importorskip("pyright")
    # Pyright searches only below the folder of its settings.
    shutil.copy(SETTINGS, tmp_path)
    shutil.copytree(Path(carom.__file__).parent, tmp_path / "carom", ignore=shutil.ignore_patterns("*.so", "*.pyd", "__pycache__"))
    words = [sys.executable, "-m", "pyright", "--project", str(tmp_path), "--pythonpath", sys.executable]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0 and "0 errors" in done.stdout, done.stdout + done.stderr
