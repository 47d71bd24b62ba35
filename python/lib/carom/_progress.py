"""Progress of a run: a tqdm progress bar, if tqdm is installed."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib.util import find_spec
from time import monotonic
from typing import Any

__all__ = ["Progress"]


class Progress:
    """A tqdm progress bar, if tqdm is installed and the bar is wanted.

    The bar is shown on a terminal and in notebooks with widgets. It is not shown if the output goes to a
    file, where each update would add a line.
    """

    #: Units of progress, for stages that do not count events.
    COUNTED = {"sweeping": "runs done", "exchanging": "attempts"}

    def __init__(self, wanted: bool, title: str) -> None:
        self._bar: Any = None
        self._stage = ""
        self._shown = 0.0
        kind = _kind_of_bar() if wanted else None
        if kind is not None:
            form = "{desc} {percentage:3.0f} %|{bar}|{postfix}, {remaining} left"
            self._bar = kind(total=1.0, desc=title, bar_format=form, leave=False, delay=0.5)

    @property
    def callback(self) -> Callable[[str, float, float, int], None] | None:
        """Callback for the compiled part, or ``None`` if no bar is shown."""
        return None if self._bar is None else self._see

    def is_due(self) -> bool:
        """Whether a bar is shown and its next update is due.

        The interval between two updates is the same as between two checks of the compiled part.
        """
        return self._bar is not None and monotonic() - self._shown > 0.05

    def show(self, stage: str, fraction: float, time: float, events: int) -> None:
        """Updates the bar with the progress that the caller reports."""
        self._shown = monotonic()
        self._see(stage, fraction, time, events)

    def _see(self, stage: str, fraction: float, time: float, events: int) -> None:
        bar = self._bar
        if stage != self._stage:
            self._stage = stage
            bar.reset(total=1.0)
        bar.n = min(fraction, 1.0)
        words = f"{stage}, {events} {self.COUNTED.get(stage, 'events')}"
        bar.set_postfix_str(words if not time else f"{words}, t = {time:.4g}", refresh=False)
        bar.refresh()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()


def _kind_of_bar() -> Any:
    is_notebook = "ipykernel" in sys.modules and find_spec("ipywidgets") is not None
    if find_spec("tqdm") is None or not (is_notebook or sys.stderr.isatty()):
        return None
    if is_notebook:
        from tqdm.notebook import tqdm
    else:
        from tqdm.std import tqdm
    return tqdm
