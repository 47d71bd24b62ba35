"""Conversion of frames to MDAnalysis; this module is imported only on demand."""

from __future__ import annotations

import warnings
from typing import Any

import MDAnalysis
import numpy as np
from MDAnalysis.coordinates.memory import MemoryReader
from numpy.typing import NDArray

from carom._errors import CaromWarning
from carom._frame import Frame

__all__ = ["FrameReader", "universe_of"]


class FrameReader(MemoryReader):  # type: ignore[misc]
    """Frames in memory, each with its own time. The reader of MDAnalysis assumes evenly spaced times."""

    def __init__(self, *arguments: Any, times: NDArray[np.float64], **keywords: Any) -> None:
        # The constructor of the base class reads the first frame and its time.
        self.times = times
        super().__init__(*arguments, **keywords)
        # MDAnalysis copies this reader with these arguments.
        self._kwargs["times"] = times

    def _read_next_timestep(self, ts: Any = None) -> Any:
        read = super()._read_next_timestep(ts)
        read.time = float(self.times[read.frame])
        return read


def universe_of(frames: list[Frame]) -> Any:
    """Creates an ``MDAnalysis.Universe`` with these frames."""
    first = frames[0]
    if any(len(frame) != len(first) or (frame.ids != first.ids).any() for frame in frames):
        raise ValueError("MDAnalysis needs the same particles in all frames")
    universe = MDAnalysis.Universe.empty(len(first), trajectory=False, velocities=True)
    names = np.array(first.species_names, dtype=object)[first.species]
    universe.add_TopologyAttr("types", names)
    universe.add_TopologyAttr("names", names)
    universe.add_TopologyAttr("masses", np.where(np.isfinite(first.masses), first.masses, 0.0))
    universe.add_TopologyAttr("radii", np.array(first.radii))
    universe.add_TopologyAttr("ids", np.array(first.ids))
    if len(first.bonds):
        place = {int(id): at for at, id in enumerate(first.ids)}
        universe.add_TopologyAttr("bonds", [(place[int(a)], place[int(b)]) for a, b in first.bonds])
    times = np.array([frame.time for frame in frames])
    universe.load_new(
        np.array([frame.positions for frame in frames]),
        format=FrameReader,
        velocities=np.array([frame.velocities for frame in frames]),
        dimensions=_boxes(frames),
        times=times,
        # The last interval may be shorter, so the median is used.
        dt=float(np.median(np.diff(times))) if len(times) > 1 else 1.0,
    )
    return universe


def _boxes(frames: list[Frame]) -> NDArray[np.float32] | None:
    """Box of each frame in the format of MDAnalysis, or ``None`` if no axis is periodic.

    A box in MDAnalysis is periodic along all axes.
    """
    first = frames[0]
    through = [axis for axis, periodic, size in zip("xyz", first.periodic, first.size) if not periodic and size > 0.0]
    if not first.periodic.any():
        return None
    if through:
        message = (
            f"MDAnalysis treats every box as periodic along all axes, but this one is not periodic along {' and '.join(through)}: "
            "distances with the box may cross these sides; use box=None for direct distances"
        )
        warnings.warn(message, CaromWarning, stacklevel=4)
    return np.array([_lengths_and_angles(frame.cell) for frame in frames], dtype=np.float32)


def _lengths_and_angles(cell: NDArray[np.float64]) -> list[float]:
    """Edge lengths of a box and its angles in degrees, in the order of MDAnalysis."""
    lengths = np.linalg.norm(cell, axis=1)
    cosines = [cell[a] @ cell[b] / (lengths[a] * lengths[b]) for a, b in ((1, 2), (0, 2), (0, 1))]
    return [*lengths.tolist(), *np.degrees(np.arccos(cosines)).tolist()]
