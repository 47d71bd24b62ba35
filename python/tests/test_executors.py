"""Sweeps on executors: processes, a Dask cluster that loses a worker, and MPI."""

from __future__ import annotations

import filecmp
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path

import pytest

import carom

TABLES = ("sweep.csv", "sweep-mean.csv")
VARY = {"fill.0.packing_fraction": [0.1, 0.2, 0.3]}


@pytest.fixture
def undisturbed(fluid: dict, tmp_path: Path) -> carom.Sweep:
    return carom.sweep(fluid, VARY, seeds=2, out=tmp_path / "undisturbed", jobs=1)


def same(one: carom.Sweep, other: carom.Sweep) -> None:
    """Both sweeps have the same points, each once, with the same bits."""
    assert len(one) == len(other) and not one.failures and not other.failures
    for name in TABLES:
        assert filecmp.cmp(one.folder / name, other.folder / name, shallow=False), name
    for a, b in zip(one.runs, other.runs):
        assert a is not None and b is not None
        assert (a.folder / "trajectory.xyz").read_bytes() == (b.folder / "trajectory.xyz").read_bytes()


def processes(count: int) -> ProcessPoolExecutor:
    # A process forked while threads run may hang.
    return ProcessPoolExecutor(count, mp_context=get_context("spawn"))


def test_sweep_on_a_thread_pool_equals_a_plain_sweep(fluid: dict, undisturbed: carom.Sweep, tmp_path: Path) -> None:
    with ThreadPoolExecutor(2) as executor:
        same(carom.sweep(fluid, VARY, seeds=2, out=tmp_path / "sweep", executor=executor), undisturbed)


def test_sweep_on_a_process_pool_equals_a_plain_sweep(fluid: dict, undisturbed: carom.Sweep, tmp_path: Path) -> None:
    with processes(2) as executor:
        same(carom.sweep(fluid, VARY, seeds=2, out=tmp_path / "sweep", executor=executor), undisturbed)


def test_a_process_is_killed_and_the_same_call_goes_on(fluid: dict, tmp_path: Path) -> None:
    fluid["run"]["until_events"] = 1_000_000
    whole = carom.sweep(fluid, seeds=3, out=tmp_path / "whole")
    out = tmp_path / "sweep"

    def kill(executor: ProcessPoolExecutor) -> None:
        until = time.monotonic() + 60.0
        while time.monotonic() < until and not list(out.glob("*/thermo.csv.partial")):
            time.sleep(0.01)
        for pid in list(executor._processes):
            os.kill(pid, signal.SIGKILL)

    with processes(1) as executor:
        killer = threading.Thread(target=kill, args=(executor,))
        killer.start()
        with pytest.raises(BrokenProcessPool):
            carom.sweep(fluid, seeds=3, out=out, executor=executor, checkpoint_every=0.05)
        killer.join()
    assert sum(state == "done" for state in carom.open(out).table["state"]) < 3
    with processes(2) as executor:
        same(carom.sweep(fluid, seeds=3, out=out, executor=executor), whole)


def test_sweep_survives_the_kill_of_a_dask_worker(fluid: dict, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    fluid["run"]["until_events"] = 500_000
    whole = carom.sweep(fluid, VARY, seeds=2, out=tmp_path / "whole")
    out = tmp_path / "sweep"
    settings = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    killed: list[int] = []
    with distributed.LocalCluster(**settings) as cluster, distributed.Client(cluster) as client:

        def kill() -> None:
            until = time.monotonic() + 60.0
            while time.monotonic() < until:
                done, begun = (len(list(out.glob(f"*/{name}"))) for name in ("summary.json", "thermo.csv.partial"))
                if done >= 1 and begun >= 1:
                    break
                time.sleep(0.005)
            pid = next(iter(client.run(os.getpid).values()))
            killed.append(pid)
            os.kill(pid, signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        result = carom.sweep(
            fluid, VARY, seeds=2, out=out, executor=client.get_executor(), checkpoint_every=0.05
        )
        killer.join()
        with pytest.raises(TypeError, match="get_executor"):
            carom.sweep(fluid, seeds=1, out=tmp_path / "other", executor=client)
    assert killed
    same(result, whole)


def test_sweep_on_mpi_equals_a_plain_sweep(undisturbed: carom.Sweep, tmp_path: Path) -> None:
    # Prefers an `mpiexec` that is installed beside this Python interpreter.
    mpiexec = shutil.which("mpiexec", path=os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")]))
    if mpiexec is None:
        pytest.skip("there is no mpiexec")
    # mpi4py may be installed without an MPI library.
    loaded = subprocess.run([sys.executable, "-c", "import mpi4py.futures, mpi4py.MPI"], capture_output=True, text=True)
    if loaded.returncode != 0 and ("cannot load MPI library" in loaded.stderr or "ModuleNotFoundError" in loaded.stderr):
        pytest.skip("there is no MPI")
    script = tmp_path / "study.py"
    script.write_text(
        textwrap.dedent(
            f"""
            import sys
            sys.path.insert(0, {str(Path(__file__).parent)!r})
            import carom
            from mpi4py.futures import MPIPoolExecutor
            from conftest import FLUID

            if __name__ == "__main__":
                with MPIPoolExecutor() as executor:
                    result = carom.sweep(FLUID, {VARY!r}, seeds=2, out="mpi", executor=executor)
                    print(executor.num_workers, "workers", result)
            """
        )
    )
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    # Allows more processes than cores. Open MPI 4 reads the first variable.
    environment["OMPI_MCA_rmaps_base_oversubscribe"] = "1"
    environment["PRTE_MCA_rmaps_default_mapping_policy"] = ":oversubscribe"
    command = [mpiexec, "-n", "3", sys.executable, "-m", "mpi4py.futures", script]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "2 workers <Sweep of packing_fraction, seed: 6 points, 6 done>" in done.stdout
    same(carom.open(tmp_path / "mpi"), undisturbed)  # type: ignore[arg-type]
