"""A frame: all particles at one time, and the box."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Frame"]


@dataclass(frozen=True, eq=False, repr=False)
class Frame:
    """All particles at one time, in the order of their ids, and the box.

    Attributes
    ----------
    time : float
        Simulated time `[time]`.
    positions : array, shape (n, 3)
        `[length]`, within the box along periodic axes but for round-off.
    velocities : array, shape (n, 3)
        `[length / time]`.
    images : array of int, shape (n, 3), or None
        Periods travelled since the start.
    ids : array of int, shape (n,)
        Names of the particles in every output.
    species : array of int, shape (n,)
        Indices into ``species_names``.
    radii : array, shape (n,)
        `[length]`.
    species_names : list of str
    species_masses : array
        `[mass]`; infinite where a species is static, not a number where a file does not say.
    lower, size : array, shape (3,)
        Lower corner and edges of the box `[length]`; an edge is 0 along a flat axis.
    periodic : array of bool, shape (3,)
    displacement : float
        Of the next image of the box up along y, along x, in a sheared box `[length]`.
    bonds : array of int, shape (bonds, 2)
        Ids of the two ends.
    scalars : dict of str to array, shape (n,)
        What else was measured of each particle.

    Examples
    --------
    >>> frame = carom.Simulation(fluid).frame()
    >>> frame
    <Frame at time 0: 108 particles>
    >>> frame.positions.shape
    (108, 3)
    """

    time: float
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    images: NDArray[np.int32] | None
    ids: NDArray[np.uint32]
    species: NDArray[np.uint32]
    radii: NDArray[np.float64]
    species_names: list[str]
    species_masses: NDArray[np.float64]
    lower: NDArray[np.float64]
    size: NDArray[np.float64]
    periodic: NDArray[np.bool_]
    displacement: float = 0.0
    bonds: NDArray[np.uint32] = field(default_factory=lambda: np.zeros((0, 2), dtype=np.uint32))
    scalars: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)

    @classmethod
    def _of(cls, parts: Mapping[str, Any]) -> Frame:
        arrays = {name: np.array(parts[name]) for name in ("lower", "size", "periodic")}
        return cls(**{**parts, **arrays})

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        return f"<Frame at time {self.time:g}: {len(self)} particles>"

    @property
    def unwrapped(self) -> NDArray[np.float64]:
        """Where particles would be if they had never been wrapped `[length]`, of the shape ``(n, 3)``.

        Raises
        ------
        ValueError
            If the images are not known.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> _ = simulation.advance(5.0)
        >>> frame = simulation.frame()
        >>> bool(np.allclose((frame.unwrapped - frame.positions) / frame.size, frame.images))
        True
        """
        if self.images is None:
            raise ValueError("the file of the frame does not say how often particles have left the box")
        unwrapped = self.positions + self.images * self.size
        unwrapped[:, 0] += self.images[:, 1] * self.displacement
        return unwrapped

    @property
    def masses(self) -> NDArray[np.float64]:
        """Mass of each particle `[mass]`, of the shape ``(n,)``.

        Examples
        --------
        >>> carom.Simulation(fluid).frame().masses[:3]
        array([1., 1., 1.])
        """
        return self.species_masses[self.species]

    @property
    def cell(self) -> NDArray[np.float64]:
        """Vectors of the box as rows `[length]`, of the shape ``(3, 3)``; along flat axes as thick as the largest particle.

        Examples
        --------
        >>> carom.Simulation(fluid).frame().cell.diagonal().round(3)
        array([5.734, 5.734, 5.734])
        """
        thick = 2.0 * float(self.radii.max(initial=0.5))
        cell = np.diag(np.where(self.size > 0.0, self.size, thick))
        cell[1, 0] = self.displacement
        return cell

    def to_ase(self) -> Any:
        """The frame as ``ase.Atoms``: positions, velocities, masses, cell and periodicity, with ``species``, ``radii`` and ``ids`` as arrays.

        The chemical symbol is ``X``; ASE has no species of other names. What is static has no mass.

        Raises
        ------
        ImportError
            If ASE is not installed.

        Examples
        --------
        >>> atoms = carom.Simulation(fluid).frame().to_ase()  # doctest: +ASE
        >>> len(atoms), atoms.pbc.all()  # doctest: +ASE
        (108, np.True_)
        """
        from ase import Atoms

        masses = np.where(np.isfinite(self.masses), self.masses, 0.0)
        # The cell of ASE starts at the origin.
        atoms = Atoms(
            numbers=np.zeros(len(self), dtype=int),
            positions=self.positions - self.lower,
            cell=self.cell,
            pbc=self.periodic,
        )
        # Before the velocities, which ASE keeps as momenta.
        atoms.set_masses(masses)
        atoms.set_velocities(self.velocities)
        for name in ("ids", "species", "radii"):
            atoms.set_array(name, np.array(getattr(self, name)))
        atoms.info["time"] = self.time
        atoms.info["origin"] = self.lower
        return atoms

    def to_mdanalysis(self) -> Any:
        """The frame as an ``MDAnalysis.Universe`` of one frame, with types, masses, radii, ids, velocities and bonds.

        Raises
        ------
        ImportError
            If MDAnalysis is not installed.

        Examples
        --------
        >>> universe = carom.Simulation(fluid).frame().to_mdanalysis()  # doctest: +MDANALYSIS
        >>> universe.atoms.n_atoms, universe.atoms.types[0]  # doctest: +MDANALYSIS
        (108, 'sphere')
        """
        return universe_of([self])

    def to_freud(self) -> tuple[Any, NDArray[np.float64]]:
        """The frame as ``(box, points)`` for freud: a ``freud.box.Box``, and positions in it `[length]`, of the shape ``(n, 3)``.

        freud puts the middle of the box at the origin.

        Raises
        ------
        ImportError
            If freud is not installed.

        Examples
        --------
        >>> box, points = carom.Simulation(fluid).frame().to_freud()  # doctest: +FREUD
        >>> points.shape, round(box.volume, 3)  # doctest: +FREUD
        ((108, 3), 188.496)
        """
        from freud.box import Box

        is_flat = self.size == 0.0
        if is_flat.any() and not (is_flat[2] and not is_flat[:2].any()):
            raise ValueError("freud has boxes of three dimensions, and of two that are x and y")
        x, y, z = self.size
        box = Box(Lx=x, Ly=y, Lz=z, xy=self.displacement / y, is2D=bool(is_flat[2]))
        box.periodic = tuple(bool(axis) for axis in self.periodic)
        points = self.positions - self.lower - 0.5 * self.size
        if self.displacement:
            points[:, 0] -= 0.5 * self.displacement
            points = box.wrap(points)
        return box, points


def universe_of(frames: list[Frame]) -> Any:
    """A universe of MDAnalysis with these frames."""
    import MDAnalysis
    from MDAnalysis.coordinates.memory import MemoryReader

    first = frames[0]
    if any(len(frame) != len(first) or (frame.ids != first.ids).any() for frame in frames):
        raise ValueError("MDAnalysis needs the same particles in all frames")
    universe = MDAnalysis.Universe.empty(len(first), trajectory=False, velocities=True)
    names = np.array(first.species_names, dtype=object)[first.species]
    universe.add_TopologyAttr("types", names)
    universe.add_TopologyAttr("names", names)
    universe.add_TopologyAttr("masses", np.where(np.isfinite(first.masses), first.masses, 0.0))
    universe.add_TopologyAttr("radii", first.radii)
    universe.add_TopologyAttr("ids", first.ids)
    if len(first.bonds):
        place = {int(id): at for at, id in enumerate(first.ids)}
        universe.add_TopologyAttr("bonds", [(place[int(a)], place[int(b)]) for a, b in first.bonds])
    universe.load_new(
        np.array([frame.positions for frame in frames]),
        format=MemoryReader,
        velocities=np.array([frame.velocities for frame in frames]),
        dimensions=np.array([_lengths_and_angles(frame.cell) for frame in frames], dtype=np.float32),
    )
    return universe


def _lengths_and_angles(cell: NDArray[np.float64]) -> list[float]:
    """Edges and angles in degrees of a box, as MDAnalysis has them."""
    lengths = np.linalg.norm(cell, axis=1)
    cosines = [cell[a] @ cell[b] / (lengths[a] * lengths[b]) for a, b in ((1, 2), (0, 2), (0, 1))]
    return [*lengths.tolist(), *np.degrees(np.arccos(cosines)).tolist()]
