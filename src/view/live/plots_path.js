/** Rounds a position to a tenth of a pixel, and limits positions far outside the plot. */
const pixel = (place) => Math.round(Math.min(Math.max(place, -1e4), 1e4) * 10) / 10;

/**
 * Returns the SVG path of a curve. In a dense curve, a pixel column has at most four points: the first, lowest, highest
 * and last.
 */
function curvePath({ x, y, isLoose }, [across, up]) {
  const parts = [];
  const count = Math.min(x.length, y.length);
  const isDense = !isLoose && count > 1.5 * Math.abs(across.to - across.from);
  let isDown = false;
  let k = 0;
  const add = (left, top) => {
    parts.push(isDown ? "L" : "M", pixel(left), " ", pixel(top));
    isDown = true;
  };
  while (k < count) {
    if (!across.hasPlace(x[k]) || !up.hasPlace(y[k])) {
      isDown = false;
      k += 1;
      continue;
    }
    const left = across.place(x[k]);
    const top = up.place(y[k]);
    add(left, top);
    k += 1;
    if (isDense) {
      let [least, most, last] = [top, top, top];
      for (; k < count && up.hasPlace(y[k]) && Math.abs(across.place(x[k]) - left) < 1; k += 1) {
        last = up.place(y[k]);
        least = Math.min(least, last);
        most = Math.max(most, last);
      }
      const [low, high] = [Math.min(top, last) - 1, Math.max(top, last) + 1];
      if (least < low || most > high) {
        [least, most, last].forEach((place) => add(left, place));
      }
    }
  }
  return parts.join("");
}

/** Returns the path of a histogram's area, or of the area between the curves `low` and `high`. */
function stepsPath({ x, y, low, high }, [across, up]) {
  const bottom = up.from;
  const place = (value) => pixel(up.hasPlace(value) ? up.place(value) : bottom);
  if (low) {
    const side = (values) => Array.from(x, (at, k) => `${pixel(across.place(at))} ${place(values[k])}`);
    return `M${[...side(high), ...side(low).reverse()].join("L")}Z`;
  }
  if (x.length < 2) {
    return "";
  }
  const half = 0.5 * (x[1] - x[0]);
  const edge = (value) => pixel(across.hasPlace(value) ? across.place(value) : across.from);
  const steps = Array.from(x, (centre, k) => `V${place(y[k])}H${edge(centre + half)}`);
  return `M${edge(x[0] - half)} ${pixel(bottom)}${steps.join("")}V${pixel(bottom)}Z`;
}

const SAVED = [
  "fill",
  "stroke",
  "stroke-width",
  "stroke-dasharray",
  "stroke-linejoin",
  "opacity",
  "font-size",
  "font-family",
  "font-variant-numeric",
];

/** Returns the plot as a separate drawing with title and legend, in the colours of the page. */
function plotDrawing(plot) {
  const { svg, width, height, term } = plot;
  const named = (plot.values ?? []).map(({ name }) => plot.lines.find((line) => line.name === name)).filter(Boolean);
  const copy = svg.cloneNode(true);
  const [originals, copies] = [svg, copy].map((root) => [...root.querySelectorAll("path, text, circle, g")]);
  originals.forEach((original, k) => {
    const style = getComputedStyle(original);
    SAVED.forEach((property) => {
      const value = style.getPropertyValue(property);
      if (value && !["none", "normal"].includes(value) | (property === "fill" || property === "stroke")) {
        copies[k].setAttribute(property, value);
      }
    });
  });
  copy.querySelector(".live-plot-over").remove();
  const page = getComputedStyle(document.documentElement);
  const ink = page.getPropertyValue("--ink").trim();
  const longest = Math.max(...named.map(({ name }) => name.length));
  const across = Math.max(1, Math.floor((width - plot.edge.left) / (44 + 7 * longest)));
  const total = height + 34 + 20 * Math.ceil(named.length / across);
  const whole = drawn("svg", {
    xmlns: PLOT_SPACE,
    width,
    height: total,
    viewBox: `0 0 ${width} ${total}`,
    "font-family": "system-ui, sans-serif",
    "font-size": 12.5,
    fill: ink,
  });
  drawn("rect", { width, height: total, fill: page.getPropertyValue("--paper").trim() }, whole);
  drawn("text", { x: 12, y: 20, "font-size": 14, "font-weight": 600 }, whole).textContent = [term, plot.note.textContent]
    .filter(Boolean)
    .join(": ");
  copy.removeAttribute("tabindex");
  Object.entries({ y: 30, width, height }).forEach(([key, value]) => copy.setAttribute(key, value));
  whole.append(copy);
  named.forEach((line, k) => {
    const { group } = plot.groups[plot.lines.indexOf(line)];
    const path = group.querySelector(line.style === "steps" ? ".band" : "path");
    const style = getComputedStyle(path);
    const [x, y] = [
      plot.edge.left + (k % across) * ((width - plot.edge.left) / across),
      height + 44 + 20 * Math.floor(k / across),
    ];
    const isArea = line.style === "steps";
    drawn(
      "path",
      {
        d: isArea ? `M${x} ${y - 8}h24v8h-24z` : `M${x} ${y - 4}h24`,
        fill: isArea ? style.fill : "none",
        stroke: isArea ? "none" : style.stroke,
        opacity: style.opacity,
        "stroke-width": 1.6,
        "stroke-dasharray": style.strokeDasharray,
      },
      whole,
    );
    drawn("text", { x: x + 30, y }, whole).textContent = line.name;
  });
  return new XMLSerializer().serializeToString(whole);
}

function savePlot(plot) {
  const name = plot.term.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "");
  saveFile(`${name}.svg`, "image/svg+xml", plotDrawing(plot));
}
