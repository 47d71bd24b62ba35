"""HTML output for notebooks: small tables, and pages embedded in cells.

The tables use the colours of the notebook, dark or light.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

import numpy as np

__all__ = ["framed", "number", "table", "unit"]

#: Number of table rows shown at the beginning and at the end.
_SHOWN = 5


def framed(page: str, height: int = 700) -> str:
    """HTML that embeds a page in a notebook cell."""
    style = f"width:100%;height:{height}px;border:0"
    return f'<iframe srcdoc="{escape(page)}" style="{style}" sandbox="allow-scripts"></iframe>'


def unit(text: str) -> str:
    """A unit with its exponents as superscripts; an empty string for a pure number."""
    return "" if text == "1" else re.sub(r"\^([-.\w]+)", r"<sup>\1</sup>", escape(text))


def number(value: Any) -> str:
    """Formats a float with six digits, NaN as an empty string, and other values as text."""
    if isinstance(value, (float, np.floating)):
        return "" if np.isnan(value) else f"{value:.6g}"
    return escape(" ".join(str(value).split()))


def table(caption: str, heads: Sequence[str], rows: Sequence[Iterable[str]]) -> str:
    """A table of cells that contain HTML. If there are many rows, only the first and last rows are shown."""
    cells = [list(row) for row in rows]
    if len(cells) > 2 * _SHOWN + 1:
        cells[_SHOWN:-_SHOWN] = [["&#8942;"] * len(heads)]
    lines = [f"<caption style='text-align:left;color:inherit;white-space:nowrap'>{caption}</caption>"]
    if any(heads):
        lines.append(_row("th", heads))
    lines += [_row("td", row) for row in cells]
    return f"<table style='color:inherit;background:none'>{''.join(lines)}</table>"


def _row(kind: str, cells: Iterable[str]) -> str:
    return "<tr>" + "".join(f"<{kind} style='text-align:left'>{cell}</{kind}>" for cell in cells) + "</tr>"
