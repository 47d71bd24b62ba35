"""Tables and curves: the measurements of runs as arrays."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from carom._arguments import shown
from carom._arrays import fixed
from carom._errors import FolderError
from carom._html import number, table, unit

__all__ = ["Columns", "Curve", "Named", "Table"]

_Value = TypeVar("_Value")


class Named(dict[str, _Value]):
    """A dictionary that lists its keys in the error for a missing key."""

    def __init__(self, kind: str, items: Mapping[str, _Value]) -> None:
        super().__init__(items)
        self._kind = kind

    def __missing__(self, name: object) -> _Value:
        raise KeyError(f"no {self._kind} {shown(name)}; there are {', '.join(self) or 'none'}")


class _Absent:
    """A dictionary method that :class:`Columns` does not provide."""

    def __get__(self, instance: object, owner: type | None = None) -> Any:
        raise AttributeError("columns cannot be replaced: make a copy with dict(table)")


class Columns(dict[str, NDArray[Any]]):
    """Arrays by name that cannot be replaced.

    The class is a dictionary, because pandas and other libraries treat other mappings as a list of keys.
    """

    clear: Any = _Absent()
    pop: Any = _Absent()
    popitem: Any = _Absent()
    setdefault: Any = _Absent()
    update: Any = _Absent()

    def __missing__(self, name: object) -> NDArray[Any]:
        raise KeyError(f"no column {shown(name)}; there are {', '.join(self)}")

    def __setitem__(self, name: str, column: NDArray[Any]) -> None:
        raise TypeError(f"{name}: columns cannot be replaced: make a copy with dict(table)")

    def __delitem__(self, name: str) -> None:
        raise TypeError(f"{name}: columns cannot be removed: make a copy with dict(table)")

    def __ior__(self, columns: object) -> Any:  # type: ignore[misc]
        raise TypeError("columns cannot be replaced: make a copy with dict(table)")


class Table(Columns):
    """Columns by name: read-only arrays of the same length, with their units.

    Unknown values are NaN. A table is a dictionary, so ``pandas.DataFrame`` and other libraries accept it.

    Examples
    --------
    >>> thermo = carom.run(fluid).thermo
    >>> thermo["time"][0], thermo.units["time"]
    (np.float64(0.0), 'time')
    """

    def __init__(self, columns: Mapping[str, NDArray[Any]], units: Mapping[str, str] | None = None) -> None:
        super().__init__(columns)
        #: Unit of each column, if known.
        self.units = dict(units or {})

    @classmethod
    def read(cls, path: Path, units: Mapping[str, str] | None = None) -> Table:
        """Reads a table written by Carom, a CSV file with a header line.

        Raises
        ------
        FolderError
            If the file cannot be read, or the number of cells in a row differs from the number of headings.

        Examples
        --------
        >>> run = carom.run(fluid)
        >>> len(carom.Table.read(run.folder / "thermo.csv")) == len(run.thermo)
        True
        """
        try:
            with open(path, newline="", encoding="utf-8") as file:
                heads, *rows = list(csv.reader(file)) or [[]]
        except (OSError, UnicodeDecodeError) as error:
            raise FolderError(f"cannot read {path}: {error}") from error
        for line, row in enumerate(rows, 2):
            if len(row) != len(heads):
                raise FolderError(f"{path}: line {line} has {len(row)} cells, expected {len(heads)}: the file is damaged")
        cells = list(zip(*rows)) or [() for _ in heads]
        return cls({head: fixed(_column(values)) for head, values in zip(heads, cells)}, units)

    def to_pandas(self) -> Any:
        """The table as a ``pandas.DataFrame``.

        Raises
        ------
        ImportError
            If pandas is not installed.

        Examples
        --------
        >>> list(carom.run(fluid).thermo.to_pandas().columns)[:2]  # doctest: +PANDAS
        ['time', 'events']
        """
        from pandas import DataFrame

        return DataFrame(dict(self))

    def __reduce__(self) -> Any:
        return Table, (dict(self), self.units)

    def __repr__(self) -> str:
        rows = len(next(iter(self.values()), ()))
        return f"<Table of {rows} rows: {', '.join(self)}>"

    def _repr_html_(self) -> str:
        heads = [f"{escape(name)}<br><small>{unit(self.units.get(name, '1'))}</small>" for name in self]
        rows = [[number(cell) for cell in row] for row in zip(*self.values())]
        return table(f"{len(rows)} rows", heads, rows)


def _column(cells: tuple[str, ...]) -> NDArray[Any]:
    try:
        return np.array([int(cell) for cell in cells], dtype=np.int64)
    except (ValueError, OverflowError):
        pass
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells, dtype=object)


@dataclass(frozen=True, repr=False)
class Curve:
    """A measured function, such as a radial distribution function, with standard errors.

    Attributes
    ----------
    name, title, method : str
        Name and title of the curve, and the method of measurement.
    variables : dict of str to array
        The independent variables: a single variable, or the variables of a grid, all of the same length.
    values : dict of str to array
        The measured quantities; NaN where there is no value.
    errors : dict of str to array
        Standard errors of the quantities; NaN where there are too few data.
    units : dict of str to str
        Units of the variables and the quantities.
    published : list of dict
        Results of theory or of other simulations, if known.
    normalisation : dict of str to dict
        For each quantity, the original count or sum, and the numbers by which it was divided.

    Examples
    --------
    >>> run = carom.run(fluid, set={"measure.radial_distribution": True})
    >>> g = run.curves["radial_distribution"]
    >>> g.x.shape == g.y.shape == g.error.shape
    True
    """

    name: str
    title: str
    method: str
    variables: dict[str, NDArray[np.float64]]
    values: dict[str, NDArray[np.float64]]
    errors: dict[str, NDArray[np.float64]]
    units: dict[str, str]
    published: list[dict[str, Any]] = field(default_factory=list)
    normalisation: dict[str, dict[str, Any]] = field(default_factory=dict)

    @classmethod
    def _of(cls, json: Mapping[str, Any]) -> Curve:
        def numbers(values: list[float | None]) -> NDArray[np.float64]:
            return fixed(np.array([np.nan if it is None else it for it in values], dtype=float))

        variables, series = json["variables"], json["series"]
        return cls(
            name=json["name"],
            title=json["title"],
            method=json["method"],
            variables={it["name"]: numbers(it["values"]) for it in variables},
            values={it["name"]: numbers(it["values"]) for it in series},
            errors={it["name"]: numbers(it["standard_errors"]) for it in series},
            units={it["name"]: it["unit"] for it in [*variables, *series]},
            published=list(json.get("published", [])),
            normalisation={it["name"]: it["normalisation"] for it in series if it.get("normalisation")},
        )

    @property
    def x(self) -> NDArray[np.float64]:
        """The first variable.

        Examples
        --------
        >>> run = carom.run(fluid, set={"measure.radial_distribution": True})
        >>> bool(run.curves["radial_distribution"].x[0] > 0)
        True
        """
        return next(iter(self.variables.values()))

    @property
    def y(self) -> NDArray[np.float64]:
        """The first quantity.

        Examples
        --------
        >>> run = carom.run(fluid, set={"measure.radial_distribution": True})
        >>> float(run.curves["radial_distribution"].y[0])
        0.0
        """
        return next(iter(self.values.values()))

    @property
    def error(self) -> NDArray[np.float64]:
        """The standard error of the first quantity.

        Examples
        --------
        >>> run = carom.run(fluid, set={"measure.radial_distribution": True})
        >>> len(run.curves["radial_distribution"].error) > 10
        True
        """
        return next(iter(self.errors.values()))

    def to_pandas(self) -> Any:
        """The curve as a ``pandas.DataFrame``, with the errors in separate columns.

        Raises
        ------
        ImportError
            If pandas is not installed.

        Examples
        --------
        >>> run = carom.run(fluid, set={"measure.radial_distribution": True})
        >>> run.curves["radial_distribution"].to_pandas().shape[1]  # doctest: +PANDAS
        3
        """
        from pandas import DataFrame

        errors = {f"{name} error": values for name, values in self.errors.items()}
        return DataFrame({**self.variables, **self.values, **errors})

    def plot(self, ax: Any = None) -> Any:
        """Plots the quantities against the variable, with standard errors, units and published results.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            The axes to draw on; the current axes of pyplot if not given.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        ImportError
            If Matplotlib is not installed.
        ValueError
            If the curve is a grid of several variables.

        Examples
        --------
        >>> run = carom.run(fluid, set={"measure.radial_distribution": True})
        >>> run.curves["radial_distribution"].plot().get_xlabel()  # doctest: +MATPLOTLIB
        'r [length]'
        """
        if len(self.variables) != 1:
            raise ValueError(f"{self.name} is a grid of {', '.join(self.variables)}: plot .values, for example with imshow")
        try:
            import matplotlib.pyplot as pyplot
        except ImportError as error:
            raise ImportError("Curve.plot needs Matplotlib: pip install matplotlib") from error
        ax = pyplot.gca() if ax is None else ax
        for name, values in self.values.items():
            ax.errorbar(self.x, values, self.errors[name], fmt=".-", markersize=4.0, linewidth=1.0, elinewidth=0.8, label=name)
        for it in self.published:
            ax.plot(it["x"], it["y"], "--", label=it["label"])
        ax.set_xlabel(self._label(next(iter(self.variables))))
        units = {self.units[name] for name in self.values}
        if len(self.values) == 1:
            ax.set_ylabel(self._label(next(iter(self.values))))
        elif len(units) == 1 and units != {"1"}:
            ax.set_ylabel(f"[{units.pop()}]")
        ax.set_title(self.title)
        if len(self.values) + len(self.published) > 1:
            ax.legend()
        return ax

    def _label(self, name: str) -> str:
        return name if self.units[name] in ("1", name) else f"{name} [{self.units[name]}]"

    def __repr__(self) -> str:
        of = ", ".join(self.variables)
        return f"<Curve {', '.join(self.values)} of {of}: {len(self.x)} points>"
