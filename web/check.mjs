// Compares the module with the program, bit for bit, and times both:
// node web/check.mjs PROGRAM EVENTS [--runs FILE] [--short] SCENE...
// Both run the plan of the scene, with EVENTS events in its last stage and few in its equilibration. With --short,
// each earlier stage also has at most EVENTS events. FILE receives the runs, for tests/browser/bits.py.

import { spawnSync } from "node:child_process";
import { appendFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { parseArgs } from "node:util";
import { classesOf, moduleOf } from "../tests/browser/scripts.mjs";

const { Engine, hashOf } = classesOf(["engine.js", "../../../tests/browser/hash.js"], "Engine, hashOf");
const { positionals, values: { runs, short: isShort } } = parseArgs({
  allowPositionals: true,
  options: { runs: { type: "string" }, short: { type: "boolean" } },
});
const [program, wanted, ...scenes] = positionals;
if (runs) {
  writeFileSync(runs, "");
}
const events = Number(wanted);
const module = await WebAssembly.compile(moduleOf());
const folder = mkdtempSync(join(tmpdir(), "carom-"));

/** Positions and velocities of the last frame of a trajectory, by id. */
function lastFrame(path) {
  const lines = readFileSync(path, "utf8").trimEnd().split("\n");
  let start = 0;
  for (let at = 0; at < lines.length; at += Number(lines[at]) + 2) {
    start = at;
  }
  const count = Number(lines[start]);
  const columns = lines[start + 1].match(/Properties=(\S+)/)[1].split(":");
  const places = {};
  for (let k = 0, place = 0; k < columns.length; k += 3) {
    places[columns[k]] = place;
    place += Number(columns[k + 2]);
  }
  const numbers = new Float64Array(6 * count);
  for (const line of lines.slice(start + 2, start + 2 + count)) {
    const cells = line.split(" ");
    const id = Number(cells[places.id]);
    for (let axis = 0; axis < 3; axis += 1) {
      numbers[3 * id + axis] = Number(cells[places.pos + axis]);
      numbers[3 * (count + id) + axis] = Number(cells[places.velo + axis]);
    }
  }
  return { time: Number(lines[start + 1].match(/ Time=(\S+)/)[1]), numbers };
}

/** Index at which two sequences of numbers first differ in a bit; -1 if they are equal. */
function difference(one, other) {
  const bits = (numbers) => new BigUint64Array(numbers.buffer, numbers.byteOffset, numbers.length);
  const [a, b] = [bits(one), bits(other)];
  return a.length === b.length ? a.findIndex((word, at) => word !== b[at]) : 0;
}

let [compared, failed] = [0, 0];
for (const scene of scenes) {
  const engine = await Engine.of(module);
  const text = readFileSync(scene, "utf8");
  const files = [...text.matchAll(/^path *= *"([^"]+)"/gm)].map(([, name]) => ({ name, content: readFileSync(join(dirname(scene), name)) }));
  files.forEach(({ name, content }) => engine.bring(name, content));
  // If the scene has an end in time that comes first, the run ends there.
  const changes = { "run.until_events": String(events) };
  if (/^equilibration_(events|time)/m.test(text)) {
    changes["run.equilibration_events"] = "2000";
  }
  if (isShort) {
    [...text.matchAll(/^\[\[stage\]\]/gm)].forEach((_, stage) => {
      changes[`stage.${stage}.until_events`] = String(events);
    });
  }
  const begun = engine.start(text, changes);
  if (begun.error) {
    console.log(`${scene}: does not run in the module: ${begun.error}`);
    failed += 1;
    continue;
  }
  const out = join(folder, "run");
  const set = Object.entries(changes).flatMap(([key, value]) => ["--set", `${key}=${value}`]);
  const run = spawnSync(program, ["run", scene, "--quiet", "--force", "--out", out, ...set]);
  if (run.status > 1) {
    console.log(`${scene}: the program does not run it: ${run.stderr}`);
    failed += 1;
    continue;
  }
  const summary = JSON.parse(readFileSync(join(out, "summary.json"), "utf8"));
  const expected = lastFrame(join(out, "trajectory.xyz"));
  const began = performance.now();
  const end = engine.advance(Number.MAX_SAFE_INTEGER);
  const seconds = (performance.now() - began) / 1000;
  const state = engine.look();
  const numbers = Float64Array.from([...state.positions, ...state.velocities]);
  const at = difference(numbers, expected.numbers);
  if (runs) {
    const letters = files.map(({ name, content }) => ({ name, content: content.toString("base64") }));
    appendFileSync(runs, `${JSON.stringify({ scene, text, changes, files: letters, hash: hashOf(numbers) })}\n`);
  }
  const isSame = at < 0 && state.time === expected.time;
  const rate = summary.speed.events_per_second;
  const speed = `${Math.round(state.events / seconds / 1000)} k events/s, program ${Math.round(rate / 1000)} k`;
  console.log(`${scene}: ${end} after ${state.events} events, ${isSame ? "the same bits" : `DIFFERENT at number ${at}, time ${state.time} and ${expected.time}`}; ${speed}`);
  compared += 1;
  failed += isSame ? 0 : 1;
}
rmSync(folder, { recursive: true });
console.log(`${compared} scenes compared, ${failed} failed`);
process.exit(failed > 0 || compared === 0 ? 1 : 0);
