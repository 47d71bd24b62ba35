"""The exceptions of the package."""

from __future__ import annotations

from pathlib import Path

__all__ = ["CaromError", "CaromWarning", "FolderError", "SceneError", "SimulationError", "SweepError"]


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
        super().__init__(message)
        self.cure = cure

    def __reduce__(self) -> tuple[object, ...]:
        # Exceptions travel between processes: attributes with them.
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
        line: str | None = None,
        cure: str | None = None,
    ) -> None:
        super().__init__(message, cure=cure)
        self.problem = problem
        self.key = key
        self.line = None if line is None else int(line)


class SimulationError(CaromError, RuntimeError):
    """A simulation cannot go on, or a run has failed its own audit.

    Attributes
    ----------
    folder : pathlib.Path or None
        The folder of the run, which :func:`carom.open` opens: its files are complete up to there.
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
