// Sliders that change values in the text of a scene.

/** Largest number of sliders for a scene that declares none. */
const SLIDER_COUNT = 7;

const SLIDER_STEPS = 200;

const flatAxes = (toml) => ["x", "y", "z"].filter((axis) => toml.get(`space.${axis}`) === "flat").length;

/** Returns the largest packing fraction that an arrangement reaches quickly. */
function densest(toml, index) {
  const isRandom = toml.get(`fill.${index}.arrangement`) === "random";
  return [isRandom ? 0.55 : 0.7, isRandom ? 0.65 : 0.88, 0.95][flatAxes(toml)] ?? 0.5;
}

/** Returns the upper end of a slider: a multiple of the present value, rounded up to one digit. */
function above(value, factor = 4) {
  const most = Math.abs(value) * factor || 1;
  const unit = 10 ** Math.floor(Math.log10(most));
  return Number((Math.ceil(most / unit) * unit).toPrecision(3));
}

/**
 * Keys that users often vary, by priority. `fits` matches the path of a key. `isLive` is true if a running simulation
 * can take a new value.
 */
const SLIDER_RULES = [
  {
    fits: /^fill\.(\d+)\.packing_fraction$/, label: "packing fraction",
    range: (value, toml, [, index]) => ({ from: 0.02, to: Math.max(densest(toml, index), value) }),
  },
  { fits: /^fill\.\d+\.number_density$/, label: "number density", range: (value) => ({ from: value / 10, to: above(value, 2) }) },
  { fits: /^dynamics\.gravity(?:\.\d)?$/, label: "gravity", isLive: true, range: (value) => ({ from: 0, to: above(value) }) },
  { fits: /^fill\.\d+\.temperature$/, label: "temperature", range: (value) => ({ from: value / 100, to: value * 100, scale: "log" }) },
  { fits: /^chain\.\d+\.temperature$/, label: "temperature", range: (value) => ({ from: value / 100, to: value * 100, scale: "log" }) },
  { fits: /^space\.[xyz]\.(?:lower|upper)\.temperature$/, label: "wall temperature", range: (value) => ({ from: value / 10, to: value * 10, scale: "log" }) },
  { fits: /^space\.y\.shear_rate$/, label: "shear rate", range: (value) => ({ from: 0, to: above(value) }) },
  { fits: /^interaction\.[^.]+\.restitution$/, label: "restitution", isLive: true, range: () => ({ from: 0, to: 1 }) },
  { fits: /^interaction\.[^.]+\.well_depth$/, label: "well depth", isLive: true, range: (value) => ({ from: Math.min(0, 2 * value), to: above(value) }) },
  { fits: /^interaction\.\d+\.lambda$/, label: "well width λ", range: () => ({ from: 1.02, to: 3 }) },
  {
    fits: /^fill\.\d+\.count$/, label: "particles", isInteger: true,
    range: (value) => ({ from: Math.max(1, Math.round(value / 20)), to: Math.max(value * 4, 20), scale: "log" }),
  },
  { fits: /^space\.[xyz]\.restitution$/, label: "restitution of walls", isLive: true, range: () => ({ from: 0, to: 1 }) },
  { fits: /^surface\.[^.]+\.restitution$/, label: "restitution", isLive: true, range: () => ({ from: 0, to: 1 }) },
  { fits: /^dynamics\.contact_time$/, label: "contact time", range: (value) => ({ from: value / 100, to: value * 100, scale: "log" }) },
];

/** Returns the number of a slider. For a vector, this is the length of the vector. */
function sliderValue(toml, path) {
  const value = toml.get(path);
  if (typeof value === "number") {
    return value;
  }
  const parts = sliderVector(toml, path);
  return parts.length > 0 ? Math.hypot(...parts) : undefined;
}

function sliderVector(toml, path) {
  const parts = [];
  while (typeof toml.get(`${path}.${parts.length}`) === "number") {
    parts.push(toml.get(`${path}.${parts.length}`));
  }
  return parts;
}

/**
 * Returns a value as written in the scene. A vector keeps its direction. A zero vector takes the last direction of the
 * slider, or points down.
 */
