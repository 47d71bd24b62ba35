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
    """All particles at one time, sorted by id, and the box.

    The arrays are read-only; use ``array.copy()`` for a writable copy.

    Attributes
    ----------
    time : float
        Simulated time `[time]`.
    positions : array, shape (n, 3)
        `[length]`; along periodic axes they lie within the box, up to round-off.
    velocities : array, shape (n, 3)
        `[length / time]`.
    images : array of int, shape (n, 3), or None
        Net number of box periods that each particle has travelled along each axis since the start; ``None``
        if unknown.
    ids : array of int, shape (n,)
        Numbers that identify the particles in every output.
    species : array of int, shape (n,)
        Indices into ``species_names``.
    radii : array, shape (n,)
        `[length]`.
    species_names : list of str
    species_masses : array
        `[mass]`; infinite for static species, NaN if the file does not contain the mass.
    lower, size : array, shape (3,)
        Lower corner and edge lengths of the box `[length]`; the edge length along a flat axis is 0.
    periodic : array of bool, shape (3,)
    displacement : float
        Displacement along x of the next image of the box in the direction of +y, if the box is sheared
        `[length]`.
    bonds : array of int, shape (bonds, 2)
        Ids of the two bonded particles.
    bond_names : list of str
        Names of the interactions that hold the bonds; empty if the file does not contain them.
    bond_kinds : array of int, shape (bonds,)
        Indices into ``bond_names``; empty if ``bond_names`` is empty.
    scalars : dict of str to array, shape (n,)
        Other quantities that were measured for each particle, by name.

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
        """Unwrapped positions `[length]`, an array of shape ``(n, 3)``.

        These are the positions that the particles would have without periodic wrapping.

        Raises
        ------
        ValueError
            If ``images`` is ``None``.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> _ = simulation.advance(5.0)
        >>> frame = simulation.frame()
        >>> bool(np.allclose((frame.unwrapped - frame.positions) / frame.size, frame.images))
        True
        """
        if self.images is None:
            raise ValueError("positions cannot be unwrapped: the file of this frame has no image numbers")
        unwrapped = self.positions + self.images * self.size
        unwrapped[:, 0] += self.images[:, 1] * self.displacement
        return fixed(unwrapped)

    @property
    def masses(self) -> NDArray[np.float64]:
        """Mass of each particle `[mass]`, an array of shape ``(n,)``.

        Examples
        --------
        >>> carom.Simulation(fluid).frame().masses[:3]
        array([1., 1., 1.])
        """
        return fixed(self.species_masses[self.species])

    @property
    def cell(self) -> NDArray[np.float64]:
        """Box vectors as rows `[length]`, an array of shape ``(3, 3)``.

        Along flat axes, the cell is as thick as the largest particle.

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
        """Converts the frame to ``ase.Atoms``.

        The atoms have the positions, velocities, masses, cell and periodicity of the frame. ``ids``,
        ``species``, the names of the species ``species_names``, and ``radii`` are stored as arrays.

        The chemical symbol of all particles is ``X``, because ASE has no species with other names. Static
        particles are fixed by ``FixAtoms``. Static particles and particles of unknown mass get the mass 1 of
        an ``X``, because ASE stores momenta and could not recover the velocity without a mass. If ASE writes
        the atoms to an extended XYZ file, the file contains everything except ``species``.

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
        # Sets the masses first, because ASE uses them to convert velocities to momenta.
        masses: Any = np.where(np.isfinite(self.masses), self.masses, 1.0)
        atoms.set_masses(masses)
        atoms.set_velocities(self.velocities)
        # ASE cannot write unsigned numbers.
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
        """Converts the frame to an ``MDAnalysis.Universe`` with a single frame.

        The universe has positions, types, masses, radii, ids, velocities and bonds.

        A box in MDAnalysis is periodic along all axes. If no axis of the frame is periodic, the universe has
        no box.

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
        """Converts the frame to ``(box, points)`` for freud.

        ``box`` is a ``freud.box.Box``, and ``points`` are the positions in the box `[length]`, an array of
        shape ``(n, 3)``. In freud, the centre of the box is at the origin.

        Raises
        ------
        ImportError
            If freud is not installed.
        ValueError
            If the frame is flat along x or y.

        Examples
        --------
        >>> box, points = carom.Simulation(fluid).frame().to_freud()  # doctest: +FREUD
        >>> points.shape, round(box.volume, 3)  # doctest: +FREUD
        ((108, 3), 188.496)
        """
        from freud.box import Box

        is_flat = self.size == 0.0
        if is_flat.any() and not (is_flat[2] and not is_flat[:2].any()):
            raise ValueError("freud supports only three-dimensional boxes and two-dimensional boxes in the xy plane")
        x, y, z = self.size
        box = Box(Lx=x, Ly=y, Lz=z, xy=self.displacement / y, is2D=bool(is_flat[2]))
        box.periodic = tuple(bool(axis) for axis in self.periodic)
        points = self.positions - self.lower - 0.5 * self.size
        if self.displacement:
            points[:, 0] -= 0.5 * self.displacement
            points = box.wrap(points)
        return box, points
