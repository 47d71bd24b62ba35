"""An exchange and pymbar give equal curves from the same samples."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

import carom

pymbar = pytest.importorskip("pymbar")

#: A chain with many energy levels, and a falling particle with a continuous energy.
CHAIN = {
    "name": "chain",
    "space": {"size": [12.0, 12.0, 12.0]},
    "species": [{"name": "bead", "mass": 1.3, "diameter": 1.0}],
    "interaction": [
        {"species": ["bead", "bead"], "potential": "square-well", "lambda": 1.5, "well_depth": 0.9},
        {"name": "spring", "potential": "bond", "diameter": 1.0, "lambda": 1.2},
    ],
    "chain": [{"species": "bead", "bond": "spring", "length": 8}],
    "exchange": {"temperatures": [1.2, 0.8, 0.6, 0.45], "interval": 2.0, "rate": 0.8},
    "run": {"equilibration_time": 100.0, "until_time": 4000.0},
}
FALLING = {
    "name": "falling",
    "space": {"size": [5.0, 5.0, 5.0], "z": "walls"},
    "dynamics": {"gravity": [0.0, 0.0, -0.7]},
    "species": [{"name": "A", "mass": 1.3, "diameter": 1.0}],
    "interaction": [{"species": ["A", "A"], "potential": "none"}],
    "particle": [{"species": "A", "position": [1, 1, 1]}],
    "exchange": {"temperatures": [0.5, 1.0, 2.0], "interval": 3.0, "rate": 0.5},
    "run": {"until_time": 3000.0},
}


@pytest.mark.parametrize("scene", [CHAIN, FALLING], ids=["chain", "falling"])
def test_the_curves_are_those_of_pymbar(scene: dict, program: str, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(carom.Scene(scene).to_toml())
    command = [program, "exchange", tmp_path / "scene.toml", "--out", tmp_path / "out", "--quiet"]
    subprocess.run(command, check=True, capture_output=True)
    result = carom.Exchange(tmp_path / "out")
    curves, particles = result.curves, result.summary["particles"]
    between = curves["temperature"][::10]
    highest = curves["temperature"][-1]

    energies, temperatures = result.potential_energies, result.temperatures
    states = np.concatenate([temperatures, between])
    counts = [energies.shape[1]] * len(temperatures) + [0] * len(between)
    all_energies = energies.flatten()
    solver = ({"method": "adaptive", "options": {"min_sc_iter": 0}, "tol": 1e-13, "continuation": True},)
    mbar = pymbar.MBAR(all_energies[None] / states[:, None], counts, solver_protocol=solver)
    u, square = (mbar.compute_expectations(x)["mu"][len(temperatures) :] for x in (all_energies, all_energies**2))
    free = mbar.compute_free_energy_differences()["Delta_f"]
    free = free[list(states).index(highest), len(temperatures) :] / particles - 1.5 * np.log(between / highest)
    expected = {
        "potential_energy_per_particle": u / particles,
        "heat_capacity_per_particle": 1.5 + (square - u**2) / (particles * between**2),
        "reduced_free_energy_per_particle": free,
        "entropy_per_particle": u / particles / between - u[-1] / particles / highest - free,
    }
    for name, values in expected.items():
        difference = np.abs(curves[name][::10] - values).max()
        print(f"{scene['name']}, {name}: {difference:.1e}")
        assert difference < 1e-10, name
        errors = curves[f"{name}_error"]
        assert (errors[:-1] > 0.0).all()
    peak = json.loads((tmp_path / "out" / "summary.json").read_text())["heat_capacity_peak"]
    if peak is not None:
        assert peak["heat_capacity_per_particle"]["mean"] >= curves["heat_capacity_per_particle"].max() - 1e-12


def test_multicanonical_exchange_agrees_with_temperature_swaps() -> None:
    swapped = carom.exchange(CHAIN, progress=False)
    flat = {"exchange.ensemble": "multicanonical", "run.equilibration_time": 2000.0}
    walked = carom.exchange(CHAIN, set=flat, progress=False)
    assert walked.acceptance == [] and walked.summary["ensemble"] == "multicanonical"
    for name in ("potential_energy_per_particle", "heat_capacity_per_particle"):
        for one, other in zip(swapped.observable(name), walked.observable(name), strict=True):
            assert abs(one.mean - other.mean) < 4.0 * np.hypot(one.error, other.error), name
    levels, energies = walked.density_of_states, walked.potential_energies
    # Between the mean energies at the two end temperatures, the exchange visits all energy levels about equally often.
    visits = [np.isclose(energies, energy).mean() for energy in levels["energy"]]
    means = [8 * it.mean for it in walked.observable("potential_energy_per_particle")]
    inside = (levels["energy"] > min(means)) & (levels["energy"] < max(means))
    assert np.array(visits)[inside].min() > 0.3 * np.array(visits)[inside].max()
    even = walked.temperatures_for(0.5)
    assert even[0] == 0.45 and even[-1] == 1.2 and 2 <= len(even) <= 4
    for wrong in (0.0, 1.0, float("nan")):
        with pytest.raises(ValueError, match="acceptance: expected a number between 0 and 1"):
            walked.temperatures_for(wrong)
