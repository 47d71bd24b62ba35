"""The folder of a run or an exchange, which may be temporary."""

from __future__ import annotations

import copy
import json
import os
import shutil
import tempfile
import weakref
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from carom._errors import FolderError

if TYPE_CHECKING:
    from typing_extensions import Self

__all__ = ["InFolder", "TemporaryFolder", "json_of"]


class TemporaryFolder:
    """A temporary folder that is deleted together with its owner.

    No warning is issued, so runs without ``out`` need not be closed.
    """

    def __init__(self) -> None:
        self.name = tempfile.mkdtemp(prefix="carom-")
        self._removal = weakref.finalize(self, shutil.rmtree, self.name, ignore_errors=True)

    def cleanup(self) -> None:
        """Removes the folder immediately."""
        self._removal()


class InFolder:
    """Content of a folder.

    The object is pickled as the absolute path of the folder. A temporary folder still belongs to the object
    that made it and to the copies of that object.
    """

    _temporary: TemporaryFolder | None

    def __getstate__(self) -> dict[str, Any]:
        read = {name for kind in type(self).__mro__ for name, it in vars(kind).items() if isinstance(it, cached_property)}
        state = {name: value for name, value in self.__dict__.items() if name not in read}
        absolute = {name: Path(os.path.abspath(value)) for name, value in state.items() if isinstance(value, Path)}
        return {**state, **absolute, "_temporary": None}

    def __copy__(self) -> Self:
        copied = type(self).__new__(type(self))
        copied.__dict__.update(self.__dict__)
        return copied

    def __deepcopy__(self, _memo: Any) -> Self:
        return copy.copy(self)


def json_of(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        cure = "continue a killed run with carom.resume"
        raise FolderError(f"cannot read {path}: {error}\n  help: {cure}", cure=cure) from error
    if not isinstance(content, dict):
        raise FolderError(f"{path} is not a file written by Carom")
    return content
