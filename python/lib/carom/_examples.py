"""Example scenes that come with the package."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Any

from carom import _carom
from carom._scene import Scene

__all__ = ["example"]


def example(kind: str, *, seed: int | None = None, set: Mapping[str, Any] | None = None) -> Scene:
    """An example scene to start from, as printed by ``carom new``.

    :meth:`Scene.to_toml` returns its text.

    Parameters
    ----------
    kind : str
        ``"fluid"``, ``"well"``, ``"hopper"``, ``"polymer"``, ``"granular"`` and more. The error for an
        unknown kind lists all of them.
    seed, set
        As for :class:`Scene`.

    Raises
    ------
    ValueError
        If there is no example of this kind.
    SceneError
        If ``set`` makes the scene invalid.

    Examples
    --------
    >>> carom.example("hopper").name
    'hopper'
    >>> run = carom.run(carom.example("fluid"), until_events=10_000, set={"run.equilibration_events": 1000})
    """
    texts = _carom.examples()
    if kind not in texts:
        near = difflib.get_close_matches(str(kind), texts, 1)
        hint = f"did you mean {near[0]!r}? The examples are" if near else "the examples are"
        raise ValueError(f"kind: there is no example {kind!r}; {hint} {', '.join(sorted(texts))}")
    return Scene.from_toml(texts[kind], name=f"{kind}.toml", seed=seed, set=set)
