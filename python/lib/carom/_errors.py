"""The exceptions of the package."""

from __future__ import annotations

import re
from pathlib import Path

__all__ = ["CaromError", "CaromWarning", "FolderError", "SceneError", "SimulationError", "SweepError", "in_python"]

#: Replaces commands of the program by Python calls.
_IN_PYTHON = (
    (r"`carom run --resume DIR --until-time T`", r"`carom.resume(DIR, until_time=T)`"),
    (r"`carom run --resume DIR`", r"`carom.resume(DIR)`"),
    (r"\bcarom run --resume (\S+) continues it", r'carom.resume("\1") continues it'),
    (r"`carom exchange DIR`", r"`carom.exchange` with its scene and DIR as out"),
    (r"`carom exchange --jobs`", r"`jobs=` of `carom.exchange`"),
    (r"`carom run`", r"`carom.run`"),
    (r"a later end with --until-time", r'a later end with set={"run.until_time": T}'),
    (r"--vary seed=1\.\.3", r'vary={"seed": "1..3"}'),
    (r"change together are separated by `;`", r"change together form a tuple"),
)

#: An option of the program. The pattern also matches whole commands in backticks, so that their options are not
#: replaced.
_OPTION = re.compile(r"`carom [^`]*`|(?<![\w-])--(out|force|jobs|until-time|until-events|from-events|events|size|frames|fps)\b")

#: Largest number of characters in a line of a message. A message with an array could have millions of characters.
_MOST = 240


def _argument(option: re.Match[str]) -> str:
    """A command-line option as a function argument."""
    name = option[1]
    if name is None:
        return option[0]
    return "force=True" if name == "force" else f"{name.replace('-', '_')}="


def in_python(text: str) -> str:
    """Adapts a message of the program: Python arguments instead of options, and lines of a readable length."""
    for of_program, of_python in _IN_PYTHON:
        text = re.sub(of_program.replace(" ", r"\s+"), of_python, text)
    return _shortened(_OPTION.sub(_argument, text))


def _shortened(text: str, most: int = _MOST) -> str:
    """Shortens each line of the text to at most ``most`` characters."""
    return "\n".join(line if len(line) <= most else f"{line[: most - 4]} ..." for line in text.split("\n"))


class CaromError(Exception):
    """Base class of the exceptions of Carom.

    Wrong arguments, such as an array of the wrong shape, raise the built-in ``TypeError`` or ``ValueError``
    instead.

    Attributes
    ----------
    cure : str or None
        How to fix the problem; also the last line of the message.

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
        # Pickles the attributes too.
        return (_again, (type(self), self.args, self.__dict__))


def _again(kind: type[CaromError], arguments: tuple[object, ...], attributes: dict[str, object]) -> CaromError:
    error = kind.__new__(kind, *arguments)
    error.args = arguments
    error.__dict__.update(attributes)
    return error


class SceneError(CaromError, ValueError):
    """A scene is invalid.

    The message is the message of the program. It shows the line, with a mark under the value.

    Attributes
    ----------
    problem : str or None
        What is wrong, in one line.
    key : str or None
        Key of the wrong value, such as ``species[0].mass``; ``None`` if no single key is to blame.
    missing : str or None
        Required key that is missing, such as ``run.until_time``; ``None`` if no key is missing.
    line : int or None
        Line number in the text of the scene, from 1.
    cure : str or None
        How to fix the problem.

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
    """A simulation cannot continue, or a run has failed its own audit.

    Attributes
    ----------
    folder : pathlib.Path or None
        Folder of the run, which :func:`carom.open` opens. Its files are complete up to the failure. If the
        run was meant to replace another run, this is the subfolder ``replacement`` of the folder of the other
        run, which stays unchanged.
    cure : str or None
        How to fix the problem.

    Examples
    --------
    If every particle loses energy and nothing supplies energy, the dynamics may come to rest only after
    infinitely many events:

    >>> issubclass(carom.SimulationError, carom.CaromError)
    True
    """

    def __init__(self, message: str, *, cure: str | None = None, folder: Path | None = None) -> None:
        super().__init__(message, cure=cure)
        self.folder = folder


class FolderError(CaromError, OSError):
    """A folder cannot be read or written.

    For example, the folder contains something else, another process writes to the folder, or the disk is
    full.

    Attributes
    ----------
    cure : str or None
        How to fix the problem.

    Examples
    --------
    >>> try:
    ...     carom.open("no/such/run")
    ... except carom.FolderError as error:
    ...     print(error.cure)
    pass the folder of a run, a sweep or an exchange
    """

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class SweepError(CaromError, ValueError):
    """A sweep is invalid: an axis is wrong, or the folder contains another sweep.

    Attributes
    ----------
    cure : str or None
        How to fix the problem.

    Examples
    --------
    >>> try:
    ...     carom.sweep(fluid, {"seed": "3..1"}, out="never-made")
    ... except carom.SweepError as error:
    ...     print(error)
    the range `3..1` runs backwards, or its ends are the same: write the smaller end first
    """


class CaromWarning(UserWarning):
    """A problem that deserves attention but stops nothing, such as failed points of a sweep.

    Examples
    --------
    >>> issubclass(carom.CaromWarning, UserWarning)
    True
    """