function sliderText(toml, slider, value) {
  const parts = sliderVector(toml, slider.key);
  if (parts.length === 0) {
    return tomlNumber(value, slider.isInteger);
  }
  const length = Math.hypot(...parts);
  const direction = length > 0 ? parts.map((part) => part / length) : slider.direction ?? parts.map((_, axis) => (axis === parts.length - 1 ? -1 : 0));
  slider.direction = direction;
  return `[${direction.map((part) => tomlNumber(Number((part * value).toPrecision(6)) + 0)).join(", ")}]`;
}

/** Returns the name of the object with a key. The name is empty if it is not needed. */
function sliderOwner(toml, path) {
  const [table, index] = path.split(".");
  if (table === "space") {
    const [, axis, side] = path.split(".");
    return side === "lower" || side === "upper" ? `${axis} ${side}` : axis;
  }
  if (!(toml.count(table) > 1)) {
    return "";
  }
  const place = `${table}.${index}`;
  const named = [toml.get(`${place}.name`), toml.get(`${place}.species`), [0, 1].map((k) => toml.get(`${place}.species.${k}`)).filter(Boolean).join("–")];
  return named.find((name) => typeof name === "string" && name !== "") ?? index;
}

/** Returns sliders for interactions without a restitution, whose contacts are elastic. */
function absentRestitution(toml) {
  const order = SLIDER_RULES.findIndex(({ fits }) => fits.test("interaction.0.restitution"));
  const found = [];
  for (let index = 0; index < toml.count("interaction"); index += 1) {
    const key = `interaction.${index}.restitution`;
    const hasCore = ["hard-sphere", "square-well", "square-shoulder"].includes(toml.get(`interaction.${index}.potential`));
    if (hasCore && !toml.find(key) && toml.get(`interaction.${index}.name`) === undefined) {
      const owner = sliderOwner(toml, key);
      const label = `restitution${owner ? `, ${owner}` : ""}`;
      found.push({ order, slider: { key, label, from: 0, to: 1, scale: "linear", unit: "", isLive: true, standard: 1 } });
    }
  }
  return found;
}

function derivedSliders(toml) {
  const found = [];
  SLIDER_RULES.forEach((rule, order) => {
    for (const { path: steps } of toml.entries.values()) {
      const path = steps.join(".");
      if (typeof steps.at(-1) === "number") {
        continue;
      }
      const match = path.match(rule.fits);
      const value = match ? sliderValue(toml, path) : undefined;
      if (value === undefined || !Number.isFinite(value) || (rule.range(value, toml, match).scale === "log" && value <= 0)) {
        continue;
      }
      const owner = sliderOwner(toml, path);
      const { from, to, scale = "linear" } = rule.range(value, toml, match);
      const label = rule.label + (owner ? `, ${owner}` : "");
      found.push({ order, slider: { key: path, label, from, to, scale, unit: "", isLive: rule.isLive, isInteger: rule.isInteger } });
    }
  });
  found.push(...absentRestitution(toml));
  return found.sort((one, other) => one.order - other.order).slice(0, SLIDER_COUNT).map(({ slider }) => slider);
}

function namedSliders(sliders, schema) {
  const isOwn = ({ key, from, to }) => typeof key === "string" && Number.isFinite(from) && Number.isFinite(to) && from < to;
  return sliders.filter(isOwn).map((slider) => {
    const rule = SLIDER_RULES.find(({ fits }) => fits.test(slider.key));
    const path = slider.key.split(".").map((step) => (/^\d+$/.test(step) ? Number(step) : step));
    const isInteger = schema?.at(path).some(({ type }) => type === "integer") ?? false;
    const scale = slider.scale === "log" && slider.from > 0 ? "log" : "linear";
    return { ...slider, label: slider.label ?? rule?.label ?? slider.key, unit: slider.unit ?? "", scale, isLive: rule?.isLive, isInteger };
  });
}

/** Converts between positions of a slider and values with few digits. */
class SliderScale {
  constructor({ from, to, scale, isInteger }) {
    Object.assign(this, { from, to, isLog: scale === "log", isInteger });
    const raw = (to - from) / 250;
    const unit = 10 ** Math.floor(Math.log10(raw));
    this.step = [1, 2, 5, 10].map((k) => k * unit).find((step) => step >= raw * 0.999);
    // Two steps of an integer differ by at least 1.
    const most = isInteger ? Math.max(1, Math.floor(Math.log(to / from) / Math.log1p(1 / from))) : SLIDER_STEPS;
    this.steps = this.isLog ? Math.min(SLIDER_STEPS, most) : Math.max(1, Math.round((to - from) / this.step));
  }

