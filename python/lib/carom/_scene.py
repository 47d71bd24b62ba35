"""Scenes: descriptions of the systems to simulate."""

from __future__ import annotations

import operator
import os
from collections.abc import Callable, Mapping
from html import escape
from pathlib import Path
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from carom import _carom
from carom._arguments import shown, whole
from carom._arrays import fixed
from carom._html import number, table
from carom._errors import SceneError
from carom._frame import Frame
from carom._particles import (
    Names,
    given_again,
    given_of_arrays,
    given_of_ase,
    given_of_frame,
    given_of_gsd,
    given_of_mdanalysis,
    state_of,
)

__all__ = ["Scene"]


SceneLike = Union["Scene", Mapping[str, Any], str, "os.PathLike[str]"]


def overrides(seed: int | None, set: Mapping[str, Any] | None) -> list[tuple[str, str]]:
    """Overrides of a scene, in the form that the compiled module expects."""
    pairs: list[tuple[str, str]] = []
    if set is not None and not isinstance(set, Mapping):
        raise TypeError(f"set: expected a dictionary, such as {{'run.until_time': 10.0}}, found {shown(set)}")
    for key, value in (set or {}).items():
        if not isinstance(key, str):
            raise TypeError(f"set: expected keys that are strings, such as 'run.until_time', found {shown(key)}")
        pairs.append((key, _carom.Scene.value_of(value, key)))
    if seed is not None:
        pairs.append(("seed", str(whole("seed", seed))))
    return pairs


