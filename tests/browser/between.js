// Tests how the player draws particles between frames and across periodic sides. Run this test with Node.
"use strict";

const assert = require("node:assert");
const fs = require("node:fs");
const path = require("node:path");

const player = path.join(__dirname, "../../src/view/report/player");
const names = ["matrix", "colours", "recording", "surfaces", "poses", "flight", "images"];
const program = names.map((name) => fs.readFileSync(path.join(player, `${name}.js`), "utf8")).join("\n");
const { Between, imagesOf, poseBetween, posesBetween, rotation, subtract, turned, turnsBetween } = new Function(
  "document", `${program}\nreturn { Between, imagesOf, poseBetween, posesBetween, rotation, subtract, turned, turnsBetween };`)({});

const near = (found, expected, bound = 1e-5) => {
  assert.strictEqual(found.length, expected.length);
  found.forEach((x, k) => assert(Math.abs(x - expected[k]) <= bound, `${k}: ${[...found]} but ${expected}`));
};

/** Returns a recording with a frame at each whole time. */
function recording(places, flights, { fall = [0, 0, 0], slide = 0, periodic = [false, false, false], displacements = [] }) {
  const frames = places.map((_, time) => ({ time, lower: [0, 0, 0], size: [10, 10, 10], displacement: displacements[time] ?? 0, fall: 0 }));
  const count = places[0].length / 3;
  return {
    length: places.length, periodic, species: new Uint8Array(count), head: { frames, falls: [[fall]], slide, moving: count },
    frame: (index) => ({ head: frames[index], flights: flights[index], index }),
    positions: ({ index }) => Float32Array.from(places[index]),
    state: () => ({}),
  };
}

