const PLOT_SPACE = "http://www.w3.org/2000/svg";

function drawn(name, attributes = {}, parent = undefined) {
  const element = document.createElementNS(PLOT_SPACE, name);
  Object.entries(attributes).forEach(([key, value]) => element.setAttribute(key, value));
  parent?.append(element);
  return element;
}

function made(name, className, parent, text) {
  const element = document.createElement(name);
  element.className = className;
  if (text !== undefined) {
    element.textContent = text;
  }
  parent?.append(element);
  return element;
}

/** Margins of the plot area in pixels. The left margin depends on the labels. */
const PLOT_EDGE = { top: 8, right: 12, bottom: 44 };

/** Draws the axes with grid, ticks and titles if they have changed. */
function drawPlotFrame(plot) {
  const { width, height, axes } = plot;
  const [x, y] = axes;
  const upright = y.marks(Math.max(3, height / 48));
  const longest = Math.max(1, ...upright.map(({ label }) => label?.length ?? 0));
  // The width of the labels is rounded, so that the plot area does not jitter.
  const left = 34 + 10 * Math.ceil((7.2 * longest) / 10);
  plot.edge = { ...PLOT_EDGE, left };
  x.between(left, width - PLOT_EDGE.right);
  y.between(height - PLOT_EDGE.bottom, PLOT_EDGE.top);
  const signature = [
    width,
    height,
    left,
    x.low,
    x.high,
    x.isLogarithmic,
    y.low,
    y.high,
    y.isLogarithmic,
    plot.content.xLabel,
    plot.content.yLabel,
  ].join();
  if (signature === plot.signature) {
    return;
  }
  plot.signature = signature;
  plot.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const [bottom, right, top] = [height - PLOT_EDGE.bottom, width - PLOT_EDGE.right, PLOT_EDGE.top];
  const parts = document.createDocumentFragment();
  const text = (label, attributes) => (drawn("text", attributes, parts).textContent = label);
  const across = x.marks(Math.max(3, (right - left) / 60));
  for (const { value, label } of across) {
    const at = x.place(value).toFixed(1);
    if (label !== undefined) {
      drawn("path", { class: "grid", d: `M${at} ${top}V${bottom}` }, parts);
      text(label, { x: at, y: bottom + 18, "text-anchor": "middle" });
    }
    drawn("path", { class: "axis", d: `M${at} ${bottom}v${label === undefined ? 3 : 5}` }, parts);
  }
  for (const { value, label } of upright) {
    const at = y.place(value).toFixed(1);
    if (label !== undefined) {
      drawn("path", { class: "grid", d: `M${left} ${at}H${right}` }, parts);
      text(label, { x: left - 8, y: at, dy: ".32em", "text-anchor": "end" });
    }
    drawn("path", { class: "axis", d: `M${left} ${at}h-${label === undefined ? 3 : 5}` }, parts);
  }
  drawn("path", { class: "axis", d: `M${left} ${top}V${bottom}H${right}` }, parts);
  text(plot.content.xLabel ?? plot.xLabel, { class: "name", x: 0.5 * (left + right), y: height - 8, "text-anchor": "middle" });
  const middle = 0.5 * (top + bottom);
  text(plot.content.yLabel ?? plot.yLabel, {
    class: "name",
    x: 14,
    y: middle,
    "text-anchor": "middle",
    transform: `rotate(-90 14 ${middle})`,
  });
  plot.frame.replaceChildren(parts);
  Object.entries({
    x: left,
    y: top,
    width: right - left,
    height: bottom - top,
    viewBox: `${left} ${top} ${right - left} ${bottom - top}`,
  }).forEach(([key, value]) => plot.field.setAttribute(key, value));
}
