"""Opens the files of the program with the software they are written for, and compares every number with the native
trajectory.

    python check.py PROGRAM

Prints a line for each format and reader. Exits with code 1 if any number differs.
"""

import subprocess
import sys
import tempfile
import warnings
from importlib.metadata import version
from pathlib import Path

import ase.io
import numpy as np
from ovito.io import export_file, import_file

import native
import readers
import scenes
from compare import Difference, same

TARGETS = {
    "xyz": "trajectory-piece.xyz",
    "lammps": "trajectory.lammpstrj",
    "gsd": "trajectory.gsd",
    "vtk": "trajectory-vtk",
    "npy": "trajectory-npy",
    "csv": "trajectory.csv",
}


def call(program, *arguments):
    """Runs the program. If the program fails, the check fails."""
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        raise Difference(f"{' '.join(map(str, arguments))}: exit code {done.returncode}\n{done.stderr}")


def written(program, folder):
    """Runs the scenes, converts each into every format, and returns the native frames by folder."""
    runs = {}
    for name, scene, shorter in scenes.write(folder):
        run = folder / name
        call(program, "run", scene, "--quiet", "--out", run, *shorter)
        for form, target in TARGETS.items():
            call(program, "convert", run, "--to", form)
            if not (run / target).exists():
                raise Difference(f"{name}: no {target}")
        runs[run] = native.read(run / "trajectory.xyz")
    return runs


def reads_back(program, folder, writer):
    """Positions and velocities that another program wrote, as the start of a scene."""
    frame = native.read(folder / "mixture" / "trajectory.xyz")[-1]
    for has_velocities in (True, False):
        path = folder / f"from_{writer.__name__}_{has_velocities}.xyz"
        writer(path, folder / "mixture" / "trajectory.xyz", has_velocities)
        # The other program writes fewer digits, so particles may overlap.
        text = "allow_invalid_start = true\n" + scenes.MIXTURE.split("[[fill]]")[0]
        text += f'[[file]]\npath = "{path}"\n[run]\nuntil_events = 10\n'
        scene = path.with_suffix(".toml")
        scene.write_text(text)
        call(program, "run", scene, "--quiet", "--out", path.with_suffix(""))
        start = native.read(path.with_suffix("") / "trajectory.xyz")[0]
        same("species", start.particle_names, frame.particle_names)
        # The files contain about ten digits.
        same("positions", start.positions, frame.positions, 1e-8)
        if has_velocities:
            same("velocities", start.velocities, frame.velocities, 1e-8)


def comes_back(program, folder, writer):
    """A frame that another program has read and written, read as the start of a scene with the box of the file."""
    frame = native.read(folder / "mixture" / "trajectory.xyz")[-1]
    path = folder / f"back_from_{writer.__name__}.xyz"
    writer(path, folder / "mixture" / "trajectory.xyz")
    head, rest = scenes.MIXTURE.split("[space]")
    rest = rest[rest.index("[[species]]") :].split("[[fill]]")[0]
    scene = path.with_suffix(".toml")
    scene.write_text(f'allow_invalid_start = true\n{head}{rest}[[file]]\npath = "{path}"\n[run]\nuntil_events = 10\n')
    call(program, "run", scene, "--quiet", "--out", path.with_suffix(""))
    start = native.read(path.with_suffix("") / "trajectory.xyz")[0]
    same("species", start.particle_names, frame.particle_names)
    same("radii", start.radii, frame.radii)
    same("masses", start.particle_masses, frame.particle_masses)
    same("box", start.edges, frame.edges, 1e-8)
    same("periodic axes", start.periodic, frame.periodic)
    same("velocities", start.velocities, frame.velocities, 1e-7)
    same("lower corner", start.lower, frame.lower)
    # A position that is rounded out of the box is wrapped to the opposite side, so whole periods are ignored.
    moved = start.positions - frame.positions
    moved -= frame.edges * np.round(moved / frame.edges)
    same("positions", frame.positions + moved, frame.positions, 1e-7)
    with open(path, encoding="utf-8") as file:
        file.readline()
        comment = file.readline()
    told = float(comment.split("Time=")[1].split()[0].strip('"')) if "Time=" in comment else None
    if told is not None:
        same("time", np.array([told]), np.array([frame.time]), 1e-8)


def through_ase(path, trajectory):
    ase.io.write(path, ase.io.read(trajectory, format="extxyz"), format="extxyz")


def through_ovito(path, trajectory):
    pipeline = import_file(str(trajectory))
    columns = ["Particle Type", "Position.X", "Position.Y", "Position.Z"]
    columns += ["Velocity.X", "Velocity.Y", "Velocity.Z", "Radius", "Particle Identifier"]
    last = pipeline.source.num_frames - 1
    export_file(pipeline, str(path), "xyz", columns=columns, frame=last, precision=12)


def by_ase(path, trajectory, has_velocities):
    atoms = ase.io.read(trajectory, format="extxyz")
    symbols = ase.Atoms(list(atoms.arrays["type"]), positions=atoms.positions, cell=atoms.cell, pbc=atoms.pbc)
    if has_velocities:
        symbols.set_array("velo", atoms.arrays["velo"])
    ase.io.write(path, symbols, format="extxyz")


def by_ovito(path, trajectory, has_velocities):
    pipeline = import_file(str(trajectory))
    columns = ["Particle Type", "Position.X", "Position.Y", "Position.Z"]
    columns += ["Velocity.X", "Velocity.Y", "Velocity.Z"] if has_velocities else []
    last = pipeline.source.num_frames - 1
    export_file(pipeline, str(path), "xyz", columns=columns, frame=last, precision=12)


def main(program):
    warnings.simplefilter("ignore")
    faults = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        runs = written(program, folder)
        if not any(frame.leaves_through_a_side.any() for frames in runs.values() for frame in frames):
            raise Difference("no run has a bond through a side")
        if not any(frame.displacement != 0 for frames in runs.values() for frame in frames):
            raise Difference("no run has a box that is sheared")
        checks = []
        for form, package, reader in readers.ALL:
            mine = [run for run in runs if run.name in readers.ONLY.get(reader, [run.name])]
            work = lambda reader=reader, form=form, mine=mine: [
                reader(run / TARGETS.get(form, "thermo.csv"), runs[run]) for run in mine
            ]
            count = sum(len(runs[run]) for run in mine)
            checks.append((form, package, work, f"{len(mine)} scenes, {count} frames"))
        for package, writer in (("ase", by_ase), ("ovito", by_ovito)):
            work = lambda writer=writer: reads_back(program, folder, writer)
            checks.append(("read", package, work, "a scene starts from its extended XYZ, with and without velocities"))
        for package, writer in (("ase", through_ase), ("ovito", through_ovito)):
            work = lambda writer=writer: comes_back(program, folder, writer)
            checks.append(("back", package, work, "species, radii, masses, box, velocities, positions and time come back"))
        for form, package, work, what in checks:
            name = f"{form:8}{package + ' ' + version(package):20}"
            try:
                work()
                print(f"{name}agrees: {what}", flush=True)
            except Exception as error:  # Any objection of a reader is a finding.
                faults += 1
                print(f"{name}DIFFERS: {type(error).__name__}: {error}", flush=True)
    return 1 if faults else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: check.py PROGRAM")
    try:
        sys.exit(main(sys.argv[1]))
    except Difference as difference:
        sys.exit(str(difference))
