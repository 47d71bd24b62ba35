"""States of simulations: files and pickles from which a simulation resumes bit for bit."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal

from carom import _carom
from carom._arguments import flag, path_of, threads_of
from carom._scene import Scene

if TYPE_CHECKING:
    from typing_extensions import Self

__all__ = ["State"]


class State:
    """The complete state of a simulation."""

    __slots__ = ("_core", "_is_asking", "_scene")

    _core: _carom.Simulation
    #: Whether a `stop` function is being called.
    _is_asking: bool
    _scene: Scene

    @classmethod
    def _of(cls, core: _carom.Simulation, scene: Scene) -> Self:
        simulation = cls.__new__(cls)
        simulation._core, simulation._scene, simulation._is_asking = core, scene, False
        return simulation

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Saves the simulation to a file.

        A simulation that :meth:`load` reads from this file continues with bit-for-bit identical results. The
        file contains the complete state of the simulation and its scene. Other files that the scene reads are
        then no longer needed.

        The file gets its name only when it is complete. It is as large as a checkpoint of a run. A simulation
        previously saved under the same path is replaced.

        Parameters
        ----------
        path : path
            The file to write, such as ``fluid.simulation``.
        force : bool
            Whether to replace an existing file even if it is not a saved simulation.

        Raises
        ------
        FolderError
            If something other than a saved simulation exists at the path, or if the file cannot be written.

        Examples
        --------
        >>> simulation = carom.Simulation(fluid)
        >>> simulation.advance(events=1000)
        'events'
        >>> simulation.save("fluid.simulation")
        >>> again = carom.Simulation.load("fluid.simulation")
        >>> simulation.advance(events=1000), again.advance(events=1000)
        ('events', 'events')
        >>> bool((again.positions == simulation.positions).all())
        True
        """
        self._core.save(self._scene._core, path_of("path", path), flag("force", force))

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, threads: int | Literal["auto"] | None = None) -> Self:
        """Loads a simulation from a file written by :meth:`save`.

        Parameters
        ----------
        path : path
            The file to read.
        threads : int or "auto", optional
            Number of threads, as for :func:`run`; by default, the number given in the scene.

        Raises
        ------
        FolderError
            If the file does not exist, is corrupted (even by a single bit) or truncated, or is not a saved
            simulation. Also if another version of Carom saved the file, because the simulation could then
            continue differently.

        Examples
        --------
        >>> carom.Simulation(fluid).save("fluid.simulation")
        >>> carom.Simulation.load("fluid.simulation").scene.name
        'fluid'
        """
        core, scene = _carom.Simulation.load(path_of("path", path), threads_of(threads))
        return cls._of(core, Scene._of(scene))

    def copy(self) -> Self:
        """Returns a copy of the simulation, which continues with bit-for-bit identical results.

        Examples
        --------
        >>> one = carom.Simulation(fluid)
        >>> two = one.copy()
        >>> one.advance(1.0), two.advance(1.0)
        ('time', 'time')
        >>> bool((one.positions == two.positions).all())
        True
        """
        return self._of(self._core.copy(), self._scene)

    def __copy__(self) -> Self:
        return self.copy()

    def __deepcopy__(self, _memo: Any) -> Self:
        return self.copy()

    def __reduce__(self) -> Any:
        return _again, (type(self), self._core.to_bytes(self._scene._core))


def _again(kind: type[State], content: bytes) -> State:
    core, scene = _carom.Simulation.from_bytes(content)
    return kind._of(core, Scene._of(scene))
