"""Programs and libraries that open converted files. Each function takes the path of a file and the native frames."""

import ase.io
import gsd.hoomd
import MDAnalysis
import numpy as np
import pandas
import pyvista
from ase.calculators.lammps import convert as ase_unit
from ovito.io import import_file
from ovito.modifiers import UnwrapTrajectoriesModifier

from compare import ROUNDED, SINGLE, Difference, same


def thick(frame):
    """Lower corner and edges with an extent along flat axes, centred on the particles."""
    flat = frame.edges == 0
    return np.where(flat, frame.lower - frame.thickness / 2, frame.lower), np.where(flat, frame.thickness, frame.edges)


def same_scalars(column, frame, tolerance=0.0):
    """Compares the additional per-particle scalars of the file."""
    for name, values in frame.scalars.items():
        same(name, column(name), values, tolerance)


def cell(frame, edges):
    """The vectors of the box as rows. The second vector is oblique in a sheared box."""
    rows = np.diag(edges)
    rows[1, 0] = frame.displacement
    return rows


def same_unwrapped(pipeline, frames, tolerance, origin=lambda frame: 0.0):
    """Compares positions unwrapped by OVITO from the images of the file."""
    pipeline.modifiers.append(UnwrapTrajectoriesModifier())
    for index, frame in enumerate(frames):
        positions = pipeline.compute(index).particles.positions[...]
        same("unwrapped by OVITO", positions, frame.unwrapped - origin(frame), tolerance)


def ovito_frames(path, frames, **options):
    pipeline = import_file(str(path), **options)
    same("number of frames", pipeline.source.num_frames, len(frames))
    for index, frame in enumerate(frames):
        data = pipeline.compute(index)
        kinds = {kind.id: kind.name for kind in data.particles.particle_types.types}
        same("species", [kinds[kind] for kind in data.particles.particle_types[...]], frame.particle_names)
        # OVITO stores radii in single precision.
        same("radii", data.particles["Radius"][...], frame.radii, SINGLE)
        yield data, frame


def ovito_xyz(path, frames):
    for data, frame in ovito_frames(path, frames):
        same("time", data.attributes["Time"], frame.time, ROUNDED)
        same("ids", data.particles.identifiers[...], frame.ids)
        same("positions", data.particles.positions[...], frame.positions, ROUNDED)
        same("velocities", data.particles["Velocity"][...], frame.velocities, ROUNDED)
        same("box", data.cell[:, 3], frame.lower, ROUNDED)
        same("edges", np.transpose(data.cell[:, :3]), cell(frame, thick(frame)[1]), ROUNDED)
        same("periodic", data.cell.pbc, frame.periodic)
        same("images", data.particles["Periodic Image"][...], frame.images)
        same("masses", data.particles["masses"][...], frame.particle_masses, ROUNDED)
        same_scalars(lambda name: data.particles[name][...], frame, ROUNDED)
    same_unwrapped(import_file(str(path)), frames, 4 * ROUNDED)


def ovito_lammps(path, frames):
    for index, (data, frame) in enumerate(ovito_frames(path, frames)):
        same("time", data.attributes["Time"], frame.time, ROUNDED)
        same("step", data.attributes["Timestep"], index)
        same("ids", data.particles.identifiers[...], frame.ids)
        same("positions", data.particles.positions[...], frame.positions, ROUNDED)
        same("velocities", data.particles["Velocity"][...], frame.velocities, ROUNDED)
        lower, edges = thick(frame)
        same("box", data.cell[:, 3], lower, 2 * ROUNDED)
        # OVITO subtracts the lower corner from the upper corner in the dump.
        rounded = ROUNDED * (1 + np.abs(lower).max() / edges.max())
        same("edges", np.transpose(data.cell[:, :3]), cell(frame, edges), rounded)
        same("periodic", data.cell.pbc, frame.periodic)
        same("images", data.particles["Periodic Image"][...], frame.images)
        same_scalars(lambda name: data.particles[name][...], frame, ROUNDED)
    same_unwrapped(import_file(str(path)), frames, 4 * ROUNDED)


def ovito_gsd(path, frames):
    for index, (data, frame) in enumerate(ovito_frames(path, frames)):
        same("time", data.attributes["carom/time"], frame.time)
        same("step", data.attributes["Timestep"], index)
        same("positions", data.particles.positions[...], frame.in_tilted_box.astype(np.float32))
        same("velocities", data.particles["Velocity"][...], frame.velocities.astype(np.float32))
        same("edges", np.diag(data.cell[:, :3])[frame.edges > 0], frame.edges[frame.edges > 0], SINGLE)
        same("tilt", data.cell[0, 1] / frame.edges[1], frame.displacement / frame.edges[1], SINGLE)
        same("plane", data.cell.is2D, bool(frame.edges[2] == 0))
        same_scalars(lambda name: data.particles[name][...], frame)
        same("images", data.particles["Periodic Image"][...], frame.images_in_tilted_box)
        same("masses", data.particles["Mass"][...], frame.particle_masses.astype(np.float32))
        bonds = data.particles.bonds
        same("bonds", bonds.topology[...] if bonds else np.empty((0, 2), int), frame.bonds)
    same_unwrapped(import_file(str(path)), frames, 4 * SINGLE, lambda frame: frame.lower + frame.edges / 2)


