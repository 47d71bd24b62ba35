"""Opens what the program writes with the programs it is written for, and compares every number with the native
trajectory.

    python check.py PROGRAM

Prints a line per format and reader; any difference ends it with exit code 1.
"""

import subprocess
import sys
import tempfile
import warnings
from importlib.metadata import version
from pathlib import Path

import ase.io
import gsd.hoomd
import MDAnalysis
import numpy as np
import pandas
import pyvista
from ase.calculators.lammps import convert as ase_unit
from ovito.io import export_file, import_file

import native
import scenes

EXACT = 0.0
# OVITO reads decimal numbers, and ASE converts units, with an error in the last bits.
ROUNDED = 4 * np.finfo(np.float64).eps
SINGLE = np.finfo(np.float32).eps


class Difference(Exception):
    """A reader finds something else than the native trajectory has."""


def same(what, found, expected, tolerance=EXACT):
    """Compares, relative to the largest number."""
    found, expected = np.asarray(found), np.asarray(expected)
    if found.shape != expected.shape:
        raise Difference(f"{what}: shape {found.shape}, expected {expected.shape}")
    if expected.dtype.kind != "f":
        if not np.array_equal(found, expected):
            raise Difference(f"{what}: {found}, expected {expected}")
        return
    allowed = tolerance * np.abs(expected).max(initial=0.0)
    largest = np.abs(found - expected).max(initial=0.0)
    if not largest <= allowed:
        raise Difference(f"{what}: differs by {largest}, allowed {allowed}")


def thick(frame):
    """Lower corner and edges with an extent along flat axes, centred on the particles."""
    flat = frame.edges == 0
    return np.where(flat, frame.lower - frame.thickness / 2, frame.lower), np.where(flat, frame.thickness, frame.edges)


# Each reader gets the path of a conversion and the native frames.


def ovito_frames(path, frames, **options):
    pipeline = import_file(str(path), **options)
    same("number of frames", pipeline.source.num_frames, len(frames))
    for index, frame in enumerate(frames):
        data = pipeline.compute(index)
        kinds = {kind.id: kind.name for kind in data.particles.particle_types.types}
        same("species", [kinds[kind] for kind in data.particles.particle_types[...]], frame.particle_names)
        # OVITO keeps radii in single precision.
        same("radii", data.particles["Radius"][...], frame.radii, SINGLE)
        yield data, frame


def ovito_xyz(path, frames):
    for data, frame in ovito_frames(path, frames):
        same("time", data.attributes["Time"], frame.time, ROUNDED)
        same("ids", data.particles.identifiers[...], frame.ids)
        same("positions", data.particles.positions[...], frame.positions, ROUNDED)
        same("velocities", data.particles["Velocity"][...], frame.velocities, ROUNDED)
        same("box", data.cell[:, 3], frame.lower, ROUNDED)
        same("edges", np.diag(data.cell[:, :3]), thick(frame)[1], ROUNDED)
        same("periodic", data.cell.pbc, frame.periodic)


def ovito_lammps(path, frames):
    for index, (data, frame) in enumerate(ovito_frames(path, frames)):
        same("time", data.attributes["Time"], frame.time, ROUNDED)
        same("step", data.attributes["Timestep"], index)
        same("ids", data.particles.identifiers[...], frame.ids)
        same("positions", data.particles.positions[...], frame.positions, ROUNDED)
        same("velocities", data.particles["Velocity"][...], frame.velocities, ROUNDED)
        lower, edges = thick(frame)
        same("box", data.cell[:, 3], lower, ROUNDED)
        # The dump has the upper corner, from which OVITO subtracts the lower one.
        same("edges", np.diag(data.cell[:, :3]), edges, ROUNDED * (1 + np.abs(lower).max() / edges.max()))
        same("periodic", data.cell.pbc, frame.periodic)


def ovito_gsd(path, frames):
    for index, (data, frame) in enumerate(ovito_frames(path, frames)):
        same("time", data.attributes["carom/time"], frame.time)
        same("step", data.attributes["Timestep"], index)
        centre = frame.lower + frame.edges / 2
        same("positions", data.particles.positions[...], (frame.positions - centre).astype(np.float32))
        same("velocities", data.particles["Velocity"][...], frame.velocities.astype(np.float32))
        same("edges", np.diag(data.cell[:, :3])[frame.edges > 0], frame.edges[frame.edges > 0], SINGLE)
        same("plane", data.cell.is2D, bool(frame.edges[2] == 0))
        bonds = data.particles.bonds
        same("bonds", bonds.topology[...] if bonds else np.empty((0, 2), int), frame.bonds)


def ase_xyz(path, frames):
    for atoms, frame in zip(ase.io.read(path, ":", format="extxyz"), frames, strict=True):
        same("time", atoms.info["Time"], frame.time)
        same("ids", atoms.arrays["id"], frame.ids)
        same("species", atoms.arrays["type"], frame.particle_names)
        same("masses", np.nan_to_num(np.ravel(atoms.info["species_mass"])), np.nan_to_num(frame.masses))
        same("positions", atoms.positions, frame.positions)
        same("velocities", atoms.arrays["velo"], frame.velocities)
        same("radii", atoms.arrays["radius"], frame.radii)
        same("edges", np.diag(atoms.cell), thick(frame)[1])
        same("periodic", atoms.pbc, frame.periodic)


