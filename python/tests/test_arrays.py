"""Arrays are read-only copies: writing to a part of one is an error, and differences of unsigned numbers do not wrap around."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import carom

BONDED = {
    "space": {"size": [8.0, 8.0, 8.0]},
    "species": [{"name": "A", "mass": 1.0, "diameter": 1.0}],
    "interaction": [
        {"species": ["A", "A"], "potential": "square-well", "lambda": 1.5, "well_depth": 1.0},
        {"name": "link", "potential": "bond", "shortest": 0.9, "longest": 1.1},
    ],
    "chain": [{"species": "A", "length": 8, "bond": "link", "count": 3, "temperature": 1.0}],
    "run": {"until_events": 500},
}


def arrays(scene: dict, folder: Path) -> Iterator[tuple[str, Any]]:
    """All array attributes of an object, by name."""
    simulation = carom.Simulation(scene)
    simulation.advance(events=100)
    run = carom.run(scene, folder / "run", set={"measure.radial_distribution": True, "output.events": True})
    swept = carom.sweep(scene, seeds=1, out=folder / "sweep")
    frames = {"frame": simulation.frame(), "frames": run.frames[-1]}
    names = ("positions", "velocities", "images", "species", "radii", "ids", "bonds", "lower", "size", "periodic", "masses", "cell", "unwrapped")
    for place, frame in frames.items():
        yield from ((f"{place} {name}", getattr(frame, name)) for name in (*names, "species_masses"))
    for name in ("positions", "velocities", "images", "species", "captured_pairs", "momentum"):
        yield f"simulation {name}", getattr(simulation, name)
    for name in ("positions", "velocities", "species", "bonds", "lower", "size", "periodic", "masses", "diameters"):
        yield f"scene {name}", getattr(simulation.scene, name)
    for place, table in (("thermo", run.thermo), ("sweep", swept.table), ("mean", swept.mean), ("events", run.events)):
        assert table is not None
        yield from ((f"{place} {name}", column) for name, column in table.items())
    curve = run.curves["radial_distribution"]
    yield from (("curve x", curve.x), ("curve y", curve.y), ("curve error", curve.error), ("times", run.frames.times))
    yield "batch", next(iter(simulation.events(events=5)))


def test_arrays_are_read_only_copies(mixture: dict, tmp_path: Path) -> None:
    found = dict(arrays(mixture, tmp_path))
    assert [name for name, array in found.items() if array.flags.writeable] == []
    assert len(found) > 60
    simulation = carom.Simulation(mixture)
    for array in (simulation.velocities, simulation.positions):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.flags.writeable = True
    velocities = simulation.velocities.copy()
    velocities[0] = [0.5, 0.25, 0.125]
    simulation.velocities = velocities
    assert (simulation.velocities == velocities).all()


def test_an_event_is_for_reading_only(fluid: dict) -> None:
    def stop(event: np.void) -> bool:
        with pytest.raises(ValueError, match="read-only"):
            event["velocities_after"][0] = 0.0
        with pytest.raises(ValueError, match="read-only"):
            event["time"] = 0.0
        return True

    assert carom.Simulation(fluid).advance(events=10, stop=stop) == "stop"


def test_no_number_is_unsigned(mixture: dict, tmp_path: Path) -> None:
    kinds = {name: array.dtype.kind for name, array in arrays(mixture, tmp_path) if array.dtype.names is None}
    # Leaves out the event log, because the types in its files may be unsigned.
    assert [name for name, kind in kinds.items() if kind == "u" and not name.startswith("events ")] == []
    simulation = carom.Simulation(BONDED)
    simulation.advance(events=200)
    for name in ("captured_pairs", "species"):
        assert (getattr(simulation, name) - 1).min() >= -1, name
    bonds = simulation.scene.bonds
    assert set((bonds[:, 0] - bonds[:, 1]).tolist()) == {-1}
    batch = next(iter(simulation.events(events=50)))
    assert (batch["particle"] - 1).min() >= -1
    assert carom.EVENT.isalignedstruct and carom.EVENT.itemsize == 232


def test_columns_cannot_be_replaced(fluid: dict, tmp_path: Path) -> None:
    table = carom.run(fluid, tmp_path / "run").thermo
    with pytest.raises(TypeError, match="kinetic: columns"):
        table["kinetic"] = 2.0 * table["kinetic"]  # type: ignore[index]
    with pytest.raises(TypeError):
        del table["kinetic"]  # type: ignore[attr-defined]
    with pytest.raises(TypeError):
        table |= {}  # type: ignore[operator]
    assert not any(hasattr(table, name) for name in ("pop", "update", "clear", "setdefault", "popitem"))
    again = pickle.loads(pickle.dumps(table))
    assert type(again) is carom.Table and again.units == table.units and list(again) == list(table)
    assert (again["kinetic"] == table["kinetic"]).all()


def test_pandas_has_the_columns(fluid: dict, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    run = carom.run(fluid, tmp_path / "run", set={"output.events": True})
    for frame in (pandas.DataFrame(run.thermo), run.thermo.to_pandas()):
        assert list(frame.columns) == list(run.thermo) and len(frame) == len(run.thermo["time"])
        assert (frame["kinetic"] == run.thermo["kinetic"]).all()
    # pandas does not accept vectors as columns, and must not make a table of the column names instead.
    with pytest.raises(ValueError, match="1-dimensional"):
        pandas.DataFrame(run.events)
    assert run.events is not None
    numbers = pandas.DataFrame({name: column for name, column in run.events.items() if column.ndim == 1})
    assert len(numbers) == 20_000 and (numbers["time"] == run.events["time"]).all()


def test_truncated_table_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("time,kinetic\n0,1.5\n1\n")
    with pytest.raises(carom.FolderError, match="line 3 has 1 cells"):
        carom.Table.read(tmp_path / "table.csv")
    with pytest.raises(carom.FolderError, match="cannot read"):
        carom.Table.read(tmp_path / "none.csv")


def test_rough_spheres_share_their_energy_with_spins(fluid: dict) -> None:
    rough = [{**fluid["interaction"][0], "tangential_restitution": 1.0}]
    simulation = carom.Simulation({**fluid, "interaction": rough})
    assert not simulation.spins.any()
    simulation.advance(events=2000)
    energy = simulation.energy
    # The moment of inertia of a sphere of mass 1 and diameter 1 is 0.1.
    assert energy["rotational"] == pytest.approx(0.05 * (simulation.spins**2).sum(), rel=1e-12)
    assert energy["rotational"] > 0.2 * energy["kinetic"]
