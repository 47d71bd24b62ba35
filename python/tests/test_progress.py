"""Progress bars."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import carom
from carom import _progress


class Bar:
    """A progress bar that records everything shown by tqdm."""

    shown: list[tuple[float, str]] = []
    closed = 0

    def __init__(self, **settings: Any) -> None:
        self.settings, self.n, self.text = settings, 0.0, ""
        assert settings["delay"] == 0.5 and settings["total"] == 1.0

    def reset(self, total: float) -> None:
        self.n = 0.0

    def set_postfix_str(self, text: str, refresh: bool) -> None:
        self.text = text

    def refresh(self) -> None:
        Bar.shown.append((self.n, self.text))

    def close(self) -> None:
        Bar.closed += 1


@pytest.fixture
def bars(monkeypatch: pytest.MonkeyPatch) -> type[Bar]:
    clock = itertools.count()
    monkeypatch.setattr(_progress, "_kind_of_bar", lambda: Bar)
    monkeypatch.setattr(_progress, "monotonic", lambda: float(next(clock)))
    Bar.shown, Bar.closed = [], 0
    return Bar


def until_seen(act: Callable[[int], None], times: int) -> None:
    """Repeats a task with increasing length until the compiled part has read its clock the given number of times."""
    for length in (1, 8, 64, 512, 4096):
        Bar.shown, Bar.closed = [], 0
        act(length)
        if len(Bar.shown) >= times:
            return


@pytest.mark.parametrize(
    "advance",
    [
        lambda it, length: it.advance(100.0 * length, progress=True),
        lambda it, length: it.advance(events=100_000 * length, progress=True),
        lambda it, length: it.advance(until=100.0 * length, events=10**12, progress=True),
        lambda it, length: it.advance(events=5_000, stop=lambda event: False, progress=True),
        lambda it, length: it.advance(5.0, stop=lambda event: False, progress=True),
    ],
)
def test_advance_shows_how_far_it_is(
    advance: Callable[[carom.Simulation, int], str], fluid: dict, bars: type[Bar]
) -> None:
    simulation, plain = carom.Simulation(fluid), carom.Simulation(fluid)

    def act(length: int) -> None:
        nonlocal simulation
        simulation = plain.copy()
        advance(simulation, length)

    until_seen(act, 2)
    parts = [part for part, _ in bars.shown]
    assert len(parts) > 1 and parts == sorted(parts) and 0.0 < parts[0] < parts[-1] <= 1.0
    assert all(text.startswith("advancing, ") and "events" in text and "t = " in text for _, text in bars.shown)
    assert bars.closed == 1
    plain.advance(until=simulation.time)
    assert np.allclose(plain.positions, simulation.positions, rtol=0, atol=1e-9)


def test_progress_bars_are_shown_only_as_requested(fluid: dict, bars: type[Bar]) -> None:
    simulation = carom.Simulation(fluid)
    simulation.advance(200.0)
    assert bars.closed == 0
    with pytest.raises(TypeError, match="progress"):
        simulation.advance(1.0, progress="yes")  # type: ignore[arg-type]

    def prepare(length: int) -> None:
        run = {"equilibration_events": 100_000 * length, "until_events": 1}
        carom.Simulation.prepared({**fluid, "run": run})

    until_seen(prepare, 1)
    assert bars.closed == 1 and all(text.startswith("equilibrating, ") for _, text in bars.shown) and bars.shown
    with pytest.raises(ZeroDivisionError):
        simulation.advance(1.0, stop=lambda event: 1 / 0, progress=True)
    assert bars.closed == 2
