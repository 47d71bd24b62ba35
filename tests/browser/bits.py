"""Repeats runs in Chromium: bits.py RUNS. The file RUNS is written by `web/check.mjs PROGRAM EVENTS --runs RUNS SCENE...`.

Positions and velocities must have the same bits as in Node, and so the same bits as in the program.
"""

import base64
import json
import sys
from pathlib import Path

from devtools import Browser, find

ROOT = Path(__file__).parents[2]

# Runs a scene with the page's engine and returns a hash of the final state.
REPEAT = """(async ({ text, changes, files }) => {
  const engine = await Engine.of(window.compiled);
  for (const { name, content } of files) {
    engine.bring(name, Uint8Array.from(atob(content), (letter) => letter.charCodeAt(0)));
  }
  const begun = engine.start(text, changes);
  if (begun.error) {
    return begun.error;
  }
  engine.advance(Number.MAX_SAFE_INTEGER);
  const { positions, velocities } = engine.look();
  return hashOf(Float64Array.from([...positions, ...velocities]));
})(%s)"""


def scripts():
    live = ROOT / "src/view/live"
    texts = [(live / "unpack.js").read_text(), (live / "engine.js").read_text(), (Path(__file__).parent / "hash.js").read_text()]
    return "\n".join(texts) + "\nObject.assign(window, { Unpacker, Engine, hashOf }); undefined"


def main():
    runs = [json.loads(line) for line in Path(sys.argv[1]).read_text().splitlines()]
    packed = (ROOT / "web/carom.module").read_bytes().partition(b"\n")[2]
    browser = Browser(find())
    different = 0
    try:
        browser.open("about:blank")
        browser.evaluate(f"(() => {{ {scripts()} }})()")
        letters = json.dumps(base64.b64encode(packed).decode())
        browser.evaluate(
            f"(async () => {{ const packed = Uint8Array.from(atob({letters}), (letter) => letter.charCodeAt(0));"
            " window.compiled = await WebAssembly.compile(new Unpacker(packed).unpack()); })()")
        for run in runs:
            found = browser.evaluate(REPEAT % json.dumps(run), 600)
            different += found != run["hash"]
            print(f"{run['scene']}: {'the same bits' if found == run['hash'] else f'DIFFERENT: {found}'}")
    finally:
        browser.close()
    print(f"{len(runs)} scenes in Chromium, {different} different")
    return 1 if different or not runs else 0


sys.exit(main())
