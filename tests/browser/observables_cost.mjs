// Times the observables of the live page.

import { Observables, evenly, head, normal } from "./observables.mjs";

const processorTime = () => process.cpuUsage().user / 1000;

/** A sample of 5,000 spheres, in milliseconds of processor time. */
export function cost() {
  const box = head(5000, [18.7, 18.7, 18.7]);
  const observables = new Observables(box);
  const state = {
    positions: evenly(box),
    velocities: Float64Array.from({ length: 15_000 }, normal),
    images: new Int32Array(15_000),
    kinetic: 7500,
    potential: 0,
    virial: 0,
    counts: { core: 1 },
  };
  const [warm, number] = [50, 300];
  let began;
  let results = 0;
  for (let k = 0; k < warm + number; k += 1) {
    began = k === warm ? processorTime() : began;
    observables.sample({ ...state, time: 0.1 * k, virial: k, counts: { core: k } });
    if (k >= warm && k % 10 === 0) {
      const start = processorTime();
      observables.results();
      results += processorTime() - start;
    }
  }
  const each = (processorTime() - began - results) / number;
  console.log(`a sample of 5,000 particles takes ${each.toFixed(2)} ms, results ${((10 * results) / number).toFixed(2)} ms`);
  return each;
}
