// The observables of the live page beside those of a run of the program.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { Observables, RadialDistribution, classesOf, every, root } from "./observables.mjs";

/** The states of a scene in the module at even times; the virial is that of the changes of velocities at each event, where the module does not say it. */
async function* states(scene, interval, steps) {
  const { Engine } = existsSync(new URL("src/view/live/engine.js", root))
    ? classesOf(["engine.js"], "Engine")
    : await import(new URL("web/engine.mjs", root));
  const engine = await Engine.of(await WebAssembly.compile(readFileSync(new URL("web/carom.wasm", root))));
  const begun = engine.start(scene);
  assert.ok(!begun.error, begun.error);
  const { species, particles, size, lower } = begun;
  const count = particles.length;
  const whole = { gravity: [0, 0, 0], periodic: size.map((edge) => edge > 0), flat: size.map((edge) => edge === 0), ...begun };
  whole.species = species.map((one) => ({ mass: 1, ...one }));
  let velocities = Float64Array.from(engine.look().velocities);
  let virial = 0;
  let before = Float64Array.from(engine.look().positions);
  const images = new Int32Array(3 * count);
  for (let step = 0; step <= steps; step += 1) {
    while (step > 0 && engine.advance(1, step * interval) === "events") {
      const state = engine.look();
      const hit = [];
      for (let id = 0; id < count; id += 1) {
        if ([0, 1, 2].some((k) => state.velocities[3 * id + k] !== velocities[3 * id + k])) {
          hit.push(id);
        }
      }
      if (hit.length === 2) {
        [0, 1, 2].forEach((k) => {
          const d = state.positions[3 * hit[0] + k] - state.positions[3 * hit[1] + k];
          const impulse = whole.species[particles[hit[0]]].mass * (state.velocities[3 * hit[0] + k] - velocities[3 * hit[0] + k]);
          virial += (size[k] ? d - size[k] * Math.round(d / size[k]) : 0) * impulse;
        });
      }
      hit.forEach((id) => [0, 1, 2].forEach((k) => (velocities[3 * id + k] = state.velocities[3 * id + k])));
    }
    const state = engine.look();
    state.positions.forEach((x, at) => {
      const edge = size[at % 3];
      images[at] += edge ? Math.round((before[at] - x) / edge) : 0;
    });
    before = Float64Array.from(state.positions);
    yield { head: whole, lower, virial, images, counts: { core: state.events }, ...state };
  }
}

/** Columns of a table with names in its first line. */
function columns(path) {
  const [first, ...lines] = readFileSync(path, "utf8").trim().split("\n");
  return Object.fromEntries(first.split(",").map((name, k) => [name, lines.map((line) => Number(line.split(",")[k]))]));
}

/** What the program measures, and when. */
const PLAN = `until_time = 4.0
[measure]
radial_distribution = { bins = 100, interval = 0.05, cutoff = 4.0 }
diffusion = { interval = 0.05, span = 1.0 }
[output]
thermo_interval = 0.05`;

/** Compares with a run of the program, whose bits the module repeats: the fluid of hard spheres, smaller and shorter. */
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
