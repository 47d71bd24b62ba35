// Tests how the worker of a live page processes states, without a browser: node tests/browser/worker_test.mjs

import assert from "node:assert/strict";
import test from "node:test";
import { classesOf } from "./scripts.mjs";

const { Neighbours, Frames, Pace } = classesOf(["worker_neighbours.js", "worker_frame.js", "worker_pace.js"], "Neighbours, Frames, Pace");

const species = [{ name: "ball", diameter: 1, isStatic: false }, { name: "wall", diameter: 2, isStatic: true }];

function head(particles, more = {}) {
  return { species, particles, lower: [0, 0, 0], size: [4, 5, 6], periodic: [true, true, true], flat: [false, false, false], gravity: [0, 0, 0], ...more };
}

/** Numbers between 0 and 1 that are the same each time. */
function numbers(seed) {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

test("neighbours are those of all pairs", () => {
  const next = numbers(7);
  const all = [true, true, true];
  const boxes = [[200, [4, 5, 6], all], [90, [20, 3, 0], [true, false, false]], [60, [2, 2, 2], all], [400, [10, 13, 3], all], [0, [1, 1, 1], all]];
  for (const [count, size, periodic] of boxes) {
    const given = head([...Array(count).keys()].map((k) => (k % 9 === 0 ? 1 : 0)), { size, periodic });
    const positions = Float64Array.from({ length: 3 * count }, (_, k) => size[k % 3] * (periodic[k % 3] ? next() : 3 * next() - 1));
    const neighbours = new Neighbours(given);
    const expected = new Uint8Array(count);
    for (let a = 0; a < count; a += 1) {
      for (let b = 0; b < a; b += 1) {
        if (neighbours.isNear(positions, a, b)) {
          expected[a] += 1;
          expected[b] += 1;
        }
      }
    }
    assert.deepEqual(neighbours.count(positions, new Uint8Array(count)), expected);
    assert.ok(count === 0 || expected.some((number) => number > 0));
  }
});

function state(time, events, velocities, acceleration = [0, 0, 0]) {
  return { time, events, velocities: Float64Array.from(velocities), positions: new Float64Array(velocities.length), acceleration, scale: 1 };
}

test("contacts are changes of velocity that gravity does not explain", () => {
  const frames = new Frames(head([0, 0, 1]), state(0, 0, [1, 0, 0, 0, 1, 0, 0, 0, 0]));
  const pull = [0, 0, -2];
  assert.deepEqual([...frames.frame(state(1, 0, [1, 0, -2, 0, 1, -2, 0, 0, 0], pull), "species").hits], [0, 0]);
  assert.deepEqual([...frames.frame(state(2, 1, [1, 0, -4, 0, -1, -4, 0, 0, 0], pull), "species").hits], [0, 1]);
  assert.deepEqual([...frames.frame(state(3, 1, [3, 0, -6, 0, 5, -6, 0, 0, 0], pull), "species").hits], [0, 0]);
});

test("pictures have what moves, and take buffers back", () => {
  const frames = new Frames(head([1, 0]), state(0, 0, [0, 0, 0, 3, 4, 0]));
  const first = frames.frame(state(0, 0, [0, 0, 0, 3, 4, 0]), "speed");
  assert.deepEqual([...first.velocities], [3, 4, 0]);
  assert.equal(first.scale.high, 2.2 * 5);
  assert.equal(first.tones[0], Math.round(255 / 2.2));
  frames.reuse([first.positions.buffer]);
  assert.equal(frames.frame(state(1, 0, [0, 0, 0, 3, 4, 0]), "species").positions.buffer, first.positions.buffer);
});

test("a pace that cannot be kept is given up", () => {
  const pace = new Pace();
  pace.speed = 2;
  pace.anchor(1000, 5);
  assert.equal(pace.goal(1500), 6);
  pace.note(1500, 5.99);
  assert.equal(pace.isLate, false);
  pace.note(1500, 5.5);
  assert.equal(pace.isLate, true);
  assert.equal(pace.goal(1500), 5.5);
  pace.speed = Infinity;
  assert.equal(pace.goal(1600), Infinity);
});

test("calls of the engine become longer while they are short, and shorter when they are long", () => {
  const pace = new Pace();
  const { events } = pace;
  pace.adapt(true, 0.1);
  assert.equal(pace.events, 2 * events);
  pace.adapt(false, 50);
  assert.equal(pace.events, events);
});
