"""Reads the trajectory of a run in extended XYZ, with only the standard library and NumPy."""

import shlex
from dataclasses import dataclass

import numpy as np


@dataclass
class Frame:
    time: float
    lower: np.ndarray
    edges: np.ndarray  # 0 along flat axes
    displacement: float  # of the next image up along y, along x
    thickness: float  # of flat axes, where a format wants a volume
    periodic: np.ndarray
    names: list  # of species, in the order of the scene
    static: np.ndarray  # by species
    masses: np.ndarray  # by species, infinite for static ones
    species: np.ndarray  # index into names, by particle
    ids: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray
    radii: np.ndarray
    images: np.ndarray  # periods travelled, by particle
    particle_masses: np.ndarray  # 0 for what never moves
    bonds: np.ndarray  # pairs of ids
    bond_names: list  # of the interactions that hold them; all by the first
    scalars: dict  # by name, a number of each particle

    @property
    def particle_names(self):
        return np.array(self.names)[self.species]

    @property
    def vectors(self):
        """The vectors of the box as rows; 0 along flat axes."""
        rows = np.diag(self.edges)
        rows[1, 0] = self.displacement
        return rows

    @property
    def unwrapped(self):
        """Unwrapped positions."""
        return self.positions + self.images @ self.vectors

    @property
    def _tilted_by(self):
        """Number of periods along x by which positions are lower in the box with sides tilted along y."""
        x, y, _ = (self.positions - (self.lower + self.edges / 2)).T
        if self.displacement == 0:
            return np.zeros(len(x))
        return np.round((x - self.displacement * y / self.edges[1]) / self.edges[0])

    @property
    def in_tilted_box(self):
        """Positions relative to the centre, in the box with sides tilted along y."""
        x, y, z = (self.positions - (self.lower + self.edges / 2)).T
        return np.column_stack([x - self._tilted_by * self.edges[0], y, z])

    @property
    def images_in_tilted_box(self):
        """Images of these positions."""
        images = self.images.copy()
        images[:, 0] += self._tilted_by.astype(int)
        return images

    @property
    def leaves_through_a_side(self):
        """For each bond, given by ids from 0: whether the shortest vector between its ends crosses a periodic side."""
        separations = self.positions[self.bonds[:, 0]] - self.positions[self.bonds[:, 1]]
        return np.any(self.periodic & (2 * np.abs(separations) > self.edges), axis=1)


def read(path):
    """All frames of a file."""
    frames = []
    with open(path, encoding="utf-8") as file:
        while line := file.readline():
            comment = dict(word.split("=", 1) for word in shlex.split(file.readline()))
            rows = [file.readline().split() for _ in range(int(line))]
            frames.append(_frame(comment, rows))
    return frames


def _frame(comment, rows):
    columns, scalars = comment["Properties"].split(":masses:R:1")
    assert columns == "type:S:1:pos:R:3:velo:R:3:radius:R:1:id:I:1:map_shift:I:3", comment["Properties"]
    scalars = [name for name in scalars.split(":") if name not in ("", "R", "1")]
    flags = lambda key, default: np.array([flag == "T" for flag in comment.get(key, default).split()])
    names = comment["species_table"].split()
    numbers = np.array([[float(word) for word in row[1:8]] for row in rows])
    flat = flags("flat", "F F F")
    lattice = np.array(comment["Lattice"].split(), float)
    edges = lattice[[0, 4, 8]]
    assert not lattice[[1, 2, 5, 6, 7]].any(), comment["Lattice"]
    return Frame(
        time=float(comment["Time"]),
        lower=np.array(comment["Origin"].split(), float),
        edges=np.where(flat, 0.0, edges),
        displacement=lattice[3],
        thickness=2 * numbers[:, 6].max(),
        periodic=flags("pbc", ""),
        names=names,
        static=flags("static", ""),
        masses=np.array(comment["species_mass"].split(), float),
        species=np.array([names.index(row[0]) for row in rows]),
        ids=np.array([int(row[8]) for row in rows]),
        positions=numbers[:, 0:3],
        velocities=numbers[:, 3:6],
        radii=numbers[:, 6],
        images=np.array([[int(word) for word in row[9:12]] for row in rows]),
        particle_masses=np.array([float(row[12]) for row in rows]),
        scalars={name: np.array([float(row[13 + k]) for row in rows]) for k, name in enumerate(scalars)},
        bond_names=comment.get("bond_table", "").split(),
        bonds=np.array([pair.split("-") for pair in comment.get("bonds", "").split()], int).reshape(-1, 2),
    )