def ase_lammps(path, frames):
    # Units are those of Lennard-Jones, which ASE takes for eV and Angstrom unless told otherwise: only velocities change.
    speed = ase_unit(1.0, "velocity", "metal", "ASE")
    for index, (atoms, frame) in enumerate(
        zip(ase.io.read(path, ":", format="lammps-dump-text"), frames, strict=True)
    ):
        same("step", atoms.info["timestep"], index)
        same("species", atoms.get_chemical_symbols(), frame.particle_names)
        same("positions", atoms.positions, frame.positions)
        same("velocities", atoms.get_velocities() / speed, frame.velocities, ROUNDED)
        lower, edges = thick(frame)
        same("box", atoms.get_celldisp().ravel(), lower)
        same("edges", np.diag(atoms.cell), edges, ROUNDED * (1 + np.abs(lower).max() / edges.max()))
        same("periodic", atoms.pbc, frame.periodic)


def gsd_hoomd(path, frames):
    with gsd.hoomd.open(path) as trajectory:
        same("number of frames", len(trajectory), len(frames))
        same("schema", trajectory.file.schema_version, (1, 4))
        same("file layer", trajectory.file.gsd_version[0], 2)
        for index, (snapshot, frame) in enumerate(zip(trajectory, frames)):
            snapshot.validate()
            centre = frame.lower + frame.edges / 2
            particles, is_plane = snapshot.particles, bool(frame.edges[2] == 0)
            same("time", snapshot.log["carom/time"], [frame.time])
            same("centre", snapshot.log["carom/centre"], centre)
            same("periodic", snapshot.log["carom/periodic"].astype(bool), frame.periodic)
            same("step", snapshot.configuration.step, index)
            same("dimensions", snapshot.configuration.dimensions, 2 if is_plane else 3)
            same("box", snapshot.configuration.box, [*frame.edges.astype(np.float32), 0, 0, 0])
            same("types", particles.types, frame.names)
            same("species", particles.typeid, frame.species)
            same("diameters", particles.diameter, (2 * frame.radii).astype(np.float32))
            masses = np.where(frame.static, 0, frame.masses)[frame.species]
            same("masses", particles.mass, masses.astype(np.float32))
            same("positions", particles.position, (frame.positions - centre).astype(np.float32))
            same("velocities", particles.velocity, frame.velocities.astype(np.float32))
            bonds = snapshot.bonds.group
            same("bonds", bonds if bonds is not None else np.empty((0, 2), int), frame.bonds)


def mdanalysis_gsd(path, frames):
    universe = MDAnalysis.Universe(path)
    same("number of frames", len(universe.trajectory), len(frames))
    same("species", universe.atoms.types, frames[0].particle_names.astype(object))
    for _, frame in zip(universe.trajectory, frames):
        centre = frame.lower + frame.edges / 2
        same("positions", universe.atoms.positions, (frame.positions - centre).astype(np.float32))
        same("edges", universe.dimensions[:3], frame.edges.astype(np.float32))


def mdanalysis_xyz(path, frames):
    universe = MDAnalysis.Universe(path)
    same("number of frames", len(universe.trajectory), len(frames))
    same("species", universe.atoms.names, frames[0].particle_names.astype(object))
    for _, frame in zip(universe.trajectory, frames):
        same("positions", universe.atoms.positions, frame.positions.astype(np.float32))


def pyvista_vtk(path, frames):
    reader = pyvista.get_reader(path / "trajectory.pvd")
    same("times", np.array(reader.time_values), np.array([frame.time for frame in frames]))
    for frame in frames:
        reader.set_active_time_value(frame.time)
        mesh = reader.read()[0]
        same("time", mesh.field_data["TimeValue"], [frame.time])
        same("box", mesh.field_data["box"], np.array([frame.lower, frame.lower + frame.edges]))
        same("periodic", mesh.field_data["periodic"].astype(bool), frame.periodic)
        same("species", np.array(mesh.field_data["species_names"])[mesh["species"]], frame.particle_names)
        same("static", mesh["static"].astype(bool), frame.static[frame.species])
        same("ids", mesh["id"], frame.ids)
        same("positions", mesh.points, frame.positions)
        same("velocities", mesh["velocity"], frame.velocities)
        same("radii", mesh["radius"], frame.radii)
        same("vertices", mesh.verts.reshape(-1, 2)[:, 1], np.arange(len(frame.ids)))
        same("bonds", mesh.lines.reshape(-1, 3)[:, 1:], frame.bonds[~frame.leaves_through_a_side])
    edges = pyvista.read(path / "box.vtp")
    same("outline", edges.bounds, np.column_stack([frame.lower, frame.lower + frame.edges]).ravel())
    same("edges of the outline", edges.n_lines, 12)


