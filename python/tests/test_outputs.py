"""Files written from runs and simulations equal the files of the program, and errors are clear."""

from __future__ import annotations

import dataclasses
import subprocess
from pathlib import Path

import numpy as np
import pytest

import carom


@pytest.fixture
def run(fluid: dict) -> carom.Run:
    return carom.run({**fluid, "run": {"until_events": 3000}}, "run", set={"output.frame_interval": 0.1})


@pytest.mark.parametrize(("to", "name"), [("csv", "trajectory.csv"), ("lammps", "trajectory.lammpstrj"), ("gsd", "trajectory.gsd")])
def test_conversions_are_those_of_the_program(run: carom.Run, program: str, to: str, name: str) -> None:
    written = run.convert(to)  # type: ignore[arg-type]
    assert written == run.folder / name
    subprocess.run([program, "convert", "run", "--to", to, "--out", "other"], check=True)
    assert written.read_bytes() == Path("other").read_bytes()
    with pytest.raises(carom.FolderError, match="exists") as caught:
        run.convert(to)  # type: ignore[arg-type]
    assert "force=True" in str(caught.value) and "--" not in str(caught.value)
    run.convert(to, force=True)  # type: ignore[arg-type]


def test_some_frames_are_converted(run: carom.Run) -> None:
    assert len(carom.Trajectory(run.convert("xyz", "some.xyz", frames=(1, 2)))) == 2
    assert len(carom.Trajectory(run.convert("xyz", "one.xyz", frames=1))) == 1
    assert len(carom.Trajectory(run.convert("xyz", "rest.xyz", frames=(2, None)))) == len(run.frames) - 2
    with pytest.raises(ValueError, match="must not come after the last"):
        run.convert("xyz", "x.xyz", frames=(2, 1))
    with pytest.raises(carom.FolderError, match="does not exist"):
        run.convert("xyz", "x.xyz", frames=10_000)
    with pytest.raises(ValueError, match="there is no format"):
        run.convert("pdb")  # type: ignore[arg-type]
    with pytest.raises(carom.FolderError):
        run.convert("xyz", run.folder / "trajectory.xyz", force=True)
    assert not Path("x.xyz").exists() and len(carom.open("run").frames) == len(run.frames)  # type: ignore[union-attr]


def test_pictures_and_movies_are_those_of_the_program(run: carom.Run, program: str) -> None:
    run.render("one.png", size=(160, 120), view="-y", zoom=1.5, no_box=True, colour="speed", time=0.2)
    options = ["--size", "160x120", "--view", "-y", "--zoom", "1.5", "--no-box", "--colour", "speed", "--time", "0.2"]
    subprocess.run([program, "render", "run", "--out", "other.png", *options], check=True)
    assert Path("one.png").read_bytes() == Path("other.png").read_bytes()
    run.movie("one.gif", size=(64, 48), frames=(0, 2), turn=10.0, follow="com", progress=False)
    options = ["--size", "64x48", "--frames", "0..2", "--turn", "10", "--follow", "com", "--quiet"]
    subprocess.run([program, "movie", "run", "--out", "other.gif", *options], check=True)
    assert Path("one.gif").read_bytes() == Path("other.gif").read_bytes()
    assert run.render().name == "picture.png"
    for wrong in ({"view": "w"}, {"zoom": 0.0}, {"size": (10,)}, {"colour": "red"}, {"view": (0.0, 91.0)}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            run.render("never.png", **wrong)  # type: ignore[arg-type]
    with pytest.raises(carom.FolderError, match="name such as film.mp4"):
        run.movie("film.avi", progress=False)


def test_pages_are_written(run: carom.Run) -> None:
    assert run.write_page() == run.folder / "report.html"
    assert run.write_page("page.html").read_text() == run.page()


def test_verify_proves_events_like_the_program(run: carom.Run, program: str) -> None:
    proof = run.verify(events=400, from_events=100, progress=False)
    assert proof.is_proven and proof.events == 400 and proof.first_event == 101 and 0.0 <= proof.largest_gap < 1e-9
    command = [program, "verify", "run", "--events", "400", "--from-events", "100", "--quiet"]
    assert str(proof) == subprocess.run(command, check=True, capture_output=True, text=True).stdout
    with pytest.raises(carom.FolderError, match="the run has only 3000 events"):
        run.verify(from_events=5000, progress=False)
    path = run.folder / "scene.toml"
    path.write_text(path.read_text().replace("packing_fraction = 0.3", "packing_fraction = 0.31"))
    with pytest.raises(carom.SimulationError, match="does not reproduce the end of this run"):
        run.verify(progress=False)


@pytest.mark.parametrize("name", ["t.gsd", "t.csv", "t.lammpstrj", "t.lammps", "t-npy", "t-vtk", "t.xyz"])
def test_writers_write_what_convert_writes(run: carom.Run, name: str) -> None:
    with carom.Writer(name) as writer:
        for frame in run.frames:
            writer.write(frame)
        assert not Path(name).exists()
    assert repr(writer) == f"<Writer of {name}: closed>"
    kinds = {"t.gsd": "gsd", "t.csv": "csv", "t.lammpstrj": "lammps", "t.lammps": "lammps", "t-npy": "npy", "t-vtk": "vtk", "t.xyz": "xyz"}
    other = run.convert(kinds[name], "other")  # type: ignore[arg-type]
    files = sorted(path.name for path in other.iterdir()) if other.is_dir() else [""]
    assert files
    for file in files:
        assert (Path(name) / file).read_bytes() == (other / file).read_bytes(), file


def test_writers_refuse_and_clean_up(fluid: dict) -> None:
    simulation = carom.Simulation(fluid)
    with pytest.raises(ValueError, match="the ending of the name is no format's"):
        carom.Writer("t.pdb")
    with pytest.raises(ValueError, match="no frame was written"), carom.Writer("t.gsd"):
        pass
    with pytest.raises(RuntimeError, match="mine"), carom.Writer("t.gsd") as writer:
        writer.write(simulation)
        raise RuntimeError("mine")
    assert list(Path().iterdir()) == []
    with carom.Writer("t", format="csv") as writer:
        writer.write(simulation.frame())
    with pytest.raises(ValueError, match="is closed"):
        writer.write(simulation)
    writer.close()
    with pytest.raises(carom.FolderError, match="exists"):
        carom.Writer("t", format="csv")
    with pytest.raises(TypeError, match="expected a carom.Frame"):
        carom.Writer("u.csv").write(np.zeros((3, 3)))  # type: ignore[arg-type]
    smaller = carom.Simulation({**fluid, "fill": [{**fluid["fill"][0], "count": 32}]})
    with pytest.raises(carom.FolderError, match="the same particles"), carom.Writer("t-npy") as writer:
        writer.write(simulation)
        writer.write(smaller)
    assert not Path("t-npy").exists()


def test_writers_keep_scalars(fluid: dict) -> None:
    frame = carom.Simulation(fluid).frame()
    with carom.Writer("t.xyz") as writer:
        writer.write(dataclasses.replace(frame, scalars={"q6": np.arange(108.0)}))
    assert carom.Trajectory("t.xyz")[0].scalars["q6"].tolist() == list(range(108))