class Scene:
    """A validated scene: species, interactions, particles, the box and the settings of a run.

    Parameters
    ----------
    source : path, dict or Scene
        The path of a scene file, a dictionary with the same tables and keys, or another scene. NumPy arrays
        in a dictionary count as lists. ``docs/scene.md`` documents the keys. Relative paths in a file start
        at the folder of the file. Relative paths in a dictionary start at the working directory.
    seed : int, optional
        Seed of the random numbers; replaces the seed of the source.
    set : dict, optional
        Values to replace or add. Dots in a key separate tables. Entries of lists are given by number (from 0)
        or by name. The option ``--set`` of the program uses the same keys.
    particles : dict of arrays, optional
        Particles in addition to the particles of the source. They are not converted to text. The keys are
        ``positions`` of the shape (n, 3), or (n, 2) if z is flat `[length]`; ``species``, either one name for
        all particles, or for each particle the name or the index of its species in the source; ``velocities``
        of the same shape as the positions `[length / time]`, zero by default; ``diameters`` of the shape (n,)
        `[length]`, for species with individual diameters; ``bonds`` of the shape (m, 2),
        pairs of row indices; and ``bond``, the name of the interaction that holds these bonds. The ids of the
        particles follow the ids of ``[[particle]]``. Positions beyond a periodic side are wrapped into the
        box.
    frame : Frame, optional
        A frame, such as ``run.frames[-1]``, to use instead of ``particles``. The scene takes its particles,
        velocities and bonds, and matches species by name. The scene also takes the box of the frame, unless
        the source gives the box a size or has a ``[[fill]]``. Time and images are reset.
    bond : str, optional
        Name of the interaction that holds all bonds of the frame. By default, each bond has the interaction
        that the frame names.

    Raises
    ------
    SceneError
        If the scene is invalid. The error describes the first mistake: its key, its line, what was expected
        and the nearest valid key. For a particle, the key includes the row: ``particles.positions[7][2]``.
    TypeError
        If a scene file cannot hold a value, or an array contains anything other than numbers or names.
    ValueError
        If an array has the wrong shape.

    Examples
    --------
    >>> scene = carom.Scene(fluid, seed=7, set={"fill.0.packing_fraction": 0.4})
    >>> scene
    <Scene fluid: 108 particles in 3 dimensions, seed 7>
    >>> round(scene.packing_fraction, 12)
    0.4

    Particles from arrays. A run stores them in its folder as ``particles.xyz``:

    >>> lattice = 2.0 * np.indices((5, 5, 5)).reshape(3, -1).T
    >>> box = {**fluid, "fill": [], "space": {"size": [10.0, 10.0, 10.0]}}
    >>> velocities = np.random.default_rng(1).normal(size=lattice.shape)
    >>> carom.Scene(box, particles={"species": "sphere", "positions": lattice, "velocities": velocities})
    <Scene fluid: 125 particles in 3 dimensions, seed 1>

    Particles from a frame, in the box of the frame:

    >>> run = carom.run(fluid)
    >>> carom.Scene({**fluid, "fill": []}, frame=run.frames[-1]).size.round(3)
    array([5.734, 5.734, 5.734])
    """

    __slots__ = ("_core",)

    _core: _carom.Scene

    def __init__(
        self,
        source: SceneLike,
        *,
        seed: int | None = None,
        set: Mapping[str, Any] | None = None,
        particles: Mapping[str, Any] | None = None,
        frame: Frame | None = None,
        bond: str | None = None,
    ) -> None:
        pairs = overrides(seed, set)
        if isinstance(source, Scene) and not pairs and particles is None and frame is None:
            self._core = source._core
            return
        if particles is not None and frame is not None:
            raise TypeError("expected particles or a frame, found both")
        if bond is not None and frame is None:
            raise TypeError("bond: only for a frame; for arrays, use particles['bond']")
        text, name, pairs, given = _parts(source, pairs)
        if particles is not None:
            given = given_of_arrays(particles, lambda: _carom.Scene.species_named_in(text, name, pairs))
        if frame is not None:
            given = given_of_frame(frame, bond)
        self._core = _carom.Scene(text, name, pairs, given)

    @classmethod
    def from_ase(
        cls,
        atoms: Any,
        source: SceneLike,
        *,
        species: ArrayLike | None = None,
        seed: int | None = None,
        set: Mapping[str, Any] | None = None,
    ) -> Scene:
        """Makes a scene from ``ase.Atoms``, with their positions, velocities and cell.

        The cell and its periodic axes become the box, unless the source gives the box a size or has a
        ``[[fill]]``. Axes that are flat in the source have no extent. If the atoms have their own masses and
        radii (``atoms.arrays["masses"]`` and ``["radii"]``), these must equal the masses and radii of the
        species. Species with individual diameters take the radii of the atoms.

        Parameters
        ----------
        atoms : ase.Atoms
            The atoms, for example from ``ase.io.read("start.xyz")`` or :meth:`Frame.to_ase`.
        source : path, dict or Scene
            Everything else in the scene; see :class:`Scene`.
        species : str or array, optional
            One name for all atoms, or for each atom the name or the index of its species in the source.
            Defaults to the array ``species_names`` of the atoms, or else to their chemical symbols.
        seed, set
            As for :class:`Scene`.

        Raises
        ------
        SceneError
            If the scene is invalid. The error describes the first mistake; for an atom, it includes the
            index.
        ValueError
            If the cell is not rectangular, or if atoms of the same species have different masses.
        ImportError
            If ASE is not installed.

        Examples
        --------
        >>> import ase.build  # doctest: +ASE
        >>> argon = ase.build.bulk("Ar", "fcc", a=1.8, cubic=True).repeat(4)  # doctest: +ASE
        >>> source = {**fluid, "fill": []}  # doctest: +ASE
        >>> scene = carom.Scene.from_ase(argon, source, species="sphere")  # doctest: +ASE
        >>> len(scene), scene.size  # doctest: +ASE
        (256, array([7.2, 7.2, 7.2]))
        """
        return cls._with(source, (seed, set), lambda names: given_of_ase(atoms, species, names))

    @classmethod
    def from_gsd(
        cls,
        path: str | os.PathLike[str],
        source: SceneLike,
        *,
        frame: int = -1,
        species: ArrayLike | None = None,
        bond: str | None = None,
        seed: int | None = None,
        set: Mapping[str, Any] | None = None,
    ) -> Scene:
        """Makes a scene from a GSD file, with its positions, velocities, bonds and box.

        HOOMD-blue and Carom write such files. The scene takes the box of the file, unless the source gives
        the box a size or has a ``[[fill]]``. The box is periodic, except along axes that Carom has marked
        otherwise in the file, and flat along z in two dimensions. Masses and diameters in the file must equal
        the masses and diameters of the species. Species with individual diameters take those of the file. GSD
        files have single precision, so spheres in contact may overlap because of rounding. With
        ``separate_overlaps``, the scene moves such spheres apart.

        Parameters
        ----------
        path : path
            The file.
        source : path, dict or Scene
            Everything else in the scene; see :class:`Scene`.
        frame : int
            Index of the frame, from 0. Negative indices count from the end: -1 is the last frame.
        species : str or array, optional
            As for :meth:`from_ase`. Defaults to the particle types of the file.
        bond : str, optional
            Name of the interaction that holds all bonds. By default, each bond has the interaction with the
            name of its bond type.
        seed, set
            As for :class:`Scene`.

        Raises
        ------
        SceneError
            If the scene is invalid. The error describes the first mistake; for a particle, it includes the
            index.
        FolderError
            If the file cannot be read.
        IndexError
            If the file has no such frame.
        ValueError
            If the box is not rectangular.
        ImportError
            If the package ``gsd`` is not installed.

        Examples
        --------
        >>> run = carom.run(fluid, set={"output.formats": ["gsd"]})  # doctest: +GSD
        >>> start = carom.Scene.from_gsd(run.folder / "trajectory.gsd", {**fluid, "fill": []}, frame=0)  # doctest: +GSD
        >>> len(start)  # doctest: +GSD
        108
        """
        at = operator.index(frame)
        return cls._with(source, (seed, set), lambda names: given_of_gsd(path, at, species, bond, names))

    @classmethod
    def from_mdanalysis(
        cls,
        atoms: Any,
        source: SceneLike,
        *,
        species: ArrayLike | None = None,
        bond: str | None = None,
        seed: int | None = None,
        set: Mapping[str, Any] | None = None,
    ) -> Scene:
        """Makes a scene from an ``MDAnalysis.Universe`` or a group of its atoms.

        The scene takes the positions, velocities and box of the current time step. The box is periodic along
        all axes. If the source gives the box a size or has a ``[[fill]]``, the box of the universe is not
        used. MDAnalysis has single precision; see :meth:`from_gsd`. The masses are ignored because MDAnalysis
        may have guessed them.

        Parameters
        ----------
        atoms : MDAnalysis.Universe or AtomGroup
            The atoms.
        source : path, dict or Scene
            Everything else in the scene; see :class:`Scene`.
        species : str or array, optional
            As for :meth:`from_ase`. Defaults to the types of the atoms.
        bond : str, optional
            Name of the interaction that holds the bonds of the atoms. Without it, the scene has no bonds
            between these atoms.
        seed, set
            As for :class:`Scene`.

        Raises
        ------
        SceneError
            If the scene is invalid. The error describes the first mistake; for an atom, it includes the
            index.
        ValueError
            If the angles of the box are not right angles, or if the atoms have no types and ``species`` is
            not given.

        Examples
        --------
        >>> universe = carom.Simulation(fluid).frame().to_mdanalysis()  # doctest: +MDANALYSIS
        >>> scene = carom.Scene.from_mdanalysis(universe, {**fluid, "fill": []})  # doctest: +MDANALYSIS
        >>> len(scene), scene.size.round(3)  # doctest: +MDANALYSIS
        (108, array([5.734, 5.734, 5.734]))
        """
        return cls._with(source, (seed, set), lambda names: given_of_mdanalysis(atoms, species, bond, names))

    @classmethod
    def _with(
        cls,
        source: SceneLike,
        replaced: tuple[int | None, Mapping[str, Any] | None],
        make: Callable[[Names], _carom.Given],
    ) -> Scene:
        """Makes a scene; ``make`` creates its particles from the species names of the source."""
        text, name, pairs, _ = _parts(source, overrides(*replaced))
        scene = cls.__new__(cls)
        scene._core = _carom.Scene(text, name, pairs, make(lambda: _carom.Scene.species_named_in(text, name, pairs)))
        return scene

    @classmethod
    def from_toml(
        cls,
        text: str,
        *,
        name: str = "scene.toml",
        seed: int | None = None,
        set: Mapping[str, Any] | None = None,
    ) -> Scene:
        """Reads a scene from the text of a scene file.

        Parameters
        ----------
        text : str
            The scene in TOML.
        name : str
            File name to show in messages. Relative paths start at the folder of this file name.
        seed, set
            As for :class:`Scene`.

        Raises
        ------
        SceneError
            If the scene is invalid. The error describes the first mistake.

        Examples
        --------
        >>> carom.Scene.from_toml(carom.Scene(fluid).to_toml()).name
        'fluid'
        """
        if not isinstance(text, str):
            raise TypeError(f"expected the text of a scene file, found {type(text).__name__}")
        scene = cls.__new__(cls)
        scene._core = _carom.Scene(text, Path(name), overrides(seed, set), None)
        return scene

    @classmethod
    def _of(cls, core: _carom.Scene) -> Scene:
        scene = cls.__new__(cls)
        scene._core = core
        return scene

    def to_toml(self) -> str:
        """TOML text from which the scene can be recreated anywhere.

        The text includes all replaced values and uses absolute paths. It lists particles from arrays one by
        one.

        Raises
        ------
        SceneError
            If a file that the scene reads has changed, or if the particles come from a frame of a sheared box
            with displaced images. A list of particles cannot represent this displacement.

        Examples
        --------
        >>> 'arrangement = "fcc"' in carom.Scene(fluid).to_toml()
        True
        """
        return self._core.record()

    def to_dict(self) -> dict[str, Any]:
        """The scene as a dictionary, with the tables and keys of a scene file.

        Examples
        --------
        >>> carom.Scene(fluid, seed=3).to_dict()["seed"]
        3
        """
        return _carom.parse_toml(self._core.record())

    def describe(self) -> str:
        """Describes the scene in words, as ``carom check`` does.

        The description includes warnings about settings that are valid but probably unintended.

        Examples
        --------
        >>> print(carom.Scene(fluid).describe().splitlines()[1].strip())
        particles     108 sphere
        """
        warnings = "".join(f"warning: {warning}\n" for warning in self._core.warnings())
        return self._core.description() + warnings

    @property
    def name(self) -> str:
        """Name of the scene, which also names the folders of its runs.

        Examples
        --------
        >>> carom.Scene(fluid).name
        'fluid'
        """
        return self._core.name

    @property
    def seed(self) -> int:
        """Seed of the random numbers that place particles, draw velocities and drive thermostats.

        Examples
        --------
        >>> carom.Scene(fluid).seed
        1
        """
        return self._core.seed

    @property
    def dimensions(self) -> int:
        """Number of axes along which particles move: 1, 2 or 3.

        Examples
        --------
        >>> carom.Scene(fluid).dimensions
        3
        """
        return self._core.dimensions

    @property
    def packing_fraction(self) -> float | None:
        """Fraction of the box that the particles fill; ``None`` if a side of the box is open.

        Examples
        --------
        >>> round(carom.Scene(fluid).packing_fraction, 6)
        0.3
        """
        return self._core.packing_fraction

    @property
    def size(self) -> NDArray[np.float64]:
        """Edge lengths of the box `[length]`, of the shape ``(3,)``; 0 along flat axes.

        Examples
        --------
        >>> carom.Scene(fluid).size.round(3)
        array([5.734, 5.734, 5.734])
        """
        return fixed(np.array(self._core.space()[1]))

    @property
    def lower(self) -> NDArray[np.float64]:
        """Lower corner of the box `[length]`, of the shape ``(3,)``.

        Examples
        --------
        >>> carom.Scene(fluid).lower
        array([0., 0., 0.])
        """
        return fixed(np.array(self._core.space()[0]))

    @property
    def periodic(self) -> NDArray[np.bool_]:
        """Whether each axis is periodic, of the shape ``(3,)``.

        Examples
        --------
        >>> carom.Scene(fluid).periodic
        array([ True,  True,  True])
        """
        return fixed(np.array(self._core.space()[2]))

    @property
    def species_names(self) -> list[str]:
        """Names of the species; :attr:`species` contains indices into this list.

        Examples
        --------
        >>> carom.Scene(fluid).species_names
        ['sphere']
        """
        return [name for name, _, _ in self._core.species_table()]

    @property
    def masses(self) -> NDArray[np.float64]:
        """Mass of each species `[mass]`; infinite for static species.

        Examples
        --------
        >>> carom.Scene(fluid).masses
        array([1.])
        """
        return fixed(np.array([mass for _, mass, _ in self._core.species_table()]))

    @property
    def _frame_masses(self) -> NDArray[np.float64]:
        """Masses of the species in frames: unknown (NaN) for a species with particles of different masses."""
        return fixed(np.array(self._core.frame_masses()))

    @property
    def diameters(self) -> NDArray[np.float64]:
        """Initial diameter of each species `[length]`; the nominal diameter if diameters are individual.

        Examples
        --------
        >>> carom.Scene(fluid).diameters
        array([1.])
        """
        return fixed(np.array([diameter for _, _, diameter in self._core.species_table()]))

    @property
    def species(self) -> NDArray[np.int64]:
        """Index of the species of each particle, of the shape ``(n,)``.

        Examples
        --------
        >>> carom.Scene(fluid).species.shape
        (108,)
        """
        return self._core.species()

    @property
    def positions(self) -> NDArray[np.float64]:
        """Initial positions `[length]`, of the shape ``(n, 3)``.

        Examples
        --------
        >>> carom.Scene(fluid).positions.shape
        (108, 3)
        """
        return self._core.positions()

    @property
    def velocities(self) -> NDArray[np.float64]:
        """Initial velocities `[length / time]`, of the shape ``(n, 3)``.

        Examples
        --------
        >>> v = carom.Scene(fluid).velocities
        >>> round(float((v**2).sum() / (3 * 107)), 9)  # the temperature
        1.0
        """
        return self._core.velocities()

    @property
    def bonds(self) -> NDArray[np.int64]:
        """Ids of the two ends of each bond, of the shape ``(bonds, 2)``.

        Examples
        --------
        >>> carom.Scene(fluid).bonds.shape
        (0, 2)
        """
        return self._core.bonds()

    def __len__(self) -> int:
        return self._core.count

    def __repr__(self) -> str:
        core = self._core
        return f"<Scene {core.name}: {core.count} particles in {core.dimensions} dimensions, seed {core.seed}>"

    def _repr_html_(self) -> str:
        filled = "" if self.packing_fraction is None else f", packing fraction {self.packing_fraction:.6g}"
        caption = f"<b>{escape(self.name)}</b>: {len(self)} particles in {self.dimensions} dimensions, seed {self.seed}{filled}"
        counts = np.bincount(self.species, minlength=len(self.species_names))
        rows = [[number(cell) for cell in row] for row in zip(self.species_names, counts, self.masses, self.diameters)]
        return table(caption, ["species", "particles", "mass", "diameter"], rows)

    def __getstate__(self) -> tuple[Any, ...]:
        text, name, pairs = self._core.source()
        given = self._core.given()
        return text, Path(os.path.abspath(name)), pairs, None if given is None else state_of(given)

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        text, name, pairs, *rest = state
        self._core = _carom.Scene(text, name, pairs, given_again(rest[0]) if rest and rest[0] is not None else None)