def numpy_npy(path, frames):
    array = lambda name: np.load(path / f"{name}.npy", mmap_mode="r")
    first = frames[0]
    same("times", array("times"), [frame.time for frame in frames])
    same("positions", array("positions"), [frame.positions for frame in frames])
    same("velocities", array("velocities"), [frame.velocities for frame in frames])
    same("box", array("box"), [[frame.lower, frame.edges] for frame in frames])
    same("periodic", array("periodic"), first.periodic)
    same("ids", array("ids"), first.ids)
    same("radii", array("radius"), first.radii)
    same("species", array("species_names")[array("species")], first.particle_names)
    same("static", array("species_static"), first.static)
    same("masses", np.nan_to_num(array("species_mass")), np.nan_to_num(first.masses))
    same("bonds", array("bonds") if len(first.bonds) else first.bonds, first.bonds)


def pandas_csv(path, frames):
    table = pandas.read_csv(path, float_precision="round_trip")
    joined = lambda of: np.concatenate([of(frame) for frame in frames])
    count = lambda frame: len(frame.ids)
    same("frames", table["frame"], np.repeat(np.arange(len(frames)), [count(frame) for frame in frames]))
    same("times", table["time"], joined(lambda frame: np.full(count(frame), frame.time)))
    same("ids", table["id"], joined(lambda frame: frame.ids))
    same("species", table["species"].to_numpy(str), joined(lambda frame: frame.particle_names))
    same("positions", table[["x", "y", "z"]], joined(lambda frame: frame.positions))
    same("velocities", table[["vx", "vy", "vz"]], joined(lambda frame: frame.velocities))
    same("radii", table["radius"], joined(lambda frame: frame.radii))


def pandas_thermo(path, frames):
    table = pandas.read_csv(path.parent / "thermo.csv", float_precision="round_trip")
    same("first and last time", table["time [time]"].iloc[[0, -1]], [frames[0].time, frames[-1].time])
    if table["kinetic [energy]"].isna().any() or not table["events [1]"].is_monotonic_increasing:
        raise Difference("thermo.csv: expected energies in all rows and numbers of events that rise")


READERS = [
    ("xyz", "ovito", ovito_xyz),
    ("xyz", "ase", ase_xyz),
    ("xyz", "MDAnalysis", mdanalysis_xyz),
    ("lammps", "ovito", ovito_lammps),
    ("lammps", "ase", ase_lammps),
    ("gsd", "gsd", gsd_hoomd),
    ("gsd", "ovito", ovito_gsd),
    ("gsd", "MDAnalysis", mdanalysis_gsd),
    ("vtk", "pyvista", pyvista_vtk),
    ("npy", "numpy", numpy_npy),
    ("csv", "pandas", pandas_csv),
    ("thermo", "pandas", pandas_thermo),
]
TARGETS = {
    "xyz": "trajectory-piece.xyz",
    "lammps": "trajectory.lammpstrj",
    "gsd": "trajectory.gsd",
    "vtk": "trajectory-vtk",
    "npy": "trajectory-npy",
    "csv": "trajectory.csv",
}
# ASE takes only chemical symbols as the names in a dump.
ONLY = {ase_lammps: ["mixture"]}


def call(program, *arguments):
    """Runs the program; its failure is one of the check."""
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
        # Positions with fewer digits may overlap.
        text = "allow_invalid_start = true\n" + scenes.MIXTURE.split("[[fill]]")[0]
        text += f'[[file]]\npath = "{path}"\n[run]\nuntil_events = 10\n'
        scene = path.with_suffix(".toml")
        scene.write_text(text)
        call(program, "run", scene, "--quiet", "--out", path.with_suffix(""))
        start = native.read(path.with_suffix("") / "trajectory.xyz")[0]
        same("species", start.particle_names, frame.particle_names)
        # Both programs write some ten digits.
        same("positions", start.positions, frame.positions, 1e-8)
        if has_velocities:
            same("velocities", start.velocities, frame.velocities, 1e-8)


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
        checks = []
        for form, package, reader in READERS:
            mine = [run for run in runs if run.name in ONLY.get(reader, [run.name])]
            work = lambda reader=reader, form=form, mine=mine: [
                reader(run / TARGETS.get(form, "thermo.csv"), runs[run]) for run in mine
            ]
            count = sum(len(runs[run]) for run in mine)
            checks.append((form, package, work, f"{len(mine)} scenes, {count} frames"))
        for package, writer in (("ase", by_ase), ("ovito", by_ovito)):
            work = lambda writer=writer: reads_back(program, folder, writer)
            checks.append(("read", package, work, "a scene starts from its extended XYZ, with and without velocities"))
        for form, package, work, what in checks:
            name = f"{form:8}{package + ' ' + version(package):20}"
            try:
                work()
                print(f"{name}agrees: {what}", flush=True)
            except Exception as error:  # Whatever a reader objects to is a finding.
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
