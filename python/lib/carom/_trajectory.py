"""Large output files of runs: frames and events, which are read on demand."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from carom import _carom
from carom._arguments import path_of
from carom._arrays import fixed
from carom._errors import FolderError
from carom._frame import Frame
from carom._simulation import EVENT_KINDS
from carom._tables import Columns

__all__ = ["EventLog", "Trajectory"]


class Trajectory(Sequence[Frame]):
    """The frames of a trajectory file, which are read on demand.

    The file is scanned once to find the position of each frame.

    Parameters
    ----------
    path : path
        A file in extended XYZ format, such as the ``trajectory.xyz`` of a run. An incomplete last frame, for
        example after the run was killed, is skipped.

    Raises
    ------
    FolderError
        If the file cannot be read or is not a trajectory.

    Examples
    --------
    >>> run = carom.run(fluid, set={"output.frame_interval": 0.1})
    >>> [round(frame.time, 1) for frame in run.frames[-3:]] == [round(t, 1) for t in run.frames.times[-3:]]
    True
    """

    def __init__(self, path: str | os.PathLike[str], *, _owner: Any = None) -> None:
        self._path = path_of("path", path)
        # Keeps a temporary folder alive.
        self._owner = _owner
        # Errors of the file are raised here, not at the first frame.
        self._core  # noqa: B018

    @cached_property
    def _core(self) -> _carom.Trajectory:
        return _carom.Trajectory(self._path)

    def __reduce__(self) -> Any:
        return _again, (Path(os.path.abspath(self._path)), self._owner)

    def __len__(self) -> int:
        return len(self._core)

    @overload
    def __getitem__(self, at: int) -> Frame: ...
    @overload
    def __getitem__(self, at: slice) -> list[Frame]: ...
    def __getitem__(self, at: int | slice) -> Frame | list[Frame]:
        if isinstance(at, slice):
            return [self[place] for place in range(*at.indices(len(self)))]
        place = operator.index(at)
        if not -len(self) <= place < len(self):
            raise IndexError(f"frame {place} does not exist: the trajectory has {len(self)} frames")
        return Frame._of(self._core.frame(place % len(self)))

    @cached_property
    def times(self) -> NDArray[np.float64]:
        """Simulated time of each frame `[time]`, an array of shape ``(frames,)``.

        The first access reads all frames once.

        Examples
        --------
        >>> carom.run(fluid).frames.times.shape
        (6,)
        """
        return fixed(np.array([frame.time for frame in self]))

    def positions(self, *, unwrapped: bool = True) -> NDArray[np.float64]:
        """Positions in all frames `[length]`, an array of shape ``(frames, n, 3)``.

        Each call returns a new, writable array.

        Parameters
        ----------
        unwrapped : bool
            If true, the positions continue beyond the sides of a periodic box, as is needed for
            displacements. Otherwise they are wrapped into the box.

        Raises
        ------
        ValueError
            If the frames do not all have the same particles, or if unwrapped positions are requested but the
            images are unknown.

        Examples
        --------
        The mean squared displacement between the first and the last frame:

        >>> r = carom.run(fluid).frames.positions()
        >>> float(((r[-1] - r[0]) ** 2).sum(axis=1).mean()) > 1.0
        True
        """
        return self._stacked("unwrapped" if unwrapped else "positions")

    def velocities(self) -> NDArray[np.float64]:
        """Velocities in all frames `[length / time]`, an array of shape ``(frames, n, 3)``.

        Each call returns a new, writable array.

        Raises
        ------
        ValueError
            If the frames do not all have the same particles.

        Examples
        --------
        >>> carom.run(fluid).frames.velocities().shape
        (6, 108, 3)
        """
        return self._stacked("velocities")

    def _stacked(self, name: str) -> NDArray[np.float64]:
        stacked: NDArray[np.float64] | None = None
        ids: NDArray[np.int64] | None = None
        for at, frame in enumerate(self):
            values = getattr(frame, name)
            if stacked is None or ids is None:
                stacked, ids = np.empty((len(self), *values.shape)), frame.ids
            if len(frame.ids) != len(ids) or (frame.ids != ids).any():
                raise ValueError(f"frame {at} does not have the same particles as the first frame: read the frames one by one")
            stacked[at] = values
        return np.empty((0, 0, 3)) if stacked is None else stacked

    def to_mdanalysis(self) -> Any:
        """Converts all frames to an ``MDAnalysis.Universe`` in memory; see :meth:`Frame.to_mdanalysis`.

        Each frame keeps its own time. ``trajectory.dt`` is the median interval between frames, because the
        last frame is at the end of the run and its interval may differ.

        Raises
        ------
        ImportError
            If MDAnalysis is not installed.
        ValueError
            If the frames do not all have the same particles, or if there are no frames.

        Examples
        --------
        >>> carom.run(fluid).frames.to_mdanalysis().trajectory.n_frames  # doctest: +MDANALYSIS
        6
        """
        if not len(self):
            raise ValueError(f"{self._path} has no frames")
        from carom._mdanalysis import universe_of

        return universe_of(list(self))

    def __iter__(self) -> Iterator[Frame]:
        return (self[at] for at in range(len(self)))

    def __repr__(self) -> str:
        return f"<Trajectory of {len(self)} frames>"


def _again(path: Path, owner: Any) -> Trajectory:
    """Restores a pickled trajectory. The file is scanned when it is first needed."""
    again = Trajectory.__new__(Trajectory)
    again._path, again._owner = path, owner
    return again


class EventLog(Columns):
    """All events of a run, stored by column.

    The columns are memory maps of the files in the folder ``events``, with one entry per event in order of
    time. They are the same as in :meth:`Simulation.events`, with the same units, except that ``impulse``,
    ``distance`` and ``normal`` are missing.

    Raises
    ------
    FolderError
        If a file cannot be read.

    Examples
    --------
    >>> run = carom.run(fluid, set={"output.events": True})
    >>> run.events["positions"].shape, carom.EVENT_KINDS[run.events["kind"][0]]
    ((20000, 2, 3), 'core')
    """

    COLUMNS = (
        "time",
        "kind",
        "particle",
        "partner",
        "positions",
        "velocities_before",
        "velocities_after",
        "energy_step",
        "dissipated",
    )
    #: Names of the kinds of events.
    KINDS = EVENT_KINDS

    def __init__(self, folder: Path, owner: Any = None) -> None:
        self._folder = folder
        # Keeps a temporary folder alive.
        self._owner = owner
        super().__init__({name: _column(folder / f"{name}.npy") for name in self.COLUMNS})

    def __reduce__(self) -> Any:
        return EventLog, (Path(os.path.abspath(self._folder)), self._owner)

    def __repr__(self) -> str:
        return f"<EventLog of {len(self['time'])} events: {', '.join(self.COLUMNS)}>"


def _column(path: Path) -> NDArray[Any]:
    try:
        column: NDArray[Any] = np.load(path, mmap_mode="r")
    except ValueError:
        # NumPy cannot map an empty array into memory.
        column = np.load(path)
    except OSError as error:
        raise FolderError(f"cannot read {path}: {error}") from error
    return column
