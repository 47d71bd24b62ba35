"""Small scenes that together use every feature of the formats."""

from pathlib import Path

# Two species with names that ASE recognises, in a periodic box away from the origin, with measured bond order.
MIXTURE = """
seed = 3
[space]
lower = [-3.0, 1.0, 20.0]
size = [7.0, 8.0, 9.0]
[[species]]
name = "Ar"
mass = 1.0
diameter = 1.0
[[species]]
name = "Kr"
mass = 2.5
diameter = 1.3
[[interaction]]
species = ["Ar", "Ar"]
potential = "hard-sphere"
[[interaction]]
species = ["Ar", "Kr"]
potential = "hard-sphere"
[[interaction]]
species = ["Kr", "Kr"]
potential = "hard-sphere"
[[fill]]
composition = { Ar = 0.6, Kr = 0.4 }
count = 100
arrangement = "random"
temperature = 1.0
[measure.bond_order]
[run]
until_events = 2000
"""

# Chains in a small periodic box. Some bonds cross its sides.
POLYMER = """
[space]
size = [5.0, 5.0, 5.0]
[[species]]
name = "bead"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["bead", "bead"]
potential = "square-well"
lambda = 1.5
well_depth = 0.5
[[interaction]]
name = "link"
potential = "bond"
shortest = 0.9
longest = 1.1
[[chain]]
species = "bead"
length = 12
count = 3
bond = "link"
temperature = 1.0
[run]
until_events = 3000
"""

DISCS = """
[space]
size = [12.0, 10.0, 0.0]
lower = [0.0, -5.0, 0.0]
y = "walls"
z = "flat"
[[species]]
name = "disc"
mass = 1.0
diameter = 0.8
[[interaction]]
species = ["disc", "disc"]
potential = "hard-sphere"
[[fill]]
species = "disc"
arrangement = "square"
count = 60
temperature = 1.0
[run]
until_events = 1000
"""

# In a sheared box, periodic images along y move along x.
SHEARED = """
[space]
lower = [-3.0, 1.0, 20.0]
size = [7.0, 8.0, 6.5]
shear_rate = 0.4
[[species]]
name = "Ar"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["Ar", "Ar"]
potential = "square-well"
lambda = 1.5
well_depth = 0.5
[[fill]]
species = "Ar"
count = 120
arrangement = "random"
temperature = 1.0
[run]
until_events = 5000
"""

HOPPER = Path(__file__).parents[2] / "configs" / "hopper.toml"


def write(folder):
    """Writes each scene to a file. Returns its name, its file, and options that shorten the run."""
    texts = {"mixture": MIXTURE, "polymer": POLYMER, "discs": DISCS, "sheared": SHEARED}
    for name, text in texts.items():
        (folder / f"{name}.toml").write_text(text)
    scenes = [(name, folder / f"{name}.toml", []) for name in texts]
    return [*scenes, ("hopper", HOPPER, ["--until-time", "3"])]
