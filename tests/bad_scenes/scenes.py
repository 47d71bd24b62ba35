"""Writes the scenes of cases.toml into a folder: python3 scenes.py FOLDER"""

import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).parent


def scene_of(case):
    if "scene" in case:
        return case["scene"]
    scene = (HERE / "base" / case["base"]).with_suffix(".toml").read_text(encoding="utf8")
    for old, new in case.get("replace", []):
        scene = scene.replace(old, new)
    for line, inserted in case.get("insert", []):
        lines = scene.splitlines()
        lines.insert(lines.index(line) + 1, inserted)
        scene = "\n".join(lines) + "\n"
    return scene + "\n" + case["add"] if "add" in case else scene


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    cases = tomllib.loads((HERE / "cases.toml").read_text(encoding="utf8"))
    for name, case in cases.items():
        (folder / f"{name}.toml").write_text(scene_of(case), encoding="utf8")


main()