const states = {
  "a free flight under gravity is a parabola"() {
    // The particle starts at (1, 5, 5) with velocity (2, 0, 1). The acceleration of gravity is 1 along -z.
    const between = new Between(recording([[1, 5, 5], [3, 5, 5.5], [5, 5, 5]], [[1], [1]], { fall: [0, 0, -1] }));
    for (const s of [0, 0.25, 0.5, 0.9]) {
      near(between.state(0, s, -1).positions, [1 + 2 * s, 5, 5 + s - 0.5 * s * s]);
      near(between.state(1, s, -1).positions, [3 + 2 * s, 5, 5.5 - 0.5 * s * s]);
    }
    assert.strictEqual(between.count(0), 1);
    assert.strictEqual(between.count(2), 0, "nothing follows the last frame");
  },
  "a particle turns evenly, along the shorter way"() {
    const about = (angle) => [0, 0, Math.sin(angle / 2), Math.cos(angle / 2)].map((part) => Math.round(127 * part));
    const at = (from, to, s) => [...turnsBetween(Int8Array.from(about(from)), Int8Array.from(about(to)), s)];
    near(at(0, 2, 0.25), about(0.5), 1.5);
    near(at(0.5, 2.5, 0.75), about(2), 1.5);
    // The signs of a quaternion and of its opposite stand for the same orientation.
    const opposite = Int8Array.from(about(1.5).map((part) => -part));
    near([...turnsBetween(Int8Array.from(about(1)), opposite, 0.5)], about(1.25), 1.5);
    near(at(1, 1, 0.5), about(1), 0);
    assert.strictEqual(turnsBetween(undefined, undefined, 0.5), undefined);
  },
  "a flight leads through a periodic side"() {
    const between = new Between(recording([[9, 1, 5], [1, 9, 5]], [[1]], { periodic: [true, true, false] }));
    near(between.state(0, 0.25, -1).positions, [9.5, 0.5, 5]);
    near(between.state(0, 0.75, -1).positions, [0.5, 9.5, 5]);
  },
  "a flight through a sliding side is straight where it starts, and displaced behind"() {
    // The particle starts at (5, 9.5) with velocity (1, 1). It leaves through the upper side at t = 0.5 and (5.5, 10).
    // Beyond this side, x is displaced by 3 + 2 t = 4.
    const sheared = { periodic: [true, true, true], slide: 2, displacements: [3, 5] };
    const between = new Between(recording([[5, 9.5, 5], [1, 0.5, 5]], [[1]], sheared));
    near(between.state(0, 0.25, -1).positions, [5.25, 9.75, 5]);
    near(between.state(0, 0.75, -1).positions, [5.75 - 4.5, 0.25, 5]);
  },
  "what meets something stays between its places, and leaves a flight with the speed of it"() {
    const between = new Between(recording([[1, 5, 5], [2, 5, 5], [2.5, 5, 5], [2, 5, 5]], [[1], [0], [0]], {}));
    const x = [...Array(101).keys()].map((k) => between.state(1, k / 100, -1).positions[0]);
    assert(x.every((place, k) => place >= 2 && place <= 2.5 && (k === 0 || place >= x[k - 1] - 1e-6)), `${x}`);
    assert(Math.abs((x[1] - x[0]) / 0.01 - 1) < 0.05, "it comes with a speed of 1");
  },
  "what falls and then meets something leaves with the speed of its fall"() {
    // The particle starts at rest at (5, 5, 9). After a unit of time, its speed is 1.
    const between = new Between(recording([[5, 5, 9], [5, 5, 8.5], [5, 5, 7.4], [5, 5, 7]], [[1], [0], [0]], { fall: [0, 0, -1] }));
    const [start, soon] = [0, 0.01].map((s) => between.state(1, s, -1).positions[2]);
    assert(Math.abs((soon - start) / 0.01 + 1) < 0.05, `${(soon - start) / 0.01}`);
  },
  "what is beyond the picture is not drawn, and what flies there waits"() {
    const between = new Between(recording([[NaN, NaN, NaN, 5, 5, 5], [5, 5, 5, NaN, NaN, NaN]], [[0, 0]], {}));
    const { positions } = between.state(0, 0.5, -1);
    assert(Number.isNaN(positions[0]));
    near(positions.slice(3), [5, 5, 5]);
  },
  "a surface turns about its axis and moves along a line"() {
    const axis = [1 / 3, 2 / 3, 2 / 3];
    const pose = (angle) => {
      const columns = rotation(axis, angle);
      return [...columns, ...subtract([1, 2, 3], turned(columns, [1, 2, 3]))];
    };
    near(poseBetween(pose(0.3), pose(1.1), 0.25), pose(0.5), 1e-12);
    const rest = [1, 0, 0, 0, 1, 0, 0, 0, 1];
    near(poseBetween([...rest, 1, 0, 0], [...rest, 1, 4, 0], 0.25), [...rest, 1, 1, 0], 1e-12);
    assert.deepStrictEqual(posesBetween([], [], 0.5), []);
    assert.deepStrictEqual(posesBetween([null, [...rest, 0, 0, 0]], [[...rest, 0, 0, 0], null], 0.5), [null, [...rest, 0, 0, 0]]);
  },
  "images are at the other sides, edges and corners"() {
    const of = (place, periodic, displacement = 0) =>
      imagesOf({ positions: Float32Array.from(place), count: 1, radii: [0.5] }, { lower: [0, 0, 0], size: [10, 10, 10] }, periodic, displacement);
    const all = [true, true, true];
    near(of([9.75, 5, 5], all).places, [-0.25, 5, 5]);
    assert.strictEqual(of([0.25, 0.25, 9.75], all).owners.length, 7);
    assert.strictEqual(of([0.25, 0.25, 5], all).owners.length, 3);
    assert.strictEqual(of([0.25, 0.25, 5], [false, true, true]).owners.length, 1);
    assert.strictEqual(of([5, 5, 5], all).owners.length + of([NaN, NaN, NaN], all).owners.length, 0);
    near(of([5, 0.25, 5], all, 3).places, [8, 10.25, 5]);
    near(of([5, 9.75, 5], all, 4.75).places, [0.25, -0.25, 5, 10.25, -0.25, 5]);
  },
};
for (const [name, test] of Object.entries(states)) {
  test();
  console.log(`  ${name}`);
}