def ase_xyz(path, frames):
    for atoms, frame in zip(ase.io.read(path, ":", format="extxyz"), frames, strict=True):
        same("time", atoms.info["Time"], frame.time)
        same("ids", atoms.arrays["id"], frame.ids)
        same("species", atoms.arrays["type"], frame.particle_names)
        same("masses of species", np.nan_to_num(np.ravel(atoms.info["species_mass"])), np.nan_to_num(frame.masses))
        same("masses", atoms.get_masses(), frame.particle_masses)
        unwrapped = atoms.positions + atoms.arrays["map_shift"] @ atoms.cell.array
        same("unwrapped", unwrapped, frame.unwrapped, ROUNDED)
        same("positions", atoms.positions, frame.positions)
        same("velocities", atoms.arrays["velo"], frame.velocities)
        same("radii", atoms.arrays["radius"], frame.radii)
        same("edges", atoms.cell.array, cell(frame, thick(frame)[1]))
        same("periodic", atoms.pbc, frame.periodic)
        same_scalars(lambda name: atoms.arrays[name], frame)


def ase_lammps(path, frames):
    # By default, ASE interprets Lennard-Jones units as eV and Angstrom, which changes only the velocities.
    speed = ase_unit(1.0, "velocity", "metal", "ASE")
    for index, (atoms, frame) in enumerate(
        zip(ase.io.read(path, ":", format="lammps-dump-text"), frames, strict=True)
    ):
        same("step", atoms.info["timestep"], index)
        same("species", atoms.get_chemical_symbols(), frame.particle_names)
        same("positions", atoms.positions, frame.positions)
        same("velocities", atoms.get_velocities() / speed, frame.velocities, ROUNDED)
        lower, edges = thick(frame)
        rounded = ROUNDED * (1 + np.abs(lower).max() / edges.max())
        same("box", atoms.get_celldisp().ravel(), lower, rounded)
        same("edges", atoms.cell.array, cell(frame, edges), rounded)
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
            tilt = frame.displacement / frame.edges[1]
            same("box", snapshot.configuration.box, np.array([*frame.edges, tilt, 0, 0], np.float32))
            same("types", particles.types, frame.names)
            same("species", particles.typeid, frame.species)
            same("diameters", particles.diameter, (2 * frame.radii).astype(np.float32))
            masses = np.where(frame.static, 0, frame.masses)[frame.species]
            same("masses", particles.mass, masses.astype(np.float32))
            same("positions", particles.position, frame.in_tilted_box.astype(np.float32))
            same("velocities", particles.velocity, frame.velocities.astype(np.float32))
            same("images", particles.image, frame.images_in_tilted_box)
            same_scalars(lambda name: snapshot.log[f"particles/{name}"], frame)
            if len(frame.bonds):
                same("interactions of bonds", [snapshot.bonds.types[kind] for kind in snapshot.bonds.typeid],
                     frame.bond_names * len(frame.bonds))
            bonds = snapshot.bonds.group
            same("bonds", bonds if bonds is not None else np.empty((0, 2), int), frame.bonds)


def mdanalysis_gsd(path, frames):
    # MDAnalysis interprets tilt factors as cosines, so only the edges are compared. It reads no images, velocities or
    # times.
    universe = MDAnalysis.Universe(path)
    same("masses", universe.atoms.masses, frames[0].particle_masses)
    same("radii", universe.atoms.radii, frames[0].radii.astype(np.float32))
    pairs = lambda bonds: np.unique(np.sort(bonds, axis=1), axis=0)
    if len(frames[0].bonds):
        same("bonds", pairs(universe.bonds.indices), pairs(frames[0].bonds))
    same("number of frames", len(universe.trajectory), len(frames))
    same("species", universe.atoms.types, frames[0].particle_names.astype(object))
    for _, frame in zip(universe.trajectory, frames):
        same("positions", universe.atoms.positions, frame.in_tilted_box.astype(np.float32))
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
        same("displacement", mesh.field_data["displacement"], [frame.displacement])
        same("periodic", mesh.field_data["periodic"].astype(bool), frame.periodic)
        same("species", np.array(mesh.field_data["species_names"])[mesh["species"]], frame.particle_names)
        same("static", mesh["static"].astype(bool), frame.static[frame.species])
        same("ids", mesh["id"], frame.ids)
        same("positions", mesh.points, frame.positions)
        same("velocities", mesh["velocity"], frame.velocities)
        same("images", mesh["image"], frame.images)
        same("radii", mesh["radius"], frame.radii)
        same_scalars(lambda name: mesh[name], frame)
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
    same("images", array("images"), [frame.images for frame in frames])
    same("box", array("box"), [[frame.lower, frame.edges] for frame in frames])
    same("displacements", array("displacements"), [frame.displacement for frame in frames])
    same("periodic", array("periodic"), first.periodic)
    same("ids", array("ids"), first.ids)
    same("radii", array("radius"), first.radii)
    same("species", array("species_names")[array("species")], first.particle_names)
    same("static", array("species_static"), first.static)
    same("masses", np.nan_to_num(array("species_mass")), np.nan_to_num(first.masses))
    for name in first.scalars:
        same(name, array(name), [frame.scalars[name] for frame in frames])
    same("bonds", array("bonds") if len(first.bonds) else first.bonds, first.bonds)
    if len(first.bonds):
        same("interactions of bonds", array("bond_names")[array("bond_kinds")], first.bond_names * len(first.bonds))


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
    same("images", table[["ix", "iy", "iz"]], joined(lambda frame: frame.images))
    for name in frames[0].scalars:
        same(name, table[name], joined(lambda frame: frame.scalars[name]))


def pandas_thermo(path, frames):
    whole = pandas.read_csv(path.parent / "thermo.csv", float_precision="round_trip")
    table = whole[whole["stage"] == "measurement"]
    same("first and last time", table["time"].iloc[[0, -1]], [frames[0].time, frames[-1].time])
    if table["kinetic"].isna().any() or not table["events"].is_monotonic_increasing:
        raise Difference("thermo.csv: expected energies in all rows and numbers of events that rise")


ALL = [
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

# ASE accepts only chemical symbols as names in a dump.
ONLY = {ase_lammps: ["mixture", "sheared"]}
