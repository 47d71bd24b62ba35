"""A frame: all particles at one time, and the box."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from carom._arrays import fixed
from carom._html import number, table

__all__ = ["Frame"]


@dataclass(frozen=True, eq=False, repr=False)
class Frame:
    """All particles at one time, in the order of their ids, and the box. Its arrays are for reading only; ``array.copy()`` can be written to.

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
    bond_names : list of str
        Names of the interactions that hold bonds; empty where a file does not say.
    bond_kinds : array of int, shape (bonds,)
        Indices into ``bond_names``; of no bonds where these are empty.
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
    ids: NDArray[np.int64]
    species: NDArray[np.int64]
    radii: NDArray[np.float64]
    species_names: list[str]
    species_masses: NDArray[np.float64]
    lower: NDArray[np.float64]
    size: NDArray[np.float64]
    periodic: NDArray[np.bool_]
    displacement: float = 0.0
    bonds: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    scalars: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    bond_names: list[str] = field(default_factory=list)
    bond_kinds: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    @classmethod
    def _of(cls, parts: Mapping[str, Any]) -> Frame:
        arrays: dict[str, Any] = {name: fixed(np.array(parts[name])) for name in ("lower", "size", "periodic")}
        return cls(**{**parts, **arrays})

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        return f"<Frame at time {self.time:g}: {len(self)} particles>"

    def _repr_html_(self) -> str:
        counts = np.bincount(self.species, minlength=len(self.species_names))
        edges = " &times; ".join(f"{edge:.6g}" for edge in self.size if edge > 0.0)
        caption = f"Frame at time {self.time:.6g}: {len(self)} particles in a box of {edges or 'no size'}"
        return table(caption, ["species", "particles"], [[number(name), number(count)] for name, count in zip(self.species_names, counts)])

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
        return fixed(unwrapped)

    @property
    def masses(self) -> NDArray[np.float64]:
        """Mass of each particle `[mass]`, of the shape ``(n,)``.

        Examples
        --------
        >>> carom.Simulation(fluid).frame().masses[:3]
        array([1., 1., 1.])
        """
        return fixed(self.species_masses[self.species])

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
        return fixed(cell)

    def to_ase(self) -> Any:
        """The frame as ``ase.Atoms``: positions, velocities, masses, cell and periodicity, with ``ids``, ``species`` and their names
        ``species_names``, and ``radii`` as arrays.

        The chemical symbol is ``X``; ASE has no species of other names. What is static is held by ``FixAtoms``. That, and what has no known mass, has the
        mass 1 of an ``X``: ASE keeps momenta, and of no mass there would be no velocity. Files in extended XYZ have all of it but ``species``.

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
        from ase.constraints import FixAtoms

        # The cell of ASE starts at the origin.
        atoms = Atoms(
            numbers=np.zeros(len(self), dtype=int),
            positions=self.positions - self.lower,
            cell=self.cell,
            pbc=self.periodic,
        )
        # Before the velocities, which ASE stores as momenta.
        masses: Any = np.where(np.isfinite(self.masses), self.masses, 1.0)
        atoms.set_masses(masses)
        atoms.set_velocities(self.velocities)
        # No unsigned numbers, because ASE writes none.
        for name, kind in (("ids", np.int64), ("species", np.int64), ("radii", np.float64)):
            atoms.set_array(name, np.array(getattr(self, name), dtype=kind))
        atoms.set_array("species_names", np.array(self.species_names, dtype=str)[self.species])
        is_static = np.isinf(self.masses)
        if is_static.any():
            atoms.set_constraint(FixAtoms(mask=is_static))
        atoms.info["time"] = self.time
        atoms.info["origin"] = np.array(self.lower)
        return atoms

    def to_mdanalysis(self) -> Any:
        """The frame as an ``MDAnalysis.Universe`` of one frame, with types, masses, radii, ids, velocities and bonds.

        A box of MDAnalysis is periodic along all axes: there is none where no axis is.

        Warns
        -----
        CaromWarning
            If some axes are periodic and others are not.

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
        from carom._mdanalysis import universe_of

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
