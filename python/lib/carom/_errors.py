"""The exceptions of the package."""

from __future__ import annotations

import re
from pathlib import Path

__all__ = ["CaromError", "CaromWarning", "FolderError", "SceneError", "SimulationError", "SweepError", "in_python"]

# : The program's suggestions, and their Python counterparts.
_IN_PYTHON = (
    (r"`carom run --resume DIR --until-time T`", r"`carom.resume(DIR, until_time=T)`"),
    (r"`carom run --resume DIR`", r"`carom.resume(DIR)`"),
    (r"\bcarom run --resume (\S+) goes on", r'carom.resume("\1") goes on'),
    (r"`carom exchange DIR`", r"`carom.exchange` with its scene and DIR as out"),
    (r"`carom exchange --jobs`", r"`jobs=` of `carom.exchange`"),
    (r"`carom run`", r"`carom.run`"),
    (r"a later end with --until-time", r'a later end with set={"run.until_time": T}'),
    (r"--vary seed=1\.\.3", r'vary={"seed": "1..3"}'),
    (r"change together are separated by `;`", r"change together are a tuple"),
)

# : An option of the program; commands for the prompt keep theirs.
_OPTION = re.compile(r"`carom [^`]*`|(?<![\w-])--(out|force|jobs|until-time|until-events|from-events|events|size|frames|fps)\b")

# : Largest number of characters in a line of a message: an array in the wrong place has millions of them.
_MOST = 240


def _argument(option: re.Match[str]) -> str:
    """An option as the argument of a function."""
    name = option[1]
    if name is None:
        return option[0]
    return "force=True" if name == "force" else f"{name.replace('-', '_')}="


def in_python(text: str) -> str:
    """A message of the program with the arguments of Python in place of options, and with lines of a length that can be read."""
    for of_program, of_python in _IN_PYTHON:
        text = re.sub(of_program.replace(" ", r"\s+"), of_python, text)
    return _shortened(_OPTION.sub(_argument, text))


def _shortened(text: str, most: int = _MOST) -> str:
    """The text, of each line so many characters at most."""
    return "\n".join(line if len(line) <= most else f"{line[: most - 4]} ..." for line in text.split("\n"))


class CaromError(Exception):
    """Base class of the exceptions of Carom.

    Wrong arguments, such as an array of another shape, raise the ``TypeError`` or ``ValueError`` of Python instead.

    Attributes
    ----------
    cure : str or None
        What to do about it; it is also the last line of the message.

    Examples
    --------
    >>> try:
    ...     carom.Scene({**fluid, "sead": 3})
    ... except carom.CaromError as error:
    ...     print(type(error).__name__)
    SceneError
    """

    def __init__(self, message: str, *, cure: str | None = None) -> None:
        super().__init__(in_python(message))
        self.cure = None if cure is None else in_python(cure)

    def __reduce__(self) -> tuple[object, ...]:
        # Exceptions may move between processes, with their attributes.
        return (_again, (type(self), self.args, self.__dict__))


def _again(kind: type[CaromError], arguments: tuple[object, ...], attributes: dict[str, object]) -> CaromError:
    error = kind.__new__(kind, *arguments)
    error.args = arguments
    error.__dict__.update(attributes)
    return error


class SceneError(CaromError, ValueError):
    """A scene is wrong. The message is that of the program, with the line and a mark under the value.

    Attributes
    ----------
    problem : str or None
        What is wrong, in one line.
    key : str or None
        Where it stands: ``species[0].mass``; ``None`` where no single one is to blame.
    missing : str or None
        Key that is not there and has to be: ``run.until_time``; ``None`` where nothing is missing.
    line : int or None
        The line of the scene's text, from 1.
    cure : str or None
        What to do about it.

    Examples
    --------
    >>> try:
    ...     carom.Scene(fluid, set={"species.0.mass": -1.0})
    ... except carom.SceneError as error:
    ...     print(error.key)
    species[0].mass
    """

    def __init__(
        self,
        message: str,
        *,
        problem: str | None = None,
        key: str | None = None,
        missing: str | None = None,
        line: str | None = None,
        cure: str | None = None,
    ) -> None:
        super().__init__(message, cure=cure)
        self.problem = None if problem is None else in_python(problem)
        self.key, self.missing = key, missing
        self.line = None if line is None else int(line)


class SimulationError(CaromError, RuntimeError):
    """A simulation cannot go on, or a run has failed its own audit.

    Attributes
    ----------
    folder : pathlib.Path or None
        The folder of the run, which :func:`carom.open` opens: its files are complete up to there. Of a run that was to replace another one it is
        ``replacement`` in the folder of that one, which stays as it was.
    cure : str or None
        What to do about it.

    Examples
    --------
    Where every particle loses energy and nothing supplies any, the dynamics may come to rest in infinitely many events:

    >>> issubclass(carom.SimulationError, carom.CaromError)
    True
    """

    def __init__(self, message: str, *, cure: str | None = None, folder: Path | None = None) -> None:
        super().__init__(message, cure=cure)
        self.folder = folder


class FolderError(CaromError, OSError):
    """A folder cannot be written or read: it holds something else, another process writes there, or the disk is full.

    Attributes
    ----------
    cure : str or None
        What to do about it.

    Examples
    --------
    >>> try:
    ...     carom.open("no/such/run")
    ... except carom.FolderError as error:
    ...     print(error.cure)
    give the folder of a run, a sweep or an exchange
    """

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class SweepError(CaromError, ValueError):
    """A sweep is wrong: an axis, or a folder that holds another sweep.

    Attributes
    ----------
    cure : str or None
        What to do about it.

    Examples
    --------
    >>> try:
    ...     carom.sweep(fluid, {"seed": "3..1"}, out="never-made")
    ... except carom.SweepError as error:
    ...     print(error)
    the range `3..1` runs backwards, or its ends are the same: write the smaller end first
    """


class CaromWarning(UserWarning):
    """Something that is worth a look, and ends nothing: points of a sweep that have failed.

    Examples
    --------
    >>> issubclass(carom.CaromWarning, UserWarning)
    True
    """
