"""Outputs made from the files of a run: other formats, pictures, movies, pages and proofs."""

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

#: One frame, the first and last frame of a range, or `None` for all frames. In a range, `None` means no limit.
FramesLike = Union[int, tuple[Union[int, None], Union[int, None]], None]

#: A side, or an azimuth and an elevation in degrees.
ViewLike = Union[str, tuple[float, float], None]

_SIDES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class FileComparison:
    """Comparison of the files of a run with the files of a second simulation of the same run.

    :meth:`Run.verify` returns the comparison as :attr:`Proof.files`.

    Attributes
    ----------
    equal : tuple of str
        Names of the identical files.
    changed : dict
        The first difference in each file that is not identical, by file name. The dictionary is always empty
        here, because :meth:`Run.verify` raises an error if any file differs.
    not_compared : dict
        The reason why a file was not compared or only partly compared, by file name.

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
    """A proof that events of a run are correct, returned by :meth:`Run.verify`.

    Attributes
    ----------
    is_proven : bool
        Whether all requested events, or all events up to the end of the run, are proven.
    first_event : int
        Number of the first verified event, counted from 1.
    events : int
        Number of proven events.
    largest_gap : float
        Largest distance from the discontinuity at an event, relative to the distance of the discontinuity.
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
    """Outputs made from the files of a run."""

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

        Other Python threads continue during the conversion. Ctrl-C leaves no partial output.

        Parameters
        ----------
        to : str
            The format: ``"lammps"``, a text dump; ``"gsd"``, the format of HOOMD-blue; ``"vtk"``, a folder
            for ParaView; ``"npy"``, a folder of arrays; ``"csv"``, a table; or ``"xyz"``, extended XYZ, the
            same format as the trajectory.
        out : path, optional
            The file or folder to write. By default, it is next to the trajectory, in the folder of the run.
        frames : int or (int or None, int or None), optional
            One frame, or the first and the last frame (inclusive), counted from 0. By default, all frames.
        force : bool
            Whether to replace an existing file, or a folder that contains only files of the format.

        Returns
        -------
        pathlib.Path
            The file or folder that was written.

        Raises
        ------
        FolderError
            If the output already exists or cannot be written, or if a frame does not exist.
        ValueError
            If the format is unknown.

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
        colour: Literal["species", "speed", "pressure"] = "species",
        size: tuple[int, int] | None = None,
        view: ViewLike = None,
        zoom: float = 1.0,
        no_box: bool = False,
        no_ground: bool = False,
        force: bool = False,
    ) -> Path:
        """Draws a frame as a PNG, as ``carom render`` does.

        Other Python threads continue during the drawing.

        Parameters
        ----------
        out : path, optional
            The file to write. By default, ``picture.png`` in the folder of the run.
        time : float, optional
            Simulated time. The frame nearest to this time is drawn; by default, the last frame `[time]`.
        colour : str
            Quantity that the colours show: ``"species"``, ``"speed"``, or ``"pressure"`` (the contact pressure, if
            the scene has ``particle_stress = true`` in ``[measure]``).
        size : (int, int), optional
            Width and height in pixels. By default, the part of 1600 by 1200 pixels that the scene fills.
        view : str or (float, float), optional
            Direction from which the scene is seen: ``"x"``, ``"y"``, ``"z"``, ``"-x"``, ``"-y"`` or ``"-z"``,
            or an azimuth and an elevation in degrees. Flat scenes are seen from the front.
        zoom : float
            Magnification about the centre of the picture, 0.01 to 100.
        no_box : bool
            Whether to omit the edges of the box.
        no_ground : bool
            Whether to omit the ground, which catches shadows in scenes with gravity.
        force : bool
            Whether to replace an existing file.

        Returns
        -------
        pathlib.Path
            The file.

        Raises
        ------
        FolderError
            If the file already exists or cannot be written, or if the run has no frame that can be drawn.
        ValueError
            If an option has an invalid value.

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
        colour: Literal["species", "speed", "pressure"] = "species",
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

        Other Python threads continue during the drawing. Ctrl-C leaves no partial output.

        Parameters
        ----------
        out : path
            The file to write. Its extension selects the format: ``.mp4``, which needs the program ffmpeg,
            ``.gif`` or ``.apng``.
        frames
            As for :meth:`convert`.
        every : int
            Draws only every n-th frame, where n is this number.
        fps : int
            Frames per second, 1 to 120.
        colour, view, zoom, no_box, no_ground, force
            As for :meth:`render`.
        size : (int, int)
            Width and height in pixels.
        turn : float
            Angle by which the camera turns around the scene between the first and the last frame, in degrees.
            The camera does not move in flat scenes.
        follow : int or "com", optional
            Centre of the picture: the id of a particle, or the centre of mass of all moving particles.
        progress : bool
            Whether to show a progress bar, if tqdm is installed.

        Returns
        -------
        pathlib.Path
            The file.

        Raises
        ------
        FolderError
            If the file already exists or cannot be written, if ffmpeg is missing for an MP4, or if a
            movie cannot be made with the value of an option.
        ValueError
            If an option has an invalid value.

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
        """Proves events of the run and compares its files with a replay, as ``carom verify`` does.

        The method replays the events and checks each event against the paper's Algorithm 1. The algorithm is
        applied to all pairs, walls and features of surfaces, without the cells, predictions or memory of the
        engine. The cost of an event grows with the number of particles. Other Python threads continue
        meanwhile.

        Parameters
        ----------
        events : int
            Number of physical events to prove. If the run has fewer events, all events up to its end are
            proven.
        from_events : int, optional
            Number of events to replay first without a proof. The pair states after these events are taken
            from the engine.
        files : bool
            Whether to simulate the run again and compare its files with the files of the second run. This
            takes as long as the run itself.
        progress : bool
            Whether to show a progress bar, if tqdm is installed.

        Raises
        ------
        SimulationError
            If an event is not proven, or a file differs from the file that the replay writes.
        FolderError
            If the run has no scene or is of a kind that cannot be proven.
        KeyboardInterrupt
            If Ctrl-C is pressed.

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
        """Writes the page about the run, as ``carom report`` does.

        The page is a single file for a browser, with the results, the audit, plots and an animation of the
        particles. :meth:`page` returns the page as text; ``run.report`` is the final table.

        Parameters
        ----------
        out : path, optional
            The file to write. By default, ``report.html`` in the folder of the run.
        force : bool
            Whether to replace an existing file with different content.

        Returns
        -------
        pathlib.Path
            The file.

        Raises
        ------
        FolderError
            If the file already exists or cannot be written, or if a file of the run is damaged.

        Examples
        --------
        >>> carom.run(fluid).write_page("fluid.html").name
        'fluid.html'
        """
        return _carom.write_page(self._open(), _named(out), flag("force", force))