  value(place) {
    if (this.isLog) {
      const value = this.from * (this.to / this.from) ** (place / this.steps);
      return this.isInteger ? Math.max(1, Math.round(value)) : Number(value.toPrecision(3));
    }
    const value = place >= this.steps ? this.to : this.from + place * this.step;
    return this.isInteger ? Math.round(value) : Number(value.toPrecision(6));
  }

  place(value) {
    const place = this.isLog ? (Math.log(value / this.from) / Math.log(this.to / this.from)) * this.steps : (value - this.from) / this.step;
    return Math.min(Math.max(Math.round(place), 0), this.steps);
  }
}

/** `moved(slider, written)` is called when a slider moves. `written(toml)` returns the new value as text. */
class SliderSet {
  constructor(container, named, moved, schema) {
    this.container = container;
    this.named = named;
    this.moved = moved;
    this.schema = schema;
    this.rows = [];
    this.first = new Map();
  }

  /** Shows the values in a text. Builds new sliders if keys or labels have changed. */
  follow(toml) {
    const sliders = this.named?.length > 0 ? namedSliders(this.named, this.schema) : derivedSliders(toml);
    const keys = JSON.stringify(sliders.map(({ key, label }) => [key, label]));
    if (keys !== this.keys) {
      this.keys = keys;
      this.build(sliders);
    }
    for (const row of this.rows) {
      const value = sliderValue(toml, row.slider.key) ?? row.slider.standard;
      if (!this.first.has(row.slider.key)) {
        this.first.set(row.slider.key, value);
      }
      this.show(row, value);
    }
  }

  /** A reset will restore the values that are shown next. */
  settle() {
    this.first.clear();
    this.keys = "";
  }

  build(sliders) {
    this.container.replaceChildren();
    this.container.hidden = sliders.length === 0;
    this.rows = sliders.map((slider, index) => this.row(slider, index));
  }

  row(slider, index) {
    const make = (name, className, parent, words = "") => {
      const node = document.createElement(name);
      node.className = className;
      node.textContent = words;
      parent.append(node);
      return node;
    };
    const box = make("div", "slider", this.container);
    const label = make("label", "slider-label", box, slider.label);
    const reset = make("button", "slider-reset", box, "↺");
    const output = make("output", "slider-value", box);
    const input = make("input", "slider-input", box);
    const scale = new SliderScale(slider);
    input.id = `slider-${index}`;
    Object.assign(input, { type: "range", min: "0", max: String(scale.steps), step: "1" });
    label.htmlFor = input.id;
    output.htmlFor = input.id;
    reset.type = "button";
    reset.title = "Back to the value of the scene (or double click)";
    reset.setAttribute("aria-label", `Reset ${slider.label}`);
    input.title = `${slider.key}: ${slider.isLive ? "changes while it runs" : "starts the scene again"}`;
    const row = { slider, scale, input, output, reset };
    input.addEventListener("input", () => this.move(row, scale.value(Number(input.value))));
    const back = () => {
      const value = this.first.get(slider.key);
      if (value !== undefined && value !== row.value) {
        this.move(row, value);
      }
    };
    input.addEventListener("dblclick", back);
    reset.addEventListener("click", () => {
      back();
      input.focus();
    });
    return row;
  }

  move(row, value) {
    this.show(row, value);
    this.moved(row.slider, (toml) => sliderText(toml, row.slider, value));
  }

  show(row, value) {
    const { scale, input, output, reset, slider } = row;
    row.value = value;
    const words = value === undefined ? "–" : `${Number(value.toPrecision(4))}${slider.unit && slider.unit !== "1" ? ` ${slider.unit}` : ""}`;
    if (value !== undefined && scale.value(Number(input.value)) !== value) {
      input.value = String(scale.place(value));
    }
    output.textContent = words;
    input.setAttribute("aria-valuetext", words);
    reset.hidden = value === this.first.get(slider.key) || this.first.get(slider.key) === undefined;
  }
}
