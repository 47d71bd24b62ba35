"""Outputs that are made of the files of a run: other formats, pictures, movies, pages and proofs."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Union

from carom import _carom
from carom._arguments import finite, flag, path_of, real, whole
from carom._errors import SimulationError
from carom._progress import Progress

__all__ = ["Outputs", "Proof"]

# : Frames of a trajectory: one frame, or the first and the last; either may be None.
FramesLike = Union[int, tuple[Union[int, None], Union[int, None]], None]

# : Direction of view: a side, or an azimuth and an elevation in degrees.
ViewLike = Union[str, tuple[float, float], None]

_SIDES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class FileComparison:
    """Comparison of the files of a run with those of a second simulation of it. :meth:`Run.verify` returns it as :attr:`Proof.files`.

    Attributes
    ----------
    equal : tuple of str
        Names of the files that are identical.
    changed : dict
        The first difference in each file that is not identical, by name. Always empty here: :meth:`Run.verify` raises an error if there is any.
    not_compared : dict
        Why a file was not compared, or only in part, by name.

    Examples
    --------
    >>> files = carom.run(fluid).verify(events=500).files
    >>> "trajectory.xyz" in files.equal, files.changed
    (True, {})
    """

    equal: tuple[str, ...]
    changed: dict[str, str]
    not_compared: dict[str, str]


@dataclass(frozen=True)
class Proof:
    """A proof that events of a run are right; :meth:`Run.verify` makes it.

    Attributes
    ----------
    is_proven : bool
        Whether all events that were asked for, or all up to the end of the run, are proven.
    first_event : int
        Number of the first one, from 1.
    events : int
        How many are proven.
    largest_gap : float
        Largest distance from the discontinuity at an event, relative to that of the discontinuity.
    text : str
        The table that ``carom verify`` prints.
    files : FileComparison or None
        The comparison of the files; None with ``files=False``.

    Examples
    --------
    >>> carom.run(fluid).verify(events=500)
    <Proof of 500 events, from event 1>
    """

    is_proven: bool
    first_event: int
    events: int
    largest_gap: float
    text: str
    files: FileComparison | None = None

    def __repr__(self) -> str:
        return f"<Proof of {self.events} events, from event {self.first_event}>"

    def __str__(self) -> str:
        return self.text


class Outputs:
    """Products of the files of a run."""

    def _open(self) -> Path:
        raise NotImplementedError

    def convert(
        self,
        to: Literal["lammps", "gsd", "vtk", "npy", "csv", "xyz"],
        out: str | os.PathLike[str] | None = None,
        *,
        frames: FramesLike = None,
        force: bool = False,
    ) -> Path:
        """Writes the trajectory in the format of another program, as ``carom convert`` does.

        While it is written, other threads of Python run; Ctrl-C leaves nothing of it.

        Parameters
        ----------
        to : str
            ``"lammps"``, a text dump; ``"gsd"``, that of HOOMD-blue; ``"vtk"``, a folder for ParaView; ``"npy"``, a folder of arrays; ``"csv"``, a
            table; ``"xyz"``, extended XYZ again.
        out : path, optional
            The file or folder to write; beside the trajectory, in the folder of the run, if not given.
        frames : int or (int or None, int or None), optional
            One frame, or the first and the last one, itself included; all if not given. They count from 0.
        force : bool
            Whether a file is replaced, or a folder with nothing but files of the format.

        Returns
        -------
        pathlib.Path
            What was written.

        Raises
        ------
        FolderError
            If there is something under that name, it cannot be written, or there is no such frame.
        ValueError
            If there is no such format.

        Examples
        --------
        >>> run = carom.run(fluid)
        >>> run.convert("gsd").name, run.convert("xyz", "two.xyz", frames=(0, 1)).name
        ('trajectory.gsd', 'two.xyz')
        >>> len(carom.Trajectory("two.xyz"))
        2
        """
        if not isinstance(to, str):
            raise TypeError(f"to: expected the name of a format, such as 'gsd', found {type(to).__name__}")
        return _carom.convert(self._open(), to, _named(out), _range(frames), flag("force", force))

    def render(
        self,
        out: str | os.PathLike[str] | None = None,
        *,
        time: float | None = None,
        colour: Literal["species", "speed"] = "species",
        size: tuple[int, int] | None = None,
        view: ViewLike = None,
        zoom: float = 1.0,
        no_box: bool = False,
        no_ground: bool = False,
        force: bool = False,
    ) -> Path:
        """Draws a frame as a PNG, as ``carom render`` does. While it is drawn, other threads of Python run.

        Parameters
        ----------
        out : path, optional
            The file to write; ``picture.png`` in the folder of the run if not given.
        time : float, optional
            Simulated time; the frame nearest to it is drawn, otherwise the last one `[time]`.
        colour : str
            Quantity that colours show: ``"species"`` or ``"speed"``.
        size : (int, int), optional
            Pixels across and down; without it as many as the scene takes of 1600 by 1200.
        view : str or (float, float), optional
            From where the scene is seen: ``"x"``, ``"y"``, ``"z"``, ``"-x"``, ``"-y"`` or ``"-z"``, or an azimuth and an elevation in degrees. Flat scenes
            are seen from the front.
        zoom : float
            Magnification about the middle, 0.01 to 100.
        no_box : bool
            Whether the edges of the box are left out.
        no_ground : bool
            Whether the ground is left out that catches shadows where there is gravity.
        force : bool
            Whether a file that is there is replaced.

        Returns
        -------
        pathlib.Path
            The file.

        Raises
        ------
        FolderError
            If there is such a file, it cannot be written, or the run has no frame that can be drawn.
        ValueError
            If an option has another value.

        Examples
        --------
        >>> carom.run(fluid).render("fluid.png", size=(160, 120), view=(30.0, 20.0)).name
        'fluid.png'
        """
        at = None if time is None else finite("time", time)
        seen = _seen(view, zoom, no_box, no_ground)
        pixels = None if size is None else _size(size)
        return _carom.render(self._open(), _named(out), at, _colour(colour), pixels, seen, flag("force", force))

    def movie(
        self,
        out: str | os.PathLike[str],
        *,
        frames: FramesLike = None,
        every: int = 1,
        fps: int = 25,
        colour: Literal["species", "speed"] = "species",
        size: tuple[int, int] = (1280, 960),
        turn: float = 30.0,
        view: ViewLike = None,
        zoom: float = 1.0,
        no_box: bool = False,
        no_ground: bool = False,
        follow: int | Literal["com"] | None = None,
        force: bool = False,
        progress: bool = True,
    ) -> Path:
        """Draws all frames as a movie, as ``carom movie`` does.

        While it is drawn, other threads of Python run; Ctrl-C leaves nothing of it.

        Parameters
        ----------
        out : path
            The file to write; its ending is the format: ``.mp4``, which needs the program ffmpeg, ``.gif`` or ``.apng``.
        frames
            As for :meth:`convert`.
        every : int
            Uses every frame of this number.
        fps : int
            Frames that are shown in a second, 1 to 120.
        colour, view, zoom, no_box, no_ground, force
            As for :meth:`render`.
        size : (int, int)
            Pixels across and down.
        turn : float
            How far the camera walks around the scene from the first frame to the last, in degrees; before flat scenes it stands still.
        follow : int or "com", optional
            Middle of the picture: the id of a particle, or the centre of mass of all that moves.
        progress : bool
            Whether a bar is shown, where tqdm is installed.

        Returns
        -------
        pathlib.Path
            The file.

        Raises
        ------
        FolderError
            If there is such a file, it cannot be written, there is no ffmpeg for an MP4, or an option has a value that no movie can have.
        ValueError
            If an option has another value.

        Examples
        --------
        >>> carom.run(fluid).movie("fluid.gif", frames=(0, 1), size=(64, 48)).name
        'fluid.gif'
        """
        path, pace = path_of("out", out), (whole("every", every, 1), whole("fps", fps, 1), finite("turn", turn))
        if pace[1] > 120:
            raise ValueError(f"fps: expected a whole number from 1 to 120, found {pace[1]}")
        seen, pixels, middle = _seen(view, zoom, no_box, no_ground), _size(size), _follow(follow)
        chosen, is_forced = _range(frames), flag("force", force)
        with Progress(flag("progress", progress), path.name) as bar:
            return _carom.movie(
                self._open(), path, chosen, pace, _colour(colour), pixels, seen, middle, is_forced, bar.callback
            )

    def verify(
        self, *, events: int = 100_000, from_events: int | None = None, files: bool = True, progress: bool = True
    ) -> Proof:
        """Proves events of the run, and compares its files with those of a replay, as ``carom verify`` does.

        It replays the events and holds each against the paper's Algorithm 1, asked over all pairs, walls and features of surfaces, without the engine's
        cells, predictions or memory. The cost of an event grows with the number of particles. Other threads of Python run meanwhile.

        Parameters
        ----------
        events : int
            How many physical events, or all up to the end of the run if there are fewer.
        from_events : int, optional
            Only replays this many events first; pair states at their end are then the engine's.
        files : bool
            Whether to simulate the run again and compare its files with the new ones. This takes as long as the run did.
        progress : bool
            Whether a bar is shown, where tqdm is installed.

        Raises
        ------
        SimulationError
            If an event is not proven, or a file is not what the run writes.
        FolderError
            If the run has no scene, or is none that can be proven.
        KeyboardInterrupt
            At Ctrl-C.

        Examples
        --------
        >>> proof = carom.run(fluid).verify(events=500)
        >>> proof.is_proven, proof.events
        (True, 500)
        >>> "thermo.csv" in proof.files.equal
        True
        """
        count = whole("events", events, 1)
        first = None if from_events is None else whole("from_events", from_events, 1)
        with Progress(flag("progress", progress), "proof") as bar:
            text, numbers, compared, failure = _carom.verify(
                self._open(), count, first, flag("files", files), bar.callback
            )
        if failure is not None:
            message, cure = failure
            raise SimulationError(f"{message}\n  help: {cure}" if cure else message, cure=cure, folder=self._open())
        if compared is None:
            return Proof(*numbers, text)
        equal, changed, left_out = compared
        return Proof(*numbers, text, FileComparison(tuple(equal), dict(changed), dict(left_out)))

    def write_page(self, out: str | os.PathLike[str] | None = None, *, force: bool = False) -> Path:
        """Writes the page about the run, as ``carom report`` does: results, audit, plots and the moving particles in one file for a browser.

        :meth:`page` has it as text; ``run.report`` is the final table.

        Parameters
        ----------
        out : path, optional
            The file to write; ``report.html`` in the folder of the run if not given.
        force : bool
            Whether another file that is there is replaced.

        Returns
        -------
        pathlib.Path
            The file.

        Raises
        ------
        FolderError
            If there is such a file, it cannot be written, or a file of the run is damaged.

        Examples
        --------
        >>> carom.run(fluid).write_page("fluid.html").name
        'fluid.html'
        """
        return _carom.write_page(self._open(), _named(out), flag("force", force))


def _named(out: Any) -> Path | None:
    return None if out is None else path_of("out", out)


def _range(frames: Any) -> tuple[int, int | None]:
    """First and last frame, as the compiled part takes them."""
    if frames is None:
        return 0, None
    if not isinstance(frames, (tuple, list)):
        only = whole("frames", frames)
        return only, only
    if len(frames) != 2:
        raise ValueError(f"frames: expected one frame or the first and the last one, found {len(frames)} of them")
    first = 0 if frames[0] is None else whole("frames", frames[0])
    last = None if frames[1] is None else whole("frames", frames[1])
    if last is not None and last < first:
        raise ValueError(f"frames: expected a first one that is not behind the last one, found {first} and {last}")
    return first, last


def _size(size: Any) -> tuple[int, int]:
    if not isinstance(size, (tuple, list)) or len(size) != 2:
        raise ValueError(f"size: expected pixels across and down, such as (1600, 1200), found {size!r}")
    width, height = (whole("size", it, 1) for it in size)
    if max(width, height) >= 2**32:
        raise ValueError(f"size: expected numbers of pixels, found {width} and {height}")
    return width, height


def _colour(colour: Any) -> str:
    if colour not in ("species", "speed"):
        raise ValueError(f"colour: expected 'species' or 'speed', found {colour!r}")
    return str(colour)


def _follow(follow: Any) -> int | None:
    """The id of a particle; -1 for the centre of mass."""
    if isinstance(follow, str) and follow == "com":
        return -1
    if follow is None:
        return None
    if isinstance(follow, str):
        raise ValueError(f"follow: expected 'com' or the id of a particle, found {follow!r}")
    return whole("follow", follow)


_Seen = tuple[Union[tuple[float, float, float], None], Union[tuple[float, float], None], float, bool, bool]


def _seen(view: Any, zoom: Any, no_box: Any, no_ground: Any) -> _Seen:
    """Camera of a picture, as the compiled part takes it."""
    side, angles = None, None
    factor = real("zoom", zoom)
    if not 0.01 <= factor <= 100.0:
        raise ValueError(f"zoom: expected a factor from 0.01 to 100, found {factor}")
    if isinstance(view, str):
        sign, axis = (-1.0, view[1:]) if view.startswith("-") else (1.0, view)
        if axis not in _SIDES:
            raise ValueError(f"view: expected 'x', 'y', 'z', '-x', '-y' or '-z', or azimuth and elevation in degrees, found {view!r}")
        x, y, z = _SIDES[axis]
        side = (sign * x, sign * y, sign * z)
    elif view is not None:
        if not isinstance(view, (tuple, list)) or len(view) != 2:
            raise ValueError(f"view: expected a side such as 'x', or azimuth and elevation in degrees, found {view!r}")
        azimuth, elevation = (finite("view", it) for it in view)
        if abs(azimuth) > 3600.0 or abs(elevation) > 90.0:
            raise ValueError(f"view: expected an elevation from -90 to 90 degrees, found {azimuth} and {elevation}")
        angles = (azimuth, elevation)
    return side, angles, factor, not flag("no_box", no_box), not flag("no_ground", no_ground)
