"""Scenes: what is simulated."""

from __future__ import annotations

import os
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from carom import _carom
from carom._arguments import shown, whole
from carom._arrays import fixed
from carom._html import number, table

__all__ = ["Scene"]

SceneLike = Union["Scene", Mapping[str, Any], str, "os.PathLike[str]"]


def overrides(seed: int | None, set: Mapping[str, Any] | None) -> list[tuple[str, str]]:
    """Overrides of a scene, as the compiled part takes them."""
    pairs: list[tuple[str, str]] = []
    for key, value in (set or {}).items():
        if not isinstance(key, str):
            raise TypeError(f"set: expected keys that are strings, such as 'run.until_time', found {shown(key)}")
        pairs.append((key, _carom.Scene.value_of(value, key)))
    if seed is not None:
        pairs.append(("seed", str(whole("seed", seed))))
    return pairs


class Scene:
    """A validated scene: species, interactions, particles, the box, and what a run of it does.

    Parameters
    ----------
    source : path, dict or Scene
        The path of a scene file, or a dictionary with the same tables and keys (arrays of NumPy are lists), or another scene. The keys are those of
        ``docs/scene.md``. Relative paths in a file start at its folder, those in a dictionary where the program runs.
    seed : int, optional
        Replaces the seed of the random numbers.
    set : dict, optional
        Replaces or adds values: keys with dots between tables, entries of lists by number (from 0) or by name, as
        ``--set`` of the program takes them.

    Raises
    ------
    SceneError
        With the first mistake: its key, its line, what was expected and the nearest valid key.
    TypeError
        If a value is none that a scene file can hold.

    Examples
    --------
    >>> scene = carom.Scene(fluid, seed=7, set={"fill.0.packing_fraction": 0.4})
    >>> scene
    <Scene fluid: 108 particles in 3 dimensions, seed 7>
    >>> round(scene.packing_fraction, 12)
    0.4
    """

    __slots__ = ("_core",)

    _core: _carom.Scene

    def __init__(self, source: SceneLike, *, seed: int | None = None, set: Mapping[str, Any] | None = None) -> None:
        pairs = overrides(seed, set)
        if isinstance(source, Scene):
            if not pairs:
                self._core = source._core
                return
            text, name, before = source._core.source()
            replaced = {key for key, _ in pairs}
            pairs = [pair for pair in before if pair[0] not in replaced] + pairs
            self._core = _carom.Scene(text, name, pairs)
        elif isinstance(source, Mapping):
            name = source.get("name", "scene")
            self._core = _carom.Scene(_carom.Scene.toml_of(source), Path(f"{name}.toml"), pairs)
        elif isinstance(source, (str, os.PathLike)):
            path = Path(source)
            if isinstance(source, str) and "\n" in source:
                raise TypeError("expected a path, found text of several lines: use carom.Scene.from_toml for that")
            try:
                text = path.read_text(encoding="utf-8")
            except (OSError, UnicodeDecodeError) as error:
                from carom._errors import SceneError

                raise SceneError(f"cannot read {path}: {error}", problem=str(error)) from error
            self._core = _carom.Scene(text, path, pairs)
        else:
            kind = type(source).__name__
            raise TypeError(f"expected the path of a scene file, a dictionary or a Scene, found {kind}")

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
            TOML.
        name : str
            What stands for the file in messages, and as the place where relative paths start.
        seed, set
            As for :class:`Scene`.

        Raises
        ------
        SceneError
            With the first mistake.

        Examples
        --------
        >>> carom.Scene.from_toml(carom.Scene(fluid).to_toml()).name
        'fluid'
        """
        if not isinstance(text, str):
            raise TypeError(f"expected the text of a scene file, found {type(text).__name__}")
        scene = cls.__new__(cls)
        scene._core = _carom.Scene(text, Path(name), overrides(seed, set))
        return scene

    def to_toml(self) -> str:
        """The text from which the scene can be made again anywhere: everything replaced that was to be, with absolute paths.

        Raises
        ------
        SceneError
            If a file that it reads has changed.

        Examples
        --------
        >>> 'arrangement = "fcc"' in carom.Scene(fluid).to_toml()
        True
        """
        return self._core.record()

    def to_dict(self) -> dict[str, Any]:
        """Record of the scene as a dictionary, with the tables and keys of a scene file.

        Examples
        --------
        >>> carom.Scene(fluid, seed=3).to_dict()["seed"]
        3
        """
        return _carom.parse_toml(self._core.record())

    def describe(self) -> str:
        """Description of the scene in words, with warnings of settings that are allowed and probably not meant, as ``carom check`` prints it.

        Examples
        --------
        >>> print(carom.Scene(fluid).describe().splitlines()[1].strip())
        particles     108 sphere
        """
        warnings = "".join(f"warning: {warning}\n" for warning in self._core.warnings())
        return self._core.description() + warnings

    @property
    def name(self) -> str:
        """Name of the scene, which runs have as that of their folder.

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
        """Part of the box that the particles which move fill; ``None`` where a side is open.

        Examples
        --------
        >>> round(carom.Scene(fluid).packing_fraction, 6)
        0.3
        """
        return self._core.packing_fraction

    @property
    def size(self) -> NDArray[np.float64]:
        """Edges of the box `[length]`, of the shape ``(3,)``; 0 along flat axes.

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
        """Names of the species; :attr:`species` has indices into it.

        Examples
        --------
        >>> carom.Scene(fluid).species_names
        ['sphere']
        """
        return [name for name, _, _ in self._core.species_table()]

    @property
    def masses(self) -> NDArray[np.float64]:
        """Mass of each species `[mass]`, infinite where it is static.

        Examples
        --------
        >>> carom.Scene(fluid).masses
        array([1.])
        """
        return fixed(np.array([mass for _, mass, _ in self._core.species_table()]))

    @property
    def diameters(self) -> NDArray[np.float64]:
        """Diameter of each species at the start `[length]`.

        Examples
        --------
        >>> carom.Scene(fluid).diameters
        array([1.])
        """
        return fixed(np.array([diameter for _, _, diameter in self._core.species_table()]))

    @property
    def species(self) -> NDArray[np.int64]:
        """Species of each particle, of the shape ``(n,)``.

        Examples
        --------
        >>> carom.Scene(fluid).species.shape
        (108,)
        """
        return self._core.species()

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions at the start `[length]`, of the shape ``(n, 3)``.

        Examples
        --------
        >>> carom.Scene(fluid).positions.shape
        (108, 3)
        """
        return self._core.positions()

    @property
    def velocities(self) -> NDArray[np.float64]:
        """Velocities at the start `[length / time]`, of the shape ``(n, 3)``.

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

    def __getstate__(self) -> tuple[str, Path, list[tuple[str, str]]]:
        text, name, pairs = self._core.source()
        return text, Path(os.path.abspath(name)), pairs

    def __setstate__(self, state: tuple[str, Path, list[tuple[str, str]]]) -> None:
        self._core = _carom.Scene(*state)
