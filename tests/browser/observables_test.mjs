// Compares observables of the live page with exact values and with a run of the program carom, which the module of the
// page repeats bit for bit: node tests/browser/observables_test.mjs [PROGRAM]
// Without PROGRAM or web/carom.module, only exact values are tested.

import assert from "node:assert/strict";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import {
  Displacement,
  LateSums,
  Observables,
  ObservedSystem,
  Pressure,
  RadialDistribution,
  RecentSeries,
  Room,
  Speeds,
  TimeSeries,
  evenly,
  every,
  head,
  normal,
  root,
} from "./observables.mjs";
import { cost } from "./observables_cost.mjs";
import { compare } from "./observables_program.mjs";

const tests = {
  "the room of a unit cube has the known distribution of distances"() {
    const { PI } = Math;
    const open = new ObservedSystem(
      head(2, [1, 1, 1], { periodic: [false, false, false], walls: new Array(3).fill([false, false]) }),
    );
    const robbins = (r) => (4 / 3) * PI * r ** 3 - 1.5 * PI * r ** 4 + 1.6 * r ** 5 - r ** 6 / 6;
    [0.1, 0.5, 1].forEach((r) => assert.ok(Math.abs(new Room(open, 1).probability(0, r) - robbins(r)) < 1e-14));
    const slit = new ObservedSystem(head(2, [5, 0, 0], { periodic: [false, false, false] }));
    assert.ok(Math.abs(new Room(slit, 1).probability(0, 4) - 1) < 1e-14, "walls keep centres half a diameter away");
  },

  "an ideal gas has no structure in any dimension and any box"() {
    const closed = { periodic: [false, false, false] };
    const open = (...axes) => ({ periodic: [0, 1, 2].map((k) => !axes.includes(k)), walls: new Array(3).fill([false, false]) });
    const boxes = [
      [[6, 6, 6], {}],
      [[9, 14, 11], { lower: [-3, 1, 8] }],
      [[6, 7, 0], {}],
      [[16, 18, 0], {}],
      [[0, 9, 0], {}],
      [[40, 0, 0], {}],
      [[4, 5, 6], open(0, 1, 2)],
      [[9, 12, 3], open(2)],
      [[14, 13, 12], open(2)],
      [[4, 8, 0], open(0)],
      [[0, 0, 5], open(2)],
    ];
    for (const [size, more] of boxes) {
      const [count, samples] = [60, 400];
      const box = head(count, size, more);
      const radial = new RadialDistribution(new ObservedSystem(box));
      every(radial.sums);
      // Eight bins that contain all samples, with errors from their scatter.
      const parts = [];
      for (let k = 0; k < samples; k += 1) {
        const before = radial.sums.newer.slice();
        radial.sample(k, evenly(box));
        parts.push(radial.sums.newer.map((sum, at) => sum - before[at]));
      }
      const per = Math.floor(radial.bins / 8);
      for (let part = 0; part < 8; part += 1) {
        const range = [part * per, (part + 1) * per];
        const expected = radial.probabilities[0].slice(...range).reduce((sum, p) => sum + p, 0) * count * (count - 1);
        const values = parts.map((counts) => counts.slice(...range).reduce((sum, number) => sum + number, 0) / expected);
        const mean = values.reduce((sum, value) => sum + value, 0) / samples;
        const error = Math.sqrt(values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / samples / (samples - 1));
        assert.ok(Math.abs(mean - 1) < 4 * error && error < 0.2, `${size} ${part}: ${mean} +- ${error}`);
      }
    }
    assert.deepEqual(new ObservedSystem(head(60, [8, 8, 8], closed)).offer().offered.includes("radial"), true);
  },

  "cells find the pairs that all pairs have"() {
    const periods = [
      [true, true, true],
      [true, false, true],
      [false, false, false],
      [true, true, false],
    ];
    for (const [size, count] of [
      [[11, 9, 13], 300],
      [[30, 24, 0], 250],
      [[0, 0, 200], 150],
      [[3, 3, 40], 200],
    ]) {
      for (const periodic of periods) {
        const box = head(count, size, { periodic });
        const radial = new RadialDistribution(new ObservedSystem(box), { cutoff: 2.5, most: Infinity });
        const positions = evenly(box);
        radial.sample(0, positions);
        const expected = new Float64Array(radial.bins);
        for (let a = 0; a < count; a += 1) {
          for (let b = 0; b < count; b += 1) {
            const square = [0, 1, 2].reduce((sum, k) => {
              const d = positions[3 * a + k] - positions[3 * b + k];
              return sum + (d - (periodic[k] && size[k] ? size[k] * Math.round(d / size[k]) : 0)) ** 2;
            }, 0);
            const bin = Math.floor(Math.sqrt(square) / radial.width);
            expected[bin] += a !== b && bin < radial.bins ? 1 : 0;
          }
        }
        const found = radial.sums.newer.slice(0, radial.bins);
        const off = found.reduce((sum, number, k) => sum + Math.abs(number - expected[k]), 0);
        // A distance at the edge of a bin may round to either side.
        assert.ok(off <= 2 && expected.reduce((a, b) => a + b) > 100, `${size} ${periodic}: ${off}`);
      }
    }
  },

  "a perfect crystal has its neighbours at exact distances"() {
    const [edge, cells] = [Math.SQRT2, 5];
    const sites = [
      [0, 0, 0],
      [0.5, 0.5, 0],
      [0.5, 0, 0.5],
      [0, 0.5, 0.5],
    ];
    const positions = [];
    for (let n = 0; n < cells ** 3; n += 1) {
      const corner = [n % cells, Math.floor(n / cells) % cells, Math.floor(n / cells ** 2)];
      sites.forEach((site) => positions.push(...site.map((x, k) => edge * (x + corner[k] + 0.1))));
    }
    const count = 4 * cells ** 3;
    const radial = new RadialDistribution(new ObservedSystem(head(count, new Array(3).fill(cells * edge))), {
      cutoff: 2.6,
      width: 0.013,
      most: Infinity,
    });
    radial.sample(0, Float64Array.from(positions));
    const { r, g } = radial.results();
    const found = new Array(8).fill(0);
    g[0].forEach((value, k) => {
      const neighbours = value * radial.probabilities[0][k] * (count - 1);
      const shell = Math.round(r[k] ** 2);
      assert.ok(neighbours === 0 || Math.abs(r[k] - Math.sqrt(shell)) < 0.014, `neighbours at ${r[k]}`);
      found[shell] += neighbours;
    });
    [0, 12, 6, 24, 12, 24, 8].forEach((number, shell) =>
      assert.ok(Math.abs(found[shell] - number) < 1e-9, `${shell}: ${found[shell]}`),
    );
  },

  "normal components have Maxwell's distribution in one to three dimensions"() {
    for (const [size, dimensions] of [
      [[9, 0, 0], 1],
      [[9, 9, 0], 2],
      [[9, 9, 9], 3],
    ]) {
      const count = 100_000;
      const box = head(count, size);
      box.species.push({ name: "B", diameter: 1, mass: 4, isStatic: false });
      box.particles = box.particles.map((_, id) => id % 2);
      const velocities = Float64Array.from({ length: 3 * count }, (_, at) =>
        size[at % 3] ? (normal() * 1.7) / (Math.floor(at / 3) % 2 ? 2 : 1) + 5 : 0,
      );
      const speeds = new Speeds(new ObservedSystem(box));
      speeds.sample(0, velocities);
      const { centres, density, now, speed, maxwell, temperature, isReduced } = speeds.results();
      assert.ok(isReduced && Math.abs(temperature / 1.7 ** 2 - 1) < 5 * Math.sqrt(2 / (dimensions * count)), `${temperature}`);
      const width = centres[1] - centres[0];
      let chi = 0;
      let used = 0;
      centres.forEach((_, k) => {
        // Simpson's rule over five points in a bin.
        const expected =
          ((maxwell[4 * k] + 4 * maxwell[4 * k + 1] + 2 * maxwell[4 * k + 2] + 4 * maxwell[4 * k + 3] + maxwell[4 * k + 4]) /
            12) *
          width *
          count;
        assert.equal(now[k], density[k]);
        if (expected > 20) {
          chi += (density[k] * width * count - expected) ** 2 / expected;
          used += 1;
        }
      });
      assert.ok(Math.abs(chi - used) < 4 * Math.sqrt(2 * used), `${dimensions}: ${chi} of ${used} bins`);
      assert.ok(Math.abs(speed[4 * 50] - 5) < 1e-12);
    }
  },

  "free flight goes as the square of the time, and does not decay"() {
    const count = 500;
    const box = head(count, [7, 8, 0]);
    const system = new ObservedSystem(box);
    const displacement = new Displacement(system);
    const velocities = Float64Array.from({ length: 3 * count }, (_, at) => (at % 3 < 2 ? normal() : 0));
    const drift = [0, 1].map((k) => velocities.reduce((sum, v, at) => sum + (at % 3 === k ? v / count : 0), 0));
    const start = evenly(box);
    const square = velocities.reduce((sum, v, at) => sum + (at % 3 < 2 ? (v - drift[at % 3]) ** 2 : 0), 0) / (count - 1);
    for (let step = 0; step < 300; step += 1) {
      const time = 3 + 0.05 * step;
      const images = new Int32Array(3 * count);
      const positions = start.map((x, at) => {
        const unwrapped = x + velocities[at] * 0.05 * step;
        images[at] = box.size[at % 3] ? Math.floor(unwrapped / box.size[at % 3]) : 0;
        return unwrapped - images[at] * box.size[at % 3];
      });
      displacement.sample(time, { positions, velocities, images });
    }
    const { t, msd, vacf, diffusion } = displacement.results();
    assert.ok(t.length > 30 && t[0] < 0.051 && t[t.length - 1] > 8, `${t.length} ${t[t.length - 1]}`);
    t.forEach((time, k) => {
      // The mean square in a bin of times exceeds the square of the mean by the variance in the bin, at most 1/1700.
      const off = msd[0][k] / (square * time ** 2) - 1;
      assert.ok(off > -1e-9 && off < 6e-4, `${time}: ${off}`);
      assert.ok(Math.abs(vacf[0][k] / square - 1) < 1e-9);
    });
    assert.ok(Number.isNaN(diffusion[0]));
  },

  "random walks diffuse, by species, and only where there is no wall"() {
    const box = head(800, [5, 5, 5], { periodic: [true, false, true] });
    box.species.push({ name: "B", diameter: 1, mass: 1, isStatic: false });
    box.particles = box.particles.map((_, id) => (id < 400 ? 0 : 1));
    const displacement = new Displacement(new ObservedSystem(box));
    const positions = new Float64Array(2400);
    const [velocities, images] = [new Float64Array(2400), new Int32Array(2400)];
    for (let step = 0; step < 4000; step += 1) {
      displacement.sample(0.1 * step, { positions, velocities, images });
      positions.forEach((_, at) => (positions[at] += normal() * (at < 1200 ? 0.1 : 0.2)));
    }
    const { diffusion, dimensions, names } = displacement.results();
    assert.deepEqual([dimensions, names], [2, ["A", "B"]]);
    assert.ok(Math.abs(diffusion[0] / 0.05 - 1) < 0.1 && Math.abs(diffusion[1] / 0.2 - 1) < 0.1, `${diffusion}`);
    const closed = new ObservedSystem(head(800, [5, 5, 5], { periodic: [false, false, false] }));
    assert.equal(closed.offer().offered.includes("displacement"), false);
  },

  "an ideal gas has the pressure N T / V, and impulses add W / (D V t)"() {
    for (const [size, dimensions] of [
      [[20, 0, 0], 1],
      [[10, 5, 0], 2],
      [[4, 5, 6], 3],
    ]) {
      const system = new ObservedSystem(head(50, size));
      const [free, pressed] = [new Pressure(system), new Pressure(system)];
      for (let step = 0; step < 5000; step += 1) {
        free.sample(2 + 0.1 * step, 17, 1.5);
        pressed.sample(2 + 0.1 * step, 17 + 3 * 0.1 * step, 1.5);
      }
      const ideal = (50 * 1.5) / system.volume;
      const { t, p, mean, since } = free.results(NaN);
      assert.ok(
        p.length > 50 && p.length <= 120 && p.every((value) => Math.abs(value / ideal - 1) < 1e-9),
        `${p[0]} not ${ideal}`,
      );
      assert.ok(Math.abs(mean / ideal - 1) < 1e-9 && Math.abs(since - 252) < 5 && t[0] > 2);
      assert.ok(Math.abs(pressed.results(NaN).mean / (ideal + 3 / (dimensions * system.volume)) - 1) < 1e-9);
    }
  },

  "rates and pressures are over even times, however uneven the samples are"() {
    const box = head(50, [9, 9, 9]);
    const observables = new Observables(box);
    const state = {
      positions: evenly(box),
      velocities: Float64Array.from({ length: 150 }, normal),
      images: new Int32Array(150),
      kinetic: 1,
    };
    for (let k = 0; k < 400; k += 1) {
      const time = 0.1 * Math.floor(k / 2) + (k % 2) * 1e-9;
      observables.sample({ ...state, time, virial: 6 * time + (k % 2), counts: { core: 20 * time + (k % 2), wall: 0 } });
    }
    const { events, pressure } = observables.results();
    assert.deepEqual([events.names, events.isRate, events.from], [["core"], true, 0]);
    assert.ok(events.values[0].length > 50 && events.values[0].every((rate) => rate > 10 && rate < 30));
    const temperature = observables.speeds.temperature;
    assert.ok(pressure.p.every((p) => Math.abs(p * 729 - 50 * temperature - 2) < 4));
  },

  "series stay bounded and keep their ends"() {
    const [series, recent] = [new TimeSeries(1, 100), new RecentSeries(1, 100)];
    for (let k = 0; k < 12_345; k += 1) {
      series.add(k, [2 * k]);
      recent.add(k, [2 * k]);
      const [t, x] = series.read();
      assert.ok(t.length <= 101 && t[0] === 0 && t[t.length - 1] === k && x[t.length - 1] === 2 * k);
    }
    const [t] = series.read();
    const steps = new Set(Array.from(t.slice(1, -1), (time, k) => time - t[k]));
    assert.deepEqual([...steps], [128]);
    const [last] = recent.read();
    assert.deepEqual([last.length, last[0], last[99]], [100, 12_245, 12_344]);
  },

  "late sums forget the start and keep at least half"() {
    const sums = new LateSums(1);
    for (let k = 0; k < 5000; k += 1) {
      sums.turn(k);
      sums.newer[0] += 1;
      const kept = sums.total(0) / (k + 1);
      assert.ok(k < 20 || (kept > 0.49 && kept < 0.8), `${k}: ${kept}`);
    }
    assert.ok(sums.from > 1000);
  },

  "hard rods, disks and spheres have the compressibility of their theories"() {
    // The formulas of Tonks, Henderson, and Carnahan and Starling, evaluated by hand. Crystals have no value.
    const close = (found, expected) => assert.ok(Math.abs(found - expected) < 1e-12, `${found} but ${expected}`);
    close(Pressure.compressibility(0.5, 1), 2);
    close(Pressure.compressibility(0.4, 2), 1.02 / 0.36);
    close(Pressure.compressibility(0.3, 3), 1.363 / 0.343);
    assert.deepEqual([0.71, 0.5].map((fraction, k) => Pressure.compressibility(fraction, 2 + k)), [NaN, NaN]);
  },
  "the error of a mean is that of its blocks"() {
    // The means of the eight blocks are 1, 3, 1, 3, ... Their variance is 8 / 7, so the error is sqrt(8 / 7 / 8).
    const values = Float64Array.from({ length: 16 }, (_, k) => (Math.floor(k / 2) % 2 ? 3 : 1) + (k % 2 ? 0.5 : -0.5));
    assert.ok(Math.abs(Pressure.scatter(values) - Math.sqrt(1 / 7)) < 1e-12);
    assert.ok(Number.isNaN(Pressure.scatter(new Float64Array(3))));
  },
  "few particles have their positions as if nothing were wrapped"() {
    const box = { ...head(1, [4, 5, 6]), gravity: [0, 0, -1] };
    const observables = new Observables(box);
    observables.want(["positions"]);
    for (let k = 0; k < 9; k += 1) {
      const state = { time: k, positions: Float64Array.from([1, 1, 0.5]), velocities: Float64Array.from([0, 0, -6]), images: Int32Array.from([0, 0, -k]) };
      observables.sample({ ...state, kinetic: 18, potential: -6 * k, virial: 0, counts: {} });
    }
    const { t, axis, x, v } = observables.results().positions;
    assert.equal(axis, "z");
    assert.deepEqual([...t], [0, 1, 2, 3, 4, 5, 6, 7, 8]);
    assert.deepEqual([...x[0]], [...t].map((time) => 0.5 - 6 * time));
    assert.deepEqual([...v[0]], new Array(9).fill(-6));
  },
  "nothing is offered that has no meaning"() {
    const offered = (count, size, more) => new ObservedSystem(head(count, size, more)).offer();
    assert.deepEqual(offered(3, [9, 9, 9]), {
      offered: ["energy", "pressure", "events", "positions", "portrait"],
      shown: ["positions", "energy"],
    });
    assert.deepEqual(offered(500, [9, 9, 9]).shown, ["speeds", "radial"]);
    const heap = offered(500, [9, 9, 90], { gravity: [0, 0, -1], periodic: [false, false, false] });
    assert.deepEqual(heap, { offered: ["speeds", "energy", "outflow", "events"], shown: ["energy", "outflow"] });
    const drum = offered(500, [9, 9, 90], { gravity: [0, 0, -1], periodic: [false, false, false], isContained: true });
    assert.deepEqual(drum, { offered: ["speeds", "energy", "events"], shown: ["energy", "events"] });
    const open = {
      periodic: [true, true, false],
      walls: [
        [false, false],
        [false, false],
        [true, false],
      ],
    };
    assert.deepEqual(offered(500, [9, 9, 9], open).offered, ["speeds", "energy", "displacement", "autocorrelation", "events"]);
    assert.equal(offered(500, [9, 9, 9], { shearRate: 1 }).offered.includes("radial"), false);
  },

  "what the head does not say is learnt from states"() {
    const still = (box) => ({
      positions: evenly(box),
      velocities: Float64Array.from(box.particles.flatMap(() => [1, 0, 0])),
      images: new Int32Array(3 * box.particles.length),
      kinetic: 1,
      virial: 0,
    });
    const box = head(50, [9, 9, 9]);
    const sheared = new Observables(box);
    sheared.sample({ ...still(box), time: 0, displacement: 0 });
    assert.ok(sheared.results().pressure && sheared.results().radial);
    sheared.sample({ ...still(box), time: 1, displacement: 0.1 });
    assert.deepEqual(sheared.results().offered, ["energy", "events"]);
    const walled = head(50, [9, 9, 9], { periodic: [true, true, false] });
    const open = new Observables(walled);
    open.sample({ ...still(walled), time: 0 });
    assert.ok(open.results().radial);
    const state = still(walled);
    state.positions[5] = 9.001;
    open.sample({ ...state, time: 1 });
    assert.equal(open.results().offered.includes("radial"), false);
    const growing = new Observables(box);
    growing.sample({ ...still(box), time: 0, scale: 1 });
    growing.sample({ ...still(box), time: 1, scale: 1.02 });
    assert.equal(growing.results().radial.since, 1);
  },
};

let failed = 0;
for (const [name, test] of Object.entries(tests)) {
  try {
    test();
    console.log(`ok: ${name}`);
  } catch (error) {
    failed += 1;
    console.log(`FAILED: ${name}\n${error.stack}`);
  }
}
cost();
const program = process.argv[2];
if (program && existsSync(new URL("web/carom.module", root))) {
  const folder = mkdtempSync(join(tmpdir(), "carom-"));
  try {
    await compare(program, folder);
    console.log("ok: the program measures the same");
  } catch (error) {
    failed += 1;
    console.log(`FAILED: the program measures the same\n${error.stack}`);
  }
  rmSync(folder, { recursive: true });
}
process.exit(failed > 0 ? 1 : 0);
