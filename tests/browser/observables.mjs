// The observables of the live page for tests, and their input.

import { readdirSync } from "node:fs";
import { classesOf, root } from "./scripts.mjs";

export { classesOf, root };

const sources = readdirSync(new URL("src/view/live/", root)).filter((name) => /^observables.*\.js$/.test(name));
export const {
  Observables,
  ObservedSystem,
  Speeds,
  Room,
  RadialDistribution,
  Pressure,
  Displacement,
  TimeSeries,
  RecentSeries,
  LateSums,
} = classesOf(
  sources,
  "Observables, ObservedSystem, Speeds, Room, RadialDistribution, Pressure, Displacement, TimeSeries, RecentSeries, LateSums",
);

/** Even random numbers from 0 to 1 (a generator of Marsaglia, xorshift). */
function generator(seed) {
  let state = seed;
  return () => {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    return (state >>> 0) / 2 ** 32;
  };
}

export const random = generator(88172645);
export const normal = () => Math.sqrt(-2 * Math.log(1 - random())) * Math.cos(2 * Math.PI * random());

export const head = (count, size, more = {}) => ({
  species: [{ name: "A", diameter: 1, mass: 1, isStatic: false }],
  particles: new Array(count).fill(0),
  lower: [0, 0, 0],
  size,
  periodic: size.map((edge) => edge > 0),
  flat: size.map((edge) => edge === 0),
  gravity: [0, 0, 0],
  ...more,
});

export const evenly = ({ lower, size, particles }) =>
  Float64Array.from({ length: 3 * particles.length }, (_, at) => lower[at % 3] + random() * size[at % 3]);
/** Sums that forget nothing. */
export const every = (sums) => Object.assign(sums, { turn: () => false });
