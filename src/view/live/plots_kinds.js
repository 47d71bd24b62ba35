const since = (from, to) => (from === undefined ? "" : `mean of t = ${plotValue(from)} to ${plotValue(to)}`);

const line = (name, x, y, more = {}) => ({ name, x, y, style: "line", ...more });

/** Returns the mean rate of change of a series over the last part of its time. */
function lastRate(t, values, part = 0.25) {
  const last = t.length - 1;
  const first = t.findIndex((time) => time >= t[last] - part * (t[last] - t[0]));
  return last > first && first >= 0 ? (values[last] - values[first]) / (t[last] - t[first]) : NaN;
}

/** Largest number of points of a path in a phase portrait. */
const PORTRAIT_POINTS = 800;

const PLOT_KINDS = {
  speeds: {
    chip: "Speeds",
    hasNote: true,
    title: "Speeds",
    xLabel: "speed v",
    yLabel: "p(v)",
    canBeLogarithmic: [false, true],
    content({ speeds, time }) {
      const { centres, now, density, speed, maxwell, isReduced, temperature } = speeds;
      const highest = Math.max(...now, ...density);
      // If all particles start with equal speeds, the high peak is clipped, so that other parts remain visible.
      const peak =
        maxwell.length > 0 ? Math.min(Math.max(highest, 1.15 * Math.max(...maxwell)), 2 * Math.max(...maxwell)) : highest;
      const lines = [
        line("now", centres, now, { style: "steps", colour: 0, isCut: true }),
        line("mean", centres, density, { colour: 0, isCut: true }),
      ];
      return {
        lines: [...lines, line("Maxwell", speed, maxwell, { style: "dashes" })],
        xLabel: isReduced ? "reduced speed v √(m/T)" : "speed v",
        x: [0, centres[centres.length - 1] * 0.86],
        y: [0, undefined],
        include: [peak],
        note: [maxwell.length > 0 ? `T = ${plotValue(temperature)}` : "", since(speeds.since, time)].filter(Boolean).join(" · "),
      };
    },
  },
  radial: {
    chip: "g(r)",
    hasNote: true,
    title: "g(r)",
    term: "Radial distribution function",
    xLabel: "distance r",
    yLabel: "g(r)",
    canBeLogarithmic: [false, false],
    content({ radial, time }) {
      const { r, g, names } = radial;
      const lines = g.map((values, k) => line(names[k], r, values));
      return {
        lines: [{ style: "level", at: 1, x: [], y: [] }, ...lines],
        x: [0, r[r.length - 1] + r[0]],
        y: [0, undefined],
        include: [1.2],
        note: since(radial.since, time),
      };
    },
  },
  energy: {
    chip: "Energy",
    title: "Energy",
    xLabel: "time t",
    yLabel: "energy",
    isTime: true,
    content({ energy, marks }) {
      const { t, kinetic, potential, total } = energy;
      const lines = [line("kinetic", t, kinetic)];
      if (potential) {
        lines.push(line(energy.isRelative ? "potential from the start" : "potential", t, potential), line("total", t, total));
      }
      // The energy of a cooling gas decays as a power of time.
      const cools = !potential && kinetic[0] > 0 && kinetic[kinetic.length - 1] < 0.03 * Math.max(...kinetic);
      return { lines, marks, logarithmic: [false, cools] };
    },
  },
  pressure: {
    chip: "Pressure",
    hasNote: true,
    title: "Pressure",
    xLabel: "time t",
    yLabel: "pressure p",
    isTime: true,
    content({ pressure, marks, time }) {
      const { t, p, mean, error, expected } = pressure;
      const lines = [line("virial", t, p, { style: "thin" })];
      if (Number.isFinite(mean)) {
        const ends = [pressure.since, time];
        const both = (value) => [value, value];
        const band = Number.isFinite(error) ? { low: both(mean - error), high: both(mean + error) } : {};
        lines.push(line("mean", ends, both(mean), { colour: 1, ...band }));
      }
      if (Number.isFinite(expected) && t.length > 0) {
        lines.push(line("equation of state", [t[0], time], [expected, expected], { style: "dashes" }));
      }
      const uncertainty = Number.isFinite(error) ? ` ± ${plainNumber(String(Number(error.toPrecision(2))))}` : "";
      return {
        lines,
        marks,
        x: [pressure.from, undefined],
        include: Number.isFinite(expected) ? [expected] : [],
        note: Number.isFinite(mean) ? `p = ${plotValue(mean)}${uncertainty}` : "",
      };
    },
  },
  displacement: {
    chip: "Displacement",
    hasNote: true,
    title: "Displacement",
    term: "Mean squared displacement",
    xLabel: "time t",
    yLabel: "⟨Δr²⟩",
    isLogarithmic: [true, true],
    content({ displacement }) {
      const { t, msd, names, diffusion, dimensions } = displacement;
      const lines = msd.map((values, k) => line(names.length > 1 ? names[k] : "measured", t, values));
      diffusion.forEach((value, k) => {
        if (Number.isFinite(value)) {
          const long = t.filter((time) => time > t[t.length - 1] / 300);
          lines.push(
            line(
              `${2 * dimensions} D t${names.length > 1 ? ` ${names[k]}` : ""}`,
              long,
              long.map((time) => 2 * dimensions * value * time),
              { style: "dashes", colour: k },
            ),
          );
        }
      });
      const known = diffusion.map((value, k) => [value, names[k]]).filter(([value]) => Number.isFinite(value));
      return {
        lines,
        note: known.map(([value, name]) => `D = ${plotValue(value)}${names.length > 1 ? ` ${name}` : ""}`).join(", "),
      };
    },
  },
  autocorrelation: {
    chip: "Autocorrelation",
    title: "Autocorrelation",
    term: "Velocity autocorrelation",
    xLabel: "time t",
    yLabel: "⟨v(0)·v(t)⟩",
    isLogarithmic: [true, false],
    content({ autocorrelation }) {
      const { t, vacf, names } = autocorrelation;
      return {
        lines: [
          { style: "level", at: 0, x: [], y: [] },
          ...vacf.map((values, k) => line(names.length > 1 ? names[k] : "measured", t, values)),
        ],
      };
    },
  },
  outflow: {
    chip: "Outflow",
    hasNote: true,
    title: "Outflow",
    xLabel: "time t",
    yLabel: "particles",
    isTime: true,
    content({ outflow, marks }) {
      const { t, below, names } = outflow;
      const rate = lastRate(t, below[0]);
      return {
        lines: below.map((values, k) => line(names[k], t, values)),
        marks,
        include: [0, 10],
        note: rate > 0 ? `rate ${plotValue(rate)}` : "",
      };
    },
  },
  events: {
    chip: "Events",
    title: "Events",
    xLabel: "time t",
    yLabel: "events",
    isTime: true,
    content({ events, marks }) {
      const { t, names, values, isRate } = events;
      return {
        lines: values.map((one, k) => line(names[k], t, one)),
        marks,
        x: [events.from, undefined],
        include: [0],
        yLabel: isRate ? "events per time" : "number of events",
      };
    },
  },
  positions: {
    chip: "Positions",
    title: "Positions",
    xLabel: "time t",
    yLabel: "x",
    isTime: true,
    canBeLogarithmic: [false, false],
    content({ positions, marks }) {
      const { t, x, names, axis } = positions;
      return { lines: x.map((values, k) => line(names[k], t, values)), marks, yLabel: `position ${axis}` };
    },
  },
  portrait: {
    chip: "Phase portrait",
    title: "Phase portrait",
    xLabel: "x",
    yLabel: "velocity",
    canBeLogarithmic: [false, false],
    content({ portrait }) {
      const { x, v, names, axis } = portrait;
      return {
        lines: x.map((values, k) =>
          line(names[k], values.slice(-PORTRAIT_POINTS), v[k].slice(-PORTRAIT_POINTS), { isLoose: true, style: "thin" }),
        ),
        hasLast: true,
        xLabel: `position ${axis}`,
        yLabel: `velocity ${axis}`,
      };
    },
  },
};
