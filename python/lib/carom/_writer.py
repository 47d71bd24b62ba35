"""Frames in the formats of other programs, written one after the other."""

from __future__ import annotations

import os
from types import TracebackType
from typing import Literal

from carom import _carom
from carom._arguments import flag, path_of
from carom._frame import Frame
from carom._particles import given_of_frame
from carom._simulation import Simulation

__all__ = ["Writer"]


class Writer:
    """A trajectory that is written frame by frame, in the format of another program or in extended XYZ.

    It has its name when it is closed, complete; until then it is beside it, with ``.partial`` behind the name. In a ``with`` statement it is closed at the
    end, and removed if that is an exception. Scalars of frames are written where the format has a place for them.

    Parameters
    ----------
    path : path
        A file that ends in ``.gsd``, ``.xyz``, ``.extxyz``, ``.lammpstrj``, ``.lammps`` or ``.csv``, or a folder whose name ends in ``-vtk`` or ``-npy``.
    format : str, optional
        The format, whatever the ending: ``"gsd"``, ``"xyz"``, ``"lammps"``, ``"csv"``, ``"vtk"`` or ``"npy"``. Those are what ``carom convert`` writes.
    force : bool
        Whether a file is replaced, or a folder with nothing but files of the format.

    Raises
    ------
    FolderError
        If there is something under that name, or it cannot be written.
    ValueError
        If the name has another ending, and no format is given.

    Examples
    --------
    >>> simulation = carom.Simulation(fluid)
    >>> with carom.Writer("t.xyz") as writer:
    ...     for _ in range(3):
    ...         _ = simulation.advance(0.5)
    ...         writer.write(simulation)
    >>> carom.Trajectory("t.xyz").times
    array([0.5, 1. , 1.5])
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        format: Literal["gsd", "xyz", "lammps", "csv", "vtk", "npy"] | None = None,
        force: bool = False,
    ) -> None:
        if format is not None and not isinstance(format, str):
            raise TypeError(f"format: expected the name of a format, such as 'gsd', found {type(format).__name__}")
        #: The file or folder.
        self.path = path_of("path", path)
        self._core = _carom.Writer(self.path, format, flag("force", force))

    def write(self, frame: Frame | Simulation) -> None:
        """Adds a frame, or the present state of a simulation.

        Parameters
        ----------
        frame : Frame or Simulation
            Such as ``run.frames[7]``.

        Raises
        ------
        FolderError
            If the format cannot hold it, or it cannot be written. The file is then removed.
        ValueError
            If the writer is closed.

        Examples
        --------
        >>> with carom.Writer("start.gsd") as writer:
        ...     writer.write(carom.Simulation(fluid))
        """
        state = frame.frame() if isinstance(frame, Simulation) else frame
        if not isinstance(state, Frame):
            raise TypeError(f"frame: expected a carom.Frame or a Simulation, found {type(frame).__name__}")
        self._core.write(given_of_frame(state, None))

    def close(self) -> None:
        """Gives the file its name. A writer that is closed already stays so.

        Raises
        ------
        FolderError
            If it cannot be written, or there is another one now.
        ValueError
            If no frame was written: there is no file then.

        Examples
        --------
        >>> writer = carom.Writer("start.csv")
        >>> writer.write(carom.Simulation(fluid).frame())
        >>> writer.close()
        """
        frames = self._core.frames()
        if frames == 0:
            self._core.abandon()
            raise ValueError(f"no frame was written to {self.path}")
        if frames is not None:
            self._core.finish()

    def __enter__(self) -> Writer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        else:
            self._core.abandon()

    def __repr__(self) -> str:
        frames = self._core.frames()
        return f"<Writer of {self.path}: {'closed' if frames is None else f'{frames} frames'}>"
