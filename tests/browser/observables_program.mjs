// Compares the observables of the live page with the observables of a run of the program.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { Observables, RadialDistribution, every, root } from "./observables.mjs";
import { classesOf, moduleOf } from "./scripts.mjs";

/** The states of a scene in the module at even times. */
async function* states(scene, interval, steps) {
  const { Engine } = classesOf(["engine.js"], "Engine");
  const engine = await Engine.of(await WebAssembly.compile(moduleOf()));
  const head = engine.start(scene);
  assert.ok(!head.error, head.error);
  for (let step = 0; step <= steps; step += 1) {
    while (engine.advance(Number.MAX_SAFE_INTEGER, step * interval) === "end" && engine.look().time < step * interval);
    const state = engine.look();
    yield { head: { ...head, gravity: state.acceleration }, lower: head.lower, ...state };
  }
}

/** Columns of a table with names in its first line. */
function columns(path) {
  const [first, ...lines] = readFileSync(path, "utf8").trim().split("\n");
  return Object.fromEntries(first.split(",").map((name, k) => [name, lines.map((line) => Number(line.split(",")[k]))]));
}

/** Measurements of the program, with their times. */
const PLAN = `until_time = 4.0
[measure]
radial_distribution = { bins = 100, interval = 0.05, cutoff = 4.0 }
diffusion = { interval = 0.05, span = 1.0 }
[output]
thermo_interval = 0.05`;

/**
 * Compares the observables with a run of the program, for a small fluid of hard spheres and a short time. The
 * module repeats the run bit for bit.
 */
export async function compare(program, folder) {
  const scene = readFileSync(new URL("configs/hard_sphere_fluid.toml", root), "utf8")
    .replace("count = 4000", "count = 500")
    .replace(/equilibration_events = .*/, "")
    .replace(/until_events = .*/, PLAN);
  const [path, out] = [join(folder, "fluid.toml"), join(folder, "fluid")];
  writeFileSync(path, scene);
  const run = spawnSync(program, ["run", path, "--quiet", "--force", "--out", out], { encoding: "utf8" });
  assert.ok(run.status <= 1, run.stderr);
  let observables;
  let radial;
  for await (const state of states(scene, 0.05, 80)) {
    if (!observables) {
      observables = new Observables(state.head);
      radial = new RadialDistribution(observables.system, { cutoff: 4, width: 0.04, most: Infinity });
      every(radial.sums);
      every(observables.displacement.sums);
    }
    observables.sample(state);
    if (state.time > 0) {
      radial.sample(state.time, state.positions);
    }
  }
  const { pressure } = JSON.parse(readFileSync(join(out, "summary.json"), "utf8")).observables;
  const series = observables.pressure.series.read();
  const own = observables.pressure.between(series, 0, series[0].length - 1);
  console.log(`pressure ${own}, program ${pressure.mean} +- ${pressure.standard_error}`);
  assert.ok(Math.abs(own / pressure.mean - 1) < 1e-9);
  const rows = columns(join(out, "thermo.csv")).pressure.slice(1);
  const { p, expected } = observables.results().pressure;
  assert.ok(p.length === 80 && p.every((value, k) => Math.abs(value / rows[k] - 1) < 1e-9), "pressure of each interval");
  console.log(`Carnahan and Starling: ${expected}`);
  assert.ok(Math.abs(expected / (0.4 / (Math.PI / 6)) - 6.926) < 0.01, `${expected}`);
  const { g_r_sphere_sphere: g } = columns(join(out, "measurements", "radial_distribution.csv"));
  const off = Math.max(...Array.from(radial.results().g[0], (value, k) => Math.abs(value - g[k])));
  console.log(`g(r): ${g.length} bins differ by ${off} at most`);
  assert.ok(off < 1e-9);
  const { t, dr_2: msd, dr_2_error: error } = columns(join(out, "measurements", "mean_squared_displacement.csv"));
  const found = observables.results().displacement;
  let worst = 0;
  found.t.forEach((time, k) => {
    const at = t.findIndex((known) => Math.abs(known - time) < 1e-9);
    if (at > 0 && error[at] > 0) {
      worst = Math.max(worst, Math.abs(found.msd[0][k] - msd[at]) / error[at]);
    }
  });
  const { numbers } = JSON.parse(readFileSync(join(out, "measurements.json"), "utf8"));
  const diffusion = numbers.find(({ name }) => name === "diffusion_coefficient");
  console.log(
    `mean squared displacement: within ${worst} errors; D ${found.diffusion[0]}, program ${diffusion.mean} +- ${diffusion.standard_error}`,
  );
  assert.ok(worst > 0 && worst < 4);
  assert.ok(Math.abs(found.diffusion[0] - diffusion.mean) < 4 * diffusion.standard_error);
}
