"""Objects in notebooks are short, escaped HTML without colours of their own. Plots of curves include errors."""

from __future__ import annotations

import dataclasses
import re
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import carom
from carom._html import framed


class Balanced(HTMLParser):
    """Checks that all tags are closed in order."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text = ""
        self.feed(html)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: object) -> None:
        if tag == "br":
            return
        assert tag in ("table", "caption", "tr", "th", "td", "b", "small", "sup", "span")
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def text_of(thing: object) -> str:
    html = thing._repr_html_()  # type: ignore[attr-defined]
    assert len(html) < 8_000
    assert not re.findall(r"(?:color|background):(?!inherit|none)", html), "colours of the page only, which may be dark"
    return Balanced(html).text


def test_html_forms_are_short_and_well_formed(mixture: dict, tmp_path: Path) -> None:
    run = carom.run(mixture, tmp_path / "run")
    simulation = carom.Simulation(mixture)
    simulation.advance(events=100)
    assert "60" in text_of(run.scene) and "mixture" in text_of(run.scene)
    assert "100 events" in text_of(simulation) and "kinetic energy" in text_of(simulation)
    assert "9 × 8 × 12" in text_of(run.frames[0]) and "A" in text_of(run.frames[0])
    shown = text_of(run.thermo)
    rows = len(run.thermo["time"])
    assert rows > 20 and f"{rows} rows" in shown and "⋮" in shown and f"{run.thermo['kinetic'][-1]:.6g}" in shown
    assert text_of(carom.Observable(2.276, 0.015, "energy / length^3", False)) == "2.276 ± 0.015 energy / length3, not stationary"
    assert text_of(carom.Observable(1.0, 0.0, "1", True, True)) == "1 (conserved) "


def test_tables_of_any_size_are_shown() -> None:
    for count in (0, 1, 10, 11, 12, 1000):
        table = carom.Table({"x": np.arange(count), "y": np.arange(count) / 3})
        shown = table._repr_html_()
        Balanced(shown)
        assert shown.count("<tr>") == 1 + min(count, 11) and (count == 0 or f">{(count - 1) / 3:.6g}<" in shown)
    assert "0 rows" in text_of(carom.Table({}))


def test_names_of_users_are_escaped(fluid: dict) -> None:
    bad = "<script>alert(1)</script>"
    # Files of other programs contain names that scenes do not accept.
    frame = dataclasses.replace(carom.Simulation(fluid).frame(), species_names=[bad])
    for thing in (frame, carom.Observable(1.0, 0.1, bad), carom.Table({bad: np.array([bad], dtype=object)}, {bad: bad})):
        assert bad in text_of(thing)
    assert 'srcdoc="&lt;a b=&quot;c&quot;&gt;"' in framed('<a b="c">')


def test_a_curve_is_drawn_with_its_errors_and_units(fluid: dict) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    from matplotlib.figure import Figure

    curve = carom.run(fluid, set={"measure.radial_distribution": True}).curves["radial_distribution"]
    ax = Figure().subplots()
    assert curve.plot(ax) is ax and curve.plot(ax=ax) is ax
    line, _, (bars,) = ax.containers[0]
    assert np.array_equal(line.get_ydata(), curve.y, equal_nan=True)
    low, high = np.array([[ends[0][1], ends[1][1]] for ends in bars.get_segments() if len(ends) == 2]).T
    known = np.isfinite(curve.error)
    assert known.sum() > 10 and np.allclose(high - low, 2.0 * curve.error[known])
    assert ax.get_xlabel() == "r [length]" and ax.get_ylabel() and ax.get_title() == curve.title
    grid = carom.Curve("grid", "Grid", "", {"x": curve.x, "y": curve.x}, {"n": curve.y}, {"n": curve.error}, {"x": "1", "y": "1", "n": "1"})
    with pytest.raises(ValueError, match="a grid of x, y"):
        grid.plot()


def test_without_matplotlib_it_says_what_to_install(fluid: dict, monkeypatch: pytest.MonkeyPatch) -> None:
    x = np.arange(3.0)
    curve = carom.Curve("c", "C", "", {"t": x}, {"c": x}, {"c": x}, {"t": "time", "c": "1"})
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(ImportError, match="pip install matplotlib"):
        curve.plot()


def test_keys_are_completed_in_ipython(fluid: dict) -> None:
    pytest.importorskip("IPython")
    from IPython.core.completer import provisionalcompleter
    from IPython.core.interactiveshell import InteractiveShell

    shell = InteractiveShell()
    shell.user_ns["run"] = run = carom.run(fluid, set={"output.events": True})
    for text, keys in (('run.thermo["', run.thermo), ('run.observables["', run.observables), ('run.events["', run.events)):
        with provisionalcompleter():
            found = {it.text for it in shell.Completer.completions(text, len(text))}
        assert found == set(keys)
