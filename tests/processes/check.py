"""Compares runs on several MPI processes with runs on one: python3 check.py CAROM, where CAROM is the program carom-mpi.

Files have the same bytes for any number of processes and threads. An interrupted run continues on another number of them.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

CONFIGS = Path(__file__).parents[2] / "configs"
# With these variables, Open MPI accepts more processes than cores and runs as the root user of a container.
ENVIRONMENT = os.environ | {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    # A waiting process yields its core.
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
}
# Numbers that depend on the computer and its load.
CLOCKS = ("wall_seconds", "events_per_second", "contacts_per_second", "peak_memory_bytes")

SCENES = {
    "hard_sphere_fluid": ["--until-events", "20000", "--set", "run.equilibration_events=2000", "--set", "output.contacts=true"],
    "square_well_fluid": ["--until-events", "20000", "--set", "run.equilibration_events=2000", "--set", "output.events=true"],
    "hopper": ["--until-events", "20000"],
    "heat_flux": ["--until-events", "20000", "--set", "run.equilibration_events=2000"],
    "brownian": ["--until-events", "20000", "--set", "run.equilibration_events=2000"],
    "polymer": ["--until-events", "20000", "--set", "run.equilibration_events=2000"],
    "random_packing": ["--until-events", "5000", "--set", "run.equilibration_events=2000", "--set", "fill.0.count=300"],
    "sheared_granular_gas": ["--until-events", "20000", "--set", "run.equilibration_events=2000"],
}


def run(carom, processes, *arguments):
    """Runs on a number of MPI processes, or runs the program alone."""
    command = [carom, "run", *map(str, arguments), "--quiet"]
    if processes:
        command = ["mpiexec", "-n", str(processes), *command]
    return subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, timeout=600)


def results(folder):
    """The bytes of all files of a run, except values of clocks."""

    def without_clocks(value):
        if isinstance(value, dict):
            return {key: without_clocks(one) for key, one in value.items() if key not in CLOCKS}
        return [without_clocks(one) for one in value] if isinstance(value, list) else value

    files = {}
    for path in sorted(folder.rglob("*")):
        if path.name == "summary.json":
            files[path.name] = json.dumps(without_clocks(json.loads(path.read_text())))
        elif path.is_file() and path.name not in ("report.txt", "checkpoint", "checkpoint.previous", ".carom"):
            files[str(path.relative_to(folder))] = path.read_bytes()
    assert "thermo.csv" in files and "trajectory.xyz" in files, sorted(files)
    return files


def compare(one, other, what):
    one, other = results(one), results(other)
    assert sorted(one) == sorted(other), (what, sorted(one), sorted(other))
    different = [name for name in one if one[name] != other[name]]
    assert not different, (what, different)


def check_scenes(carom, folder):
    for name, changes in SCENES.items():
        scene = CONFIGS / f"{name}.toml"
        if not scene.exists():
            raise AssertionError(f"no {scene}")
        alone = folder / name
        done = run(carom, None, scene, *changes, "--out", alone)
        assert done.returncode == 0, done.stderr
        for processes, threads in [(2, 1), (3, 2)]:
            there = folder / f"{name}-{processes}-{threads}"
            done = run(carom, processes, scene, *changes, "--out", there, "--threads", threads)
            assert done.returncode == 0, (name, processes, done.stdout, done.stderr)
            assert f"in each of {processes} processes" in done.stdout, done.stdout
            assert done.stdout.count("verdict") == 1, done.stdout
            compare(alone, there, (name, processes, threads))
        print(f"{name}: the same bytes in 2 and 3 processes")


def interrupt(carom, target, arguments):
    """Sends a signal to the first of three processes after their first checkpoint."""
    started = target.with_suffix(".pid")
    command = [carom, "run", *map(str, arguments), "--out", str(target), "--quiet"]
    first = 'if [ "${OMPI_COMM_WORLD_RANK:-$PMI_RANK}" = 0 ]; then echo $$ > "$0"; fi; exec "$@"'
    job = subprocess.Popen(
        ["mpiexec", "-n", "3", "sh", "-c", first, str(started), *command],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    until = time.monotonic() + 120
    while not (target / "checkpoint").exists() and time.monotonic() < until and job.poll() is None:
        time.sleep(0.02)
    os.kill(int(started.read_text()), signal.SIGTERM)
    said, _ = job.communicate(timeout=120)
    assert job.returncode == 1 and "INTERRUPTED" in said, (job.returncode, said)


def check_interrupted(carom, folder):
    """A signal to the first process ends all processes after a checkpoint, and the run continues on another number of them."""
    arguments = [CONFIGS / "hard_sphere_fluid.toml", "--until-events", "200000", "--checkpoint-every", "0.2"]
    alone = folder / "alone"
    assert run(carom, None, *arguments, "--out", alone).returncode == 0
    for processes in (2, None):
        target = folder / f"interrupted-{processes}"
        interrupt(carom, target, arguments)
        done = run(carom, processes, "--resume", target)
        assert done.returncode == 0, (processes, done.stdout, done.stderr)
        compare(alone, target, ("resumed in", processes))
    print("interrupted in 3 processes, resumed in 2 and in 1: the same bytes")


def check_refusals(carom, folder):
    (folder / "duplicate_key.toml").write_text("seed = 1\nseed = 2\n")
    bad = run(carom, 3, folder / "duplicate_key.toml", "--out", folder / "bad")
    assert bad.returncode == 2 and bad.stderr.count("duplicate key") == 1, (bad.returncode, bad.stderr)
    scene = str(CONFIGS / "hard_sphere_fluid.toml")
    parts = [["-n", "1", carom, "run", scene, "--seed", seed, "--out", str(folder / "x")] for seed in ("1", "2")]
    command = ["mpiexec", *parts[0], ":", *parts[1]]
    other = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, timeout=600)
    assert other.returncode == 2 and "have different arguments" in other.stderr, (other.returncode, other.stderr)
    assert not (folder / "x").exists()
    print("bad scenes and different arguments: said once, exit code 2")


def main():
    carom = str(Path(sys.argv[1]).resolve())
    for check in (check_scenes, check_interrupted, check_refusals):
        with tempfile.TemporaryDirectory() as folder:
            check(carom, Path(folder))


if __name__ == "__main__":
    main()
