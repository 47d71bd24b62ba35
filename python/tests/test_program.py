"""The package includes the program."""

from __future__ import annotations

import signal
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

import pytest

import carom

from conftest import ROOT

SCRIPT = Path(sysconfig.get_path("scripts")) / "carom"


@pytest.mark.parametrize("command", [[sys.executable, "-m", "carom"], [str(SCRIPT)]], ids=["module", "script"])
def test_program_works_as_module_and_script(command: list[str], tmp_path: Path) -> None:
    def say(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([*command, *arguments], capture_output=True, text=True, cwd=tmp_path, check=False)

    assert say("--version").stdout == f"carom {carom.__version__}\n"
    scene = say("new", "fluid")
    assert scene.returncode == 0
    (tmp_path / "fluid.toml").write_text(scene.stdout)
    done = say("run", "fluid.toml", "--until-events", "5000", "--set", "run.equilibration_events=500", "--quiet")
    assert done.returncode == 0, done.stderr
    assert isinstance(carom.open(tmp_path / "runs" / "fluid"), carom.Run)
    wrong = say("check", "fluid.toml", "--set", "seed=many")
    assert wrong.returncode == 2
    assert "seed" in wrong.stderr and wrong.stdout == ""


def test_a_signal_ends_a_run_in_good_order(tmp_path: Path) -> None:
    (tmp_path / "fluid.toml").write_text(
        subprocess.run([SCRIPT, "new", "fluid"], capture_output=True, text=True, check=True).stdout
    )
    run = subprocess.Popen(
        [SCRIPT, "run", "fluid.toml", "--until-events", "1e12", "--out", "run"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + 60
    while not list(tmp_path.glob("run/thermo.csv*")) and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(0.5)
    run.send_signal(signal.SIGINT)
    _, errors = run.communicate(timeout=60)
    assert run.returncode == 1, errors
    assert "--resume" in errors and "Traceback" not in errors
    more = [SCRIPT, "run", "--resume", "run", "--until-events", "1", "--quiet"]
    done = subprocess.run(more, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "Traceback" not in done.stderr


def test_source_folder_does_not_shadow_the_package() -> None:
    # Python searches the working folder first, where a folder `carom` without the compiled part would hide the package.
    code = "import carom; print(carom.Scene)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT / "python", capture_output=True, text=True)
    assert done.returncode == 0 and "carom._scene.Scene" in done.stdout, done.stderr
