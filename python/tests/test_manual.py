"""The Python code of the manual runs as printed."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import carom

from conftest import FLUID, ROOT

MANUAL = ROOT / "docs" / "python.md"

#: Packages that code blocks need. The keys are words in these blocks.
NEEDED = {
    "_ase(": "ase",
    ".gsd": "gsd",
    "mdanalysis(": "MDAnalysis",
    ".plot()": "matplotlib",
    "dask.": "dask.distributed",
}

#: Words in code blocks that need a cluster or MPI. `test_executors` tests Dask and MPI.
ELSEWHERE = ("SLURMCluster", "mpi4py")

#: Runs the given files one after the other. Each file can use the variables of the files before it.
RUN = """
import sys
from pathlib import Path

if __name__ == "__main__":
    names = {"__name__": "__main__"}
    for path in sys.argv[1:]:
        exec(compile(Path(path).read_text(), path, "exec"), names)
        print("done", path)
"""


def blocks() -> list[tuple[str, str]]:
    """Line number and code of each Python block."""
    text = MANUAL.read_text(encoding="utf-8")
    found = re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [(f"line_{text[: it.start(1)].count(chr(10)) + 1}.py", it[1]) for it in found]


def is_there(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except ModuleNotFoundError:
        return False


def test_all_blocks_run_in_their_order(tmp_path: Path) -> None:
    if not MANUAL.is_file():
        pytest.skip("there is no repository")
    Path("fluid.toml").write_text(carom.Scene(FLUID, set={"output.frame_interval": 0.5}).to_toml(), encoding="utf-8")
    Path("hopper.toml").write_text(carom.example("hopper").to_toml(), encoding="utf-8")
    all_blocks = blocks()
    assert len(all_blocks) > 18
    missing = {module for module in NEEDED.values() if not is_there(module)}
    run = []
    for name, code in all_blocks:
        if not any(word in code for word in ELSEWHERE) and not any(word in code and module in missing for word, module in NEEDED.items()):
            Path(name).write_text(code, encoding="utf-8")
            run.append(name)
    assert len(run) >= len(all_blocks) - len(ELSEWHERE) - len(missing)
    Path("all.py").write_text(RUN, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "all.py", *run],
        capture_output=True,
        text=True,
        timeout=600,
        env={**os.environ, "MPLBACKEND": "Agg", "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert done.returncode == 0, f"{done.stdout[-200:]}\n{done.stderr[-3000:]}"
    assert [line for line in done.stdout.splitlines() if line.startswith("done")] == [f"done {name}" for name in run]
    if missing:
        pytest.skip(f"blocks of {', '.join(sorted(missing))} were left out")
