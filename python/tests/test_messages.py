"""Messages use the terms of Python: arguments instead of options, existing keys, and a limited length."""

from __future__ import annotations

import pickle
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import carom
from carom._errors import in_python
from conftest import FALLING, ROOT

#: Source files with suggestions in their error messages.
SOURCES = ["io/error.rs", "sweep/error.rs", "exchange/error.rs", "run/checkpoint/error.rs", "io/scenes.rs"]


def test_cures_name_arguments_of_python(fluid: dict, tmp_path: Path) -> None:
    carom.run(fluid, tmp_path / "run")
    with pytest.raises(carom.FolderError) as caught:
        carom.run(fluid, tmp_path / "run")
    cure = "choose another folder with out=, or replace it with force=True; `carom.resume(DIR, until_time=T)` makes it longer"
    assert caught.value.cure == cure and str(caught.value).endswith(f"help: {cure}")
    with pytest.raises(carom.FolderError, match="set until_time= or until_events= beyond"):
        carom.resume(tmp_path / "run", until_events=10)
    with pytest.raises(carom.SweepError, match=re.escape('give an axis, such as vary={"seed": "1..3"}')):
        carom.sweep(fluid, out=tmp_path / "sweep")


def test_no_cure_of_the_library_speaks_of_options() -> None:
    if not (ROOT / "src").is_dir():
        pytest.skip("the library is not beside the package")
    # A backslash continues a string on the next line.
    sources = [re.sub(r"\\\n\s*", "", (ROOT / "src" / name).read_text()) for name in SOURCES]
    cures = [text for source in sources for text in re.findall(r'"((?:[^"\\]|\\.)*)"', source)]
    spoken = [in_python(text) for text in cures if "--" in text or "`carom " in text]
    assert len(spoken) > 25
    for text in spoken:
        assert "--" not in text.replace("`carom run --force --resume DIR`", ""), text
        assert not re.search("`carom (run|exchange|sweep) (?!--force --resume)", text), text
    for text in ("`carom convert DIR/trajectory-1.xyz --to vtk` does it", "a --outer b", "so--out"):
        assert in_python(text) == text
    assert in_python("`carom run` at one") == "`carom.run` at one"


def test_failed_replacement_has_its_folder_and_keeps_the_old_run(fluid: dict, tmp_path: Path) -> None:
    carom.run(fluid, tmp_path / "run")
    with pytest.raises(carom.SimulationError) as caught:
        carom.run(FALLING, tmp_path / "run", force=True)
    folder = caught.value.folder
    assert folder is not None and carom.open(folder).summary["ending"] == "arrested"
    assert carom.open(tmp_path / "run").summary["scene"] == "fluid"
    assert carom.run(fluid, tmp_path / "run", seed=4, force=True).folder == tmp_path / "run"
    assert carom.open(tmp_path / "run").summary["seed"] == 4


def test_missing_key_lists_the_available_ones(fluid: dict) -> None:
    run, simulation = carom.run(fluid), carom.Simulation(fluid)
    asked: list[tuple[Any, str]] = [
        (run.observables, "no observable 'x'; there are collision_rate, compressibility_factor, pressure, temperature"),
        (run.curves, "no curve 'x'; there are none"),
        (run.summary, "no entry 'x'; there are version, scene"),
        (simulation.energy, "no energy 'x'; there are kinetic, rotational, thermal"),
        (simulation.event_counts, "no kind 'x'; there are core, capture"),
        (run.thermo, "no column 'x'; there are time, events"),
    ]
    for names, words in asked:
        with pytest.raises(KeyError, match=words):
            names["x"]
        assert names.get("x") is None and "x" not in names
    again = pickle.loads(pickle.dumps(run.observables))
    assert again == run.observables
    with pytest.raises(KeyError, match="no observable 'x'"):
        again["x"]


@pytest.mark.parametrize(
    ("set", "key"),
    [
        ({"sead": 3}, "sead"),
        ({"species.0.colour": 1}, "species[0].colour"),
        ({"run.until_evnets": 4}, "run.until_evnets"),
        ({"fill.0.count": 1.5}, "fill[0].count"),
        ({"species.0.mass": "heavy"}, "species[0].mass"),
        ({"species.0.mass": -1.0}, "species[0].mass"),
    ],
)
def test_the_key_of_a_mistake_is_named(fluid: dict, set: dict, key: str) -> None:
    with pytest.raises(carom.SceneError) as caught:
        carom.Scene(fluid, set=set)
    assert caught.value.key == key
    text = carom.Scene(fluid).to_toml()
    (path, value), (*steps, last) = *set.items(), *[key.replace("[0]", "").split(".")]
    header = {"species": "[[species]]", "fill": "[[fill]]", "run": "[run]"}[steps[0]] if steps else None
    lines = [line for line in text.splitlines() if not line.startswith(f"{last} =")]
    at = lines.index(header) + 1 if header else 0
    lines.insert(at, f"{last} = {value!r}")
    with pytest.raises(carom.SceneError) as caught:
        carom.Scene.from_toml("\n".join(lines))
    assert (caught.value.key, path.count(".")) == (key, key.count(".") + key.count("["))


def test_syntax_error_has_no_key() -> None:
    for text in ("", "seed = ", "[["):
        with pytest.raises(carom.SceneError) as caught:
            carom.Scene.from_toml(text)
        assert caught.value.key is None or text.startswith(caught.value.key)


def test_an_array_in_the_wrong_place_has_a_short_message(fluid: dict, tmp_path: Path) -> None:
    array = np.zeros((50_000, 3))
    numbers, simulation = array.tolist(), carom.Simulation(fluid)
    calls = [
        lambda: simulation.advance(numbers),
        lambda: simulation.advance(array),
        lambda: simulation.advance(events=numbers),
        lambda: simulation.advance(1.0, stop=numbers),
        lambda: simulation.advance(1.0, stop=bool, kinds=[numbers]),
        lambda: carom.run(fluid, until_time=numbers),
        lambda: carom.run(fluid, force=numbers),
        lambda: carom.run(fluid, threads=str(numbers)),
        lambda: carom.Scene(str(numbers)),
        lambda: carom.Scene(fluid, set={"species.0.mass": array}),
        lambda: carom.Scene({**fluid, "seed": numbers}),
        lambda: carom.sweep(fluid, {tuple(numbers[0]) * 50_000: [1]}, out=tmp_path / "sweep"),
    ]
    for at, call in enumerate(calls):
        with pytest.raises((TypeError, ValueError)) as caught:
            call()
        assert len(str(caught.value)) < 2_000 and len(repr(vars(caught.value))) < 2_000, at


def test_dir_lists_exactly_the_documented_names() -> None:
    assert dir(carom) == sorted(carom.__all__)
