"""Event-driven particle dynamics: hard spheres, square wells, bonds, stepped potentials, gravity and granular flow.

The package uses reduced units: the scene defines the units of length, mass and energy, and Boltzmann's
constant is 1. ``[length]``, ``[mass]``, ``[energy]`` and ``[time]`` name the dimension of a quantity. A run
depends only on its scene and seed. Its results are always the same. The package and the program give the same
results bit for bit.

The examples of this package use ``carom``, ``np`` (NumPy) and this dictionary::

    fluid = {
        "name": "fluid",
        "seed": 1,
        "species": [{"name": "sphere", "mass": 1.0, "diameter": 1.0}],
        "interaction": [{"species": ["sphere", "sphere"], "potential": "hard-sphere"}],
        "fill": [
            {"species": "sphere", "arrangement": "fcc", "count": 108, "packing_fraction": 0.3, "temperature": 1.0}
        ],
        "run": {"until_events": 20_000},
    }

They also use ``pair``, the scene of the example of :func:`exchange`.

======================  ==========================================================
to                      use
======================  ==========================================================
describe a system       :class:`Scene`, from a file, TOML, a dictionary or arrays; :func:`example` to start
simulate step by step   :class:`Simulation`: advance, inspect, change, see every event
run and measure         :func:`run`, and :func:`resume` to continue
run many simulations    :func:`sweep`, with any executor; :func:`exchange`
read results            :func:`open`, for results of this package or of the program
average a series        :func:`mean_and_error`, with the same error estimate as runs
export                  :class:`Writer`, :meth:`Run.convert`, :meth:`Run.movie`
======================  ==========================================================
"""

from __future__ import annotations

import os

from carom._arguments import path_of
from carom._carom import __version__
from carom._errors import CaromError, CaromWarning, FolderError, SceneError, SimulationError, SweepError
from carom._examples import example
from carom._exchange import AtTemperature, Exchange, exchange
from carom._frame import Frame
from carom._observable import Observable
from carom._outputs import FileComparison, Proof
from carom._run import Run, Stage, resume, run
from carom._scene import Scene
from carom._simulation import EVENT, EVENT_KINDS, Simulation
from carom._statistics import mean_and_error
from carom._sweep import Sweep, sweep
from carom._tables import Curve, Table
from carom._trajectory import EventLog, Trajectory
from carom._writer import Writer

__all__ = [
    "EVENT",
    "EVENT_KINDS",
    "AtTemperature",
    "CaromError",
    "CaromWarning",
    "Curve",
    "EventLog",
    "Exchange",
    "FileComparison",
    "FolderError",
    "Frame",
    "Observable",
    "Proof",
    "Run",
    "Scene",
    "SceneError",
    "Simulation",
    "SimulationError",
    "Stage",
    "Sweep",
    "SweepError",
    "Table",
    "Trajectory",
    "Writer",
    "__version__",
    "example",
    "exchange",
    "mean_and_error",
    "open",
    "resume",
    "run",
    "sweep",
]


def __dir__() -> list[str]:
    return sorted(__all__)


def open(folder: str | os.PathLike[str]) -> Run | Sweep | Exchange:
    """Opens a folder with a run, a sweep or a replica exchange of this package or of the program.

    Parameters
    ----------
    folder : path
        The folder, such as ``runs/fluid``.

    Raises
    ------
    FolderError
        If the folder contains none of these, or if its run or exchange has not finished. :func:`resume`
        continues an unfinished run, and :func:`exchange` an unfinished exchange.

    Examples
    --------
    >>> run = carom.run(fluid, out="runs/fluid")
    >>> carom.open("runs/fluid").summary["seed"]
    1
    """
    path = path_of("folder", folder)
    if (path / "sweep.toml").is_file():
        return Sweep(path)
    is_exchange = (path / ".exchange").is_file()
    if is_exchange and (path / "summary.json").is_file():
        return Exchange(path)
    if (path / "summary.json").is_file():
        return Run(path)
    cure = "pass the folder of a run, a sweep or an exchange"
    why = f"{path} is not a folder written by Carom" if path.is_dir() else f"{path} is a file" if path.exists() else f"there is no folder {path}"
    if path.suffix == ".toml" and path.is_file():
        cure = "read a scene with carom.Scene, and run it with carom.run"
    if path.is_dir() and any((path / name).exists() for name in ("checkpoint", "thermo.csv.partial")):
        why, cure = f"the run in {path} is not finished", "continue it with carom.resume"
    if is_exchange:
        why, cure = f"the exchange in {path} is not finished", "continue it with carom.exchange: pass the same scene, and this folder as out"
    raise FolderError(f"{why}\n  help: {cure}", cure=cure)
