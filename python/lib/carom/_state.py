"""States of simulations: files and pickles from which they go on to the same bits."""

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
    """State of a simulation, as a whole."""

    __slots__ = ("_core", "_is_asking", "_scene")

    _core: _carom.Simulation
    # : Whether a call of a `stop` function is in progress.
    _is_asking: bool
    _scene: Scene

    @classmethod
    def _of(cls, core: _carom.Simulation, scene: Scene) -> Self:
        simulation = cls.__new__(cls)
        simulation._core, simulation._scene, simulation._is_asking = core, scene, False
        return simulation

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Saves the simulation in a file, from which :meth:`load` goes on to the same bits: all that decides what happens, and its scene.

        The file has its name when it is complete, and is as large as a checkpoint of a run. A simulation that was saved there before is replaced. Other files
        that the scene reads are not needed any more.

        Parameters
        ----------
        path : path
            Such as ``fluid.simulation``.
        force : bool
            Whether another file that is there is replaced, too.

        Raises
        ------
        FolderError
            If something else is there, or the file cannot be written.

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
        """Loads a simulation that :meth:`save` has saved.

        Parameters
        ----------
        path : path
            The file.
        threads : int or "auto", optional
            As for :func:`run`; those of the scene if not given.

        Raises
        ------
        FolderError
            If there is no such file, if a single bit of it has changed or its end is missing, if it is something else, or if another version of Carom has
            saved it, which may go on otherwise.

        Examples
        --------
        >>> carom.Simulation(fluid).save("fluid.simulation")
        >>> carom.Simulation.load("fluid.simulation").scene.name
        'fluid'
        """
        core, scene = _carom.Simulation.load(path_of("path", path), threads_of(threads))
        return cls._of(core, Scene._of(scene))

    def copy(self) -> Self:
        """A copy, which goes on to the same bits.

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