def endless(source: SceneLike, seed: int | None, set: Mapping[str, Any] | None) -> Scene:
    """A scene for a simulation, which needs no end of the run.

    If ``[run]`` or its end is missing in the source, the scene gets ``run.until_events = 1``.
    """
    try:
        return Scene(source, seed=seed, set=set)
    except SceneError as error:
        if error.missing not in ("run", "run.until_time"):
            raise
    return Scene(source, seed=seed, set={**(set or {}), "run.until_events": 1})


def _parts(source: SceneLike, pairs: list[tuple[str, str]]) -> tuple[str, Path, list[tuple[str, str]], _carom.Given | None]:
    """Text of a scene, its file name, all overrides, and its additional particles."""
    if isinstance(source, Scene):
        text, name, before = source._core.source()
        replaced = {key for key, _ in pairs}
        return text, name, [pair for pair in before if pair[0] not in replaced] + pairs, source._core.given()
    if isinstance(source, Mapping):
        return _carom.Scene.toml_of(source), Path(f"{source.get('name', 'scene')}.toml"), pairs, None
    if not isinstance(source, (str, os.PathLike)):
        kind = type(source).__name__
        raise TypeError(f"expected the path of a scene file, a dictionary or a Scene, found {kind}")
    path = Path(source)
    if isinstance(source, str) and "\n" in source:
        raise TypeError("expected the path of a scene file, found several lines of text: pass the text of a scene to carom.Scene.from_toml")
    try:
        return path.read_text(encoding="utf-8"), path, pairs, None
    except (OSError, UnicodeDecodeError) as error:
        cure = None
        if isinstance(source, str) and source in _carom.examples():
            cure = f"use carom.example({source!r}) for the example scene of this name"
        help = f"\n  help: {cure}" if cure else ""
        raise SceneError(f"cannot read {path}: {error}{help}", problem=str(error), cure=cure) from error