def _named(out: Any) -> Path | None:
    return None if out is None else path_of("out", out)


def _range(frames: Any) -> tuple[int, int | None]:
    """Returns the first and the last frame in the form that the compiled part expects."""
    if frames is None:
        return 0, None
    if not isinstance(frames, (tuple, list)):
        only = whole("frames", frames)
        return only, only
    if len(frames) != 2:
        raise ValueError(f"frames: expected one number, or the numbers of the first and the last frame, found {len(frames)} numbers")
    first = 0 if frames[0] is None else whole("frames", frames[0])
    last = None if frames[1] is None else whole("frames", frames[1])
    if last is not None and last < first:
        raise ValueError(f"frames: the first frame must not come after the last frame, found {first} and {last}")
    return first, last


def _size(size: Any) -> tuple[int, int]:
    if not isinstance(size, (tuple, list)) or len(size) != 2:
        raise ValueError(f"size: expected a width and a height in pixels, such as (1600, 1200), found {size!r}")
    width, height = (whole("size", it, 1) for it in size)
    if max(width, height) >= 2**32:
        raise ValueError(f"size: expected a width and a height below 2^32 pixels, found {width} and {height}")
    return width, height


def _colour(colour: Any) -> str:
    if colour not in ("species", "speed", "pressure"):
        raise ValueError(f"colour: expected 'species', 'speed' or 'pressure', found {colour!r}")
    return str(colour)


def _follow(follow: Any) -> int | None:
    """Returns the id of a particle, or -1 for the centre of mass."""
    if isinstance(follow, str) and follow == "com":
        return -1
    if follow is None:
        return None
    if isinstance(follow, str):
        raise ValueError(f"follow: expected 'com' or the id of a particle, found {follow!r}")
    return whole("follow", follow)


_Seen = tuple[Union[tuple[float, float, float], None], Union[tuple[float, float], None], float, bool, bool]


def _seen(view: Any, zoom: Any, no_box: Any, no_ground: Any) -> _Seen:
    """Returns the camera of a picture in the form that the compiled part expects."""
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
            raise ValueError(f"view: expected an azimuth from -3600 to 3600 and an elevation from -90 to 90 degrees, found {azimuth} and {elevation}")
        angles = (azimuth, elevation)
    return side, angles, factor, not flag("no_box", no_box), not flag("no_ground", no_ground)
