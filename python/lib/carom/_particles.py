"""Particles for a scene, read from arrays and from objects and files of other packages."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from carom import _carom
from carom._arguments import path_of
from carom._errors import FolderError
from carom._frame import Frame

__all__ = [
    "Names",
    "given_again",
    "given_of_arrays",
    "given_of_ase",
    "given_of_frame",
    "given_of_gsd",
    "given_of_mdanalysis",
    "state_of",
]

_KEYS = ("species", "positions", "velocities", "diameters", "bonds", "bond")

#: Smaller skews, relative to an edge, are round-off of single precision.
_SKEW = 1e-6

#: With more names than this, sorting the array is faster than searching for each name.
_FEW_NAMES = 64

#: Pickled form of given particles: the name in messages, the frame, the interaction of the bonds, and three flags.
# The flags tell whether the box is known, whether the radii are known, and whether z is unknown.
State = tuple[str, Frame, Union[str, None], tuple[bool, bool, bool]]

#: Returns the names of the species in a scene, for species that are given by number.
Names = Callable[[], list[str]]


def given_of_arrays(particles: Mapping[str, Any], names: Names) -> _carom.Given:
    """Particles from a dictionary of arrays."""
    if not isinstance(particles, Mapping):
        kind = type(particles).__name__
        raise TypeError(f"particles: expected a dictionary with 'species' and 'positions', found {kind}")
    unknown = [key for key in particles if key not in _KEYS]
    if unknown:
        raise ValueError(f"particles: unknown key {unknown[0]!r}, expected one of {', '.join(map(repr, _KEYS))}")
    missing = [key for key in _KEYS[:2] if particles.get(key) is None]
    if missing:
        raise ValueError(f"particles: {missing[0]!r} is missing: both 'species' and 'positions' are needed")
    positions = _rows("particles: positions", particles["positions"], (3, 2))
    is_plane = positions.shape[1] == 2
    velocities = particles.get("velocities")
    if velocities is not None:
        velocities = _rows("particles: velocities", velocities, positions.shape[1:], len(positions))
    species_names, species = _species("particles: species", particles["species"], len(positions), names)
    diameters = particles.get("diameters")
    if diameters is not None:
        diameters = np.asarray(diameters, dtype=np.float64)
        if diameters.shape != (len(positions),):
            raise ValueError(f"particles: expected diameters of shape ({len(positions)},), found {diameters.shape}")
    bonds = particles.get("bonds")
    frame = _frame(
        positions=_in_space(positions),
        velocities=None if velocities is None else _in_space(velocities),
        species_names=species_names,
        species=species,
        radii=None if diameters is None else 0.5 * diameters,
        bonds=None if bonds is None else _pairs("particles: bonds", bonds, len(positions)),
    )
    return _given("particles", frame, _bond(particles.get("bond")), (False, diameters is not None, is_plane))


def given_of_frame(frame: Frame, bond: str | None) -> _carom.Given:
    """Particles, bonds and box of a frame."""
    if not isinstance(frame, Frame):
        raise TypeError(f"frame: expected a carom.Frame, such as run.frames[-1], found {type(frame).__name__}")
    positions = _rows("frame: positions", frame.positions, (3,))
    count = len(positions)
    _rows("frame: velocities", frame.velocities, (3,), count)
    for name in ("ids", "species", "radii"):
        if np.shape(getattr(frame, name)) != (count,):
            raise ValueError(f"frame: expected {name} of shape ({count},), found {np.shape(getattr(frame, name))}")
    return _given("frame", frame, _bond(bond), (True, True, False))


def given_of_ase(atoms: Any, species: Any, names: Names) -> _carom.Given:
    """Particles and cell of ``ase.Atoms``."""
    from ase import Atoms
    from ase.data import chemical_symbols

    if not isinstance(atoms, Atoms):
        raise TypeError(f"atoms: expected ase.Atoms, found {type(atoms).__name__}")
    count = len(atoms)
    if species is not None:
        species_names, numbers = _species("species", species, count, names)
    elif (named := next((name for name in ("species_names", "type") if _holds_names(atoms.arrays.get(name))), None)) is not None:
        species_names, numbers = _species(named, atoms.arrays[named], count, names)
    else:
        found, numbers = np.unique(atoms.numbers, return_inverse=True)
        species_names = [chemical_symbols[number] for number in found]
    # `Frame.to_ase` subtracts the lower corner of the box from the positions, and stores the corner as `origin`. A
    # trajectory file of Carom keeps the positions, stores the corner as `Origin`, and has the columns `type`, `velo`
    # and `radius`.
    origin = np.asarray(atoms.info.get("origin", np.zeros(3)), dtype=np.float64).reshape(3)
    corner = np.asarray(atoms.info.get("Origin", np.zeros(3)), dtype=np.float64).reshape(3) + origin
    masses = _mass_of_each("atoms", atoms.get_masses(), numbers, species_names) if atoms.has("masses") else None
    radii = next((atoms.arrays[name] for name in ("radii", "radius") if name in atoms.arrays), None)
    velocities = atoms.get_velocities() if atoms.has("momenta") else atoms.arrays.get("velo")
    cell = np.array(atoms.cell)
    is_flat = np.asarray(atoms.info.get("flat", np.zeros(3)), dtype=bool).reshape(3)
    frame = _frame(
        positions=np.asarray(atoms.positions, dtype=np.float64) + origin,
        velocities=velocities,
        species_names=species_names,
        species=numbers,
        species_masses=masses,
        radii=radii,
        lower=corner,
        size=np.where(is_flat, 0.0, cell.diagonal()),
        periodic=np.array(atoms.pbc, dtype=bool) & ~is_flat,
        displacement=_displacement("atoms", cell),
    )
    return _given("atoms", frame, None, (bool(cell.any()), radii is not None, False))


def _holds_names(column: Any) -> bool:
    if column is None:
        return False
    names = np.asarray(column)
    return names.dtype.kind in "US" or (names.dtype == object and all(isinstance(name, str) for name in names))


def given_of_gsd(path: str | os.PathLike[str], frame: int, species: Any, bond: str | None, names: Names) -> _carom.Given:
    """Particles, bonds and box of a frame of a GSD file."""
    import gsd.hoomd

    file = path_of("path", path)
    try:
        with gsd.hoomd.open(str(file), "r") as trajectory:
            count = len(trajectory)
            if not -count <= frame < count:
                raise IndexError(f"frame {frame} of {count} in {file}")
            at = frame % count
            snapshot = trajectory[at]
            # HOOMD-blue replaces missing values by defaults. Only the file shows which values are missing.
            has = {name: any(trajectory.file.chunk_exists(it, f"particles/{name}") for it in (0, at)) for name in _OPTIONAL}
    except (OSError, RuntimeError) as error:
        raise FolderError(f"cannot read {file}: {error}") from error
    return _given_of_snapshot(snapshot, has, (species, bond), names)


_OPTIONAL = ("mass", "diameter", "velocity")


def _given_of_snapshot(snapshot: Any, has: Mapping[str, bool], named: tuple[Any, str | None], names: Names) -> _carom.Given:
    species, bond = named
    particles, bonds = snapshot.particles, snapshot.bonds
    edges = np.asarray(snapshot.configuration.box, dtype=np.float64)
    cell = np.diag(edges[:3])
    cell[1, 0], cell[2, 0], cell[2, 1] = edges[3] * edges[1], edges[4] * edges[2], edges[5] * edges[2]
    size, is_plane = edges[:3].copy(), snapshot.configuration.dimensions == 2
    if is_plane:
        size[2] = 0.0
    centre = np.asarray(snapshot.log.get("carom/centre", np.zeros(3)), dtype=np.float64).reshape(3)
    periodic = np.asarray(snapshot.log.get("carom/periodic", np.ones(3)), dtype=bool).reshape(3) & (size > 0.0)
    count = int(particles.N)
    types, kinds = list(particles.types), np.asarray(particles.typeid, dtype=np.int64)
    if species is not None:
        types, kinds = _species("species", species, count, names)
    masses = _mass_of_each("particles", particles.mass, kinds, types) if has["mass"] else None
    holds = None if not bonds.N else np.asarray(bonds.group, dtype=np.int64)
    frame = _frame(
        positions=np.asarray(particles.position, dtype=np.float64) + centre,
        velocities=particles.velocity if has["velocity"] else None,
        species_names=types,
        species=kinds,
        species_masses=masses,
        radii=0.5 * np.asarray(particles.diameter, dtype=np.float64) if has["diameter"] else None,
        lower=centre - 0.5 * size,
        size=size,
        periodic=periodic,
        displacement=_displacement("the box", cell),
        bonds=holds,
        bond_names=[] if holds is None else list(bonds.types),
        bond_kinds=None if holds is None else np.asarray(bonds.typeid, dtype=np.int64),
    )
    return _given("particles", frame, _bond(bond), (bool((edges[:3] > 0.0).any()), has["diameter"], False))


def given_of_mdanalysis(atoms: Any, species: Any, bond: str | None, names: Names) -> _carom.Given:
    """Particles, bonds and box of a universe or a group of its atoms, at the current time step."""
    group = getattr(atoms, "atoms", None)
    if group is None or not hasattr(group, "universe"):
        raise TypeError(f"atoms: expected a Universe or an AtomGroup of MDAnalysis, found {type(atoms).__name__}")
    count, step = len(group), group.universe.trajectory.ts
    if species is None and not hasattr(group, "types"):
        raise ValueError("the universe has no atom types: pass species")
    species_names, numbers = _species("species", group.types if species is None else species, count, names)
    box = None if step.dimensions is None else np.asarray(step.dimensions, dtype=np.float64)
    has_box = box is not None and bool((box[:3] > 0.0).any())
    if box is not None and has_box and (np.abs(box[3:] - 90.0) > 1e-3).any():
        raise ValueError(f"atoms: expected a box with right angles, found angles of {box[3:].tolist()} degrees")
    size = np.zeros(3) if box is None else box[:3]
    bonds = None
    if bond is not None and hasattr(group, "bonds") and len(group.bonds):
        place = np.full(len(group.universe.atoms), -1, dtype=np.int64)
        place[group.ix] = np.arange(count)
        ends = place[np.asarray(group.bonds.to_indices(), dtype=np.int64)]
        bonds = ends[(ends >= 0).all(axis=1)]
    frame = _frame(
        positions=group.positions,
        velocities=group.velocities if step.has_velocities else None,
        species_names=species_names,
        species=numbers,
        size=size,
        periodic=size > 0.0,
        bonds=bonds,
    )
    return _given("atoms", frame, _bond(bond), (has_box, False, False))


def _frame(
    *,
    positions: Any,
    velocities: Any,
    species_names: list[str],
    species: NDArray[np.int64],
    species_masses: Any = None,
    radii: Any = None,
    lower: Any = None,
    size: Any = None,
    periodic: Any = None,
    displacement: float = 0.0,
    bonds: Any = None,
    bond_names: list[str] | None = None,
    bond_kinds: Any = None,
) -> Frame:
    """A frame in which missing parts get default values."""
    count = len(positions)
    return Frame(
        time=0.0,
        positions=np.asarray(positions, dtype=np.float64),
        velocities=np.zeros((count, 3)) if velocities is None else np.asarray(velocities, dtype=np.float64),
        images=None,
        ids=np.arange(count, dtype=np.int64),
        species=species,
        radii=np.zeros(count) if radii is None else np.asarray(radii, dtype=np.float64),
        species_names=species_names,
        species_masses=np.full(len(species_names), np.nan) if species_masses is None else species_masses,
        lower=np.zeros(3) if lower is None else lower,
        size=np.zeros(3) if size is None else np.asarray(size, dtype=np.float64),
        periodic=np.ones(3, dtype=bool) if periodic is None else periodic,
        displacement=displacement,
        bonds=np.zeros((0, 2), dtype=np.int64) if bonds is None else bonds,
        bond_names=bond_names or [],
        bond_kinds=np.zeros(0, dtype=np.int64) if bond_kinds is None else bond_kinds,
    )


def _given(name: str, frame: Frame, bond: str | None, known: tuple[bool, bool, bool]) -> _carom.Given:
    """Passes the frame to the compiled module.

    ``known`` tells whether the box is known, whether the radii are known, and whether the positions have only
    x and y.
    """
    kinds = {"positions": "f8", "velocities": "f8", "radii": "f8", "species_masses": "f8"}
    kinds |= {"ids": "i8", "species": "i8", "bonds": "i8", "bond_kinds": "i8"}
    parts: dict[str, Any] = {it: np.asarray(getattr(frame, it), dtype=kind).tobytes() for it, kind in kinds.items()}
    images = np.zeros((0, 3)) if frame.images is None else frame.images
    parts["images"] = np.asarray(images, dtype=np.int32).tobytes()
    for part in ("lower", "size", "periodic"):
        parts[part] = np.asarray(getattr(frame, part)).tolist()
    scalars = {str(it): np.asarray(values, dtype=np.float64).tobytes() for it, values in frame.scalars.items()}
    parts |= {"scalars": scalars, "time": float(frame.time), "displacement": float(frame.displacement)}
    parts |= {"species_names": list(frame.species_names), "bond_names": list(frame.bond_names)}
    return _carom.Given(name, parts, bond, known)


def given_again(state: State) -> _carom.Given:
    """Restores particles from their pickled state."""
    return _given(*state)


def state_of(given: _carom.Given) -> State:
    """State of the particles for pickling."""
    name, parts, bond, (has_box, has_radii, is_plane) = given.parts()
    return name, Frame._of(parts), bond, (has_box, has_radii, is_plane)


def _bond(bond: Any) -> str | None:
    if bond is not None and not isinstance(bond, str):
        raise TypeError(f"bond: expected the name of an interaction of the scene, found {type(bond).__name__}")
    return bond


def _array(name: str, value: Any) -> NDArray[Any]:
    try:
        return np.asarray(value)
    except ValueError as error:
        raise ValueError(f"{name}: expected an array, found rows of unequal lengths") from error


def _rows(name: str, value: Any, columns: tuple[int, ...], count: int | None = None) -> NDArray[Any]:
    """Checks that the value is a 2D array of real numbers. ``columns`` lists the allowed numbers of columns."""
    array = _array(name, value)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name}: expected real numbers, found an array of {array.dtype}")
    rows = "n" if count is None else str(count)
    if array.ndim != 2 or array.shape[1] not in columns or (count is not None and len(array) != count):
        shapes = " or ".join(f"({rows}, {number})" for number in columns)
        raise ValueError(f"{name}: expected an array of shape {shapes}, found {array.shape}")
    if np.ma.is_masked(value):
        raise ValueError(f"{name}: expected real numbers, found a masked array with masked values")
    return array


def _in_space(rows: NDArray[Any]) -> NDArray[np.float64]:
    """Rows with three columns; if there are only two, the third is filled with 0."""
    if rows.shape[1] == 3:
        return rows.astype(np.float64, copy=False)
    space = np.zeros((len(rows), 3))
    space[:, :2] = rows
    return space


def _pairs(name: str, value: Any, count: int) -> NDArray[np.int64]:
    """Checks that the rows of an array are pairs of particle indices, and returns the array."""
    array = _array(name, value)
    if array.size == 0:
        return np.zeros((0, 2), dtype=np.int64)
    if array.dtype.kind not in "iu":
        raise TypeError(f"{name}: expected whole numbers, found an array of {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"{name}: expected an array of shape (m, 2), found {array.shape}")
    if array.min() < 0 or array.max() >= count:
        raise ValueError(f"{name}: expected particle indices from 0 to {count - 1}, found {array.min()} to {array.max()}")
    return array.astype(np.int64)


def _species(name: str, value: ArrayLike, count: int, names: Names) -> tuple[list[str], NDArray[np.int64]]:
    """Names of the species, and for each particle the index of its species in these names."""
    if isinstance(value, str):
        return [value], np.zeros(count, dtype=np.int64)
    array = _array(name, value)
    if array.shape != (count,):
        raise ValueError(f"{name}: expected one name, or a name for each of {count} particles, found an array of shape {array.shape}")
    if array.dtype.kind in "iu":
        known = names()
        if not known:
            raise ValueError(f"{name}: species are numbers, but the source has no list of species names: use names")
        wrong = np.flatnonzero((array < 0) | (array >= len(known)))
        if len(wrong):
            raise ValueError(f"{name}: particle {wrong[0]} has the species number {array[wrong[0]]}, expected one from 0 to {len(known) - 1}")
        return known, array.astype(np.int64)
    if count and (array.dtype.kind not in "UO" or not isinstance(array[0], str)):
        raise TypeError(f"{name}: expected names or numbers of species, found an array of {array.dtype}")
    return _numbered(name, array)


def _numbered(name: str, array: NDArray[Any]) -> tuple[list[str], NDArray[np.int64]]:
    """Unique names in the array, and for each entry the index of its name."""
    found: list[str] = []
    numbers = np.full(len(array), -1, dtype=np.int64)
    first = 0
    while first < len(array) and len(found) < _FEW_NAMES:
        numbers[np.asarray(array == array[first])] = len(found)
        found.append(array[first])
        left = np.flatnonzero(numbers[first:] < 0)
        first = len(array) if len(left) == 0 else first + int(left[0])
    if first < len(array):
        every = array.tolist()
        found = list(dict.fromkeys(every))
        places = {it: place for place, it in enumerate(found)}
        numbers = np.array([places[it] for it in every], dtype=np.int64)
    wrong = [it for it in found if not isinstance(it, str)]
    if wrong:
        raise TypeError(f"{name}: expected names of species, found {wrong[0]!r}")
    return [str(it) for it in found], numbers


def _mass_of_each(name: str, masses: Any, species: NDArray[np.int64], names: list[str]) -> NDArray[np.float64]:
    """Mass of each species, which all particles of the species must share.

    The mass is NaN if a species has no particles or no positive mass, such as a static species.
    """
    all_masses = np.asarray(masses, dtype=np.float64)
    of_each = np.full(len(names), np.nan)
    for number, of_name in enumerate(names):
        its = all_masses[species == number]
        if not len(its) or not its[0] > 0.0:
            continue
        if (its != its[0]).any():
            raise ValueError(f"{name}: the particles of species `{of_name}` have masses from {its.min()} to {its.max()}, expected the same mass for all")
        of_each[number] = its[0]
    return of_each


def _displacement(name: str, cell: NDArray[np.float64]) -> float:
    """Displacement along x of the next image of the box in the direction of +y.

    Raises an error if the box is skewed in any other way.
    """
    askew = cell - np.diag(cell.diagonal())
    askew[1, 0] = 0.0
    if (np.abs(askew) > _SKEW * np.abs(cell).max(initial=0.0)).any() or (cell.diagonal() < 0.0).any():
        raise ValueError(f"{name}: expected a rectangular box along x, y and z, found the vectors {cell.tolist()}")
    return float(cell[1, 0]) if abs(cell[1, 0]) > _SKEW * cell[0, 0] else 0.0
