"""Writes frames one by one in the formats of other programs."""

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
    """Writes a trajectory frame by frame, in the format of another program or in extended XYZ.

    Until the writer is closed, the file has a temporary name in the same folder, with ``.partial`` appended.
    Closing the writer completes the file and gives the file its final name. A ``with`` statement closes the
    writer at the end of the block, and removes the file if the block raises an exception. Scalars of frames
    are written if the format can store them.

    Parameters
    ----------
    path : path
        A file whose name ends in ``.gsd``, ``.xyz``, ``.extxyz``, ``.lammpstrj``, ``.lammps`` or ``.csv``, or
        a folder whose name ends in ``-vtk`` or ``-npy``.
    format : str, optional
        The format, regardless of the ending: ``"gsd"``, ``"xyz"``, ``"lammps"``, ``"csv"``, ``"vtk"`` or
        ``"npy"``. These are the formats of ``carom convert``.
    force : bool
        Whether to replace an existing file, or an existing folder that contains only files of the format.

    Raises
    ------
    FolderError
        If the path already exists, or cannot be written.
    ValueError
        If the name has a different ending and no format is given.

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
        #: Path of the file or folder.
        self.path = path_of("path", path)
        self._core = _carom.Writer(self.path, format, flag("force", force))

    def write(self, frame: Frame | Simulation) -> None:
        """Adds a frame, or the current state of a simulation.

        Parameters
        ----------
        frame : Frame or Simulation
            The frame, such as ``run.frames[7]``, or the simulation.

        Raises
        ------
        FolderError
            If the format cannot store the frame, or the frame cannot be written. The file is then removed.
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
        """Completes the file and gives the file its final name.

        Closing a closed writer has no effect.

        Raises
        ------
        FolderError
            If the file cannot be written, or another file of this name has been created in the meantime.
        ValueError
            If no frame was written. No file is created in this case.

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
