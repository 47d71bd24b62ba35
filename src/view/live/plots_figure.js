/**
 * A plot of growing curves, in the style of the report.
 * Lines are {name, x, y, style}. The style is "line", "thin", "dashes" (theory), "steps" (a histogram) or "level"
 * (across the plot). If `time` is true, x is the simulated time. Such plots share a cursor.
 */
class Plot {
  constructor(
    container,
    {
      title,
      term = title,
      xLabel,
      yLabel,
      isLogarithmic = [false, false],
      canBeLogarithmic = [true, true],
      isTime = false,
      hasNote = false,
      onCursor = () => {},
    },
  ) {
    Object.assign(this, {
      title,
      term,
      xLabel,
      yLabel,
      isLogarithmic: [...isLogarithmic],
      canBeLogarithmic,
      isTime,
      hasNote,
      onCursor,
    });
    this.axes = [new PlotAxis(), new PlotAxis()];
    this.lines = [];
    this.groups = [];
    this.signature = "";
    this.at = undefined;
    this.now = undefined;
    this.figure = made("figure", "live-plot", container);
    this.build();
    this.listen();
  }

  build() {
    const head = made("div", "live-plot-head", this.figure);
    made("h4", "", head, this.title).title = this.term;
    const tools = made("span", "live-plot-tools", head);
    this.buttons = ["x", "y"].map((axis, k) => {
      const button = made("button", "", tools, `log ${axis}`);
      button.type = "button";
      button.hidden = !this.canBeLogarithmic[k];
      button.title = `Logarithmic ${axis} axis`;
      button.addEventListener("click", () => {
        this.isLogarithmic[k] = !this.isLogarithmic[k];
        this.isChosen = true;
        this.redraw();
      });
      return button;
    });
    const save = made("button", "", tools, "SVG");
    save.type = "button";
    save.title = "Save this plot";
    save.addEventListener("click", () => this.save());
    this.note = made("p", "live-plot-note", this.figure);
    this.note.hidden = !this.hasNote;
    this.svg = drawn("svg", { class: "plot", role: "img", tabindex: "0", "aria-label": this.term });
    this.figure.append(this.svg);
    this.frame = drawn("svg", {}, this.svg);
    this.field = drawn("svg", {}, this.svg);
    this.over = drawn("svg", { class: "live-plot-over", "aria-hidden": "true" }, this.svg);
    this.hair = drawn("path", { class: "hair" }, this.over);
    this.dots = drawn("g", {}, this.over);
    this.legend = made("ul", "legend", this.figure);
  }

  listen() {
    const { svg } = this;
    const move = (event) => {
      const box = svg.getBoundingClientRect();
      const place = ((event.clientX - box.left) / box.width) * this.width;
      const { left, right } = this.edge;
      this.point(place < left - 4 || place > this.width - right + 4 ? undefined : this.axes[0].value(place));
    };
    svg.addEventListener("pointermove", move);
    svg.addEventListener("pointerdown", move);
    svg.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && this.point(undefined));
    svg.addEventListener("blur", () => this.point(undefined));
    svg.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (event.key === "Escape") {
        this.point(undefined);
      } else if (step && this.lines.length > 0 && !event.ctrlKey && !event.metaKey && !event.altKey) {
        const { left, right } = this.edge;
        const place = this.at === undefined ? this.width - right : this.axes[0].place(this.at) + step * (event.shiftKey ? 20 : 4);
        this.point(this.axes[0].value(Math.min(Math.max(place, left), this.width - right)));
        event.preventDefault();
      }
    });
    this.watch = new ResizeObserver(() => this.redraw());
    this.watch.observe(this.figure);
  }

  remove() {
    this.watch.disconnect();
    this.figure.remove();
  }

  point(x) {
    this.cursor(x);
    this.onCursor(x);
  }

  /**
   * Draws curves. `x` and `y` are fixed ranges, `note` stands beside the title, and `marks` are lines across the plot.
   */
  draw(content) {
    this.content = content;
    this.redraw();
  }

  redraw() {
    const width = Math.round(this.figure.clientWidth);
    if (!this.content || width === 0) {
      return;
    }
    const { lines, note = "", x, y, logarithmic } = this.content;
    if (logarithmic && !this.isChosen) {
      this.isLogarithmic = [...logarithmic];
    }
    this.width = width;
    this.height = Math.round(Math.min(Math.max(0.56 * width, 170), 300));
    this.lines = lines.filter((line) => line.y.length > 0 || line.style === "level");
    if (this.note.textContent !== note) {
      this.note.textContent = note;
    }
    this.buttons.forEach((button, k) => button.setAttribute("aria-pressed", String(this.isLogarithmic[k])));
    this.range(0, x, this.isTime);
    this.range(1, y, false);
    drawPlotFrame(this);
    this.drawLines();
    this.drawLegend();
    this.cursor(this.at);
  }

  /** Fits an axis to the curves. Theory and levels may be clipped. */
  range(k, kept, grows) {
    const isLogarithmic = this.isLogarithmic[k];
    let [low, high] = [Infinity, -Infinity];
    for (const line of this.lines) {
      if (
        line.style === "level" ||
        (k === 1 && line.isCut && !isLogarithmic) ||
        (line.style === "dashes" && this.lines.some((other) => other.style !== "dashes"))
      ) {
        continue;
      }
      for (const value of k === 0 ? line.x : line.y) {
        if (Number.isFinite(value) && (!isLogarithmic || value > 0)) {
          low = value < low ? value : low;
          high = value > high ? value : high;
        }
      }
    }
    if (this.content.include && k === 1 && !isLogarithmic) {
      low = Math.min(low, ...this.content.include);
      high = Math.max(high, ...this.content.include);
    }
    const ends = kept?.map((end, side) => (isLogarithmic && end <= 0 ? undefined : end) ?? [low, high][side]) ?? [low, high];
    if (!(ends[1] >= ends[0])) {
      [ends[0], ends[1]] = [isLogarithmic ? 0.1 : 0, 1];
    }
    const fixed = [0, 1].map((side) => kept?.[side] !== undefined && !(isLogarithmic && kept[side] <= 0) && ends[1] > ends[0]);
    this.axes[k].show(ends, { isLogarithmic, kept: k === 0 && grows ? [true, false] : fixed, grows: grows && !isLogarithmic });
  }

  drawLines() {
    const { lines, groups } = this;
    while (groups.length < lines.length) {
      const group = drawn("g", {}, this.field);
      groups.push({ group, path: drawn("path", {}, group), fill: drawn("path", { class: "band" }, group) });
    }
    groups.splice(lines.length).forEach(({ group }) => group.remove());
    let measured = 0;
    lines.forEach((line, k) => {
      line.className = this.classOf(line, line.style === "dashes" || line.style === "level" ? 0 : measured);
      measured += line.style === "dashes" || line.style === "level" || line.colour !== undefined ? 0 : 1;
      const { group, path, fill } = groups[k];
      const isBand = line.style === "steps" || line.low !== undefined;
      group.setAttribute("class", line.className);
      path.setAttribute("class", line.style === "thin" ? "thin" : line.style === "level" ? "level" : "");
      path.setAttribute(
        "d",
        line.style === "steps"
          ? ""
          : line.style === "level"
            ? `M${this.edge.left} ${this.axes[1].place(line.at).toFixed(1)}H${this.width}`
            : curvePath(line, this.axes),
      );
      fill.setAttribute("d", isBand ? stepsPath(line, this.axes) : "");
    });
    const marks = (this.isTime ? (this.content.marks ?? []) : []).filter(({ time }) => this.axes[0].hasPlace(time));
    const path = marks.map(({ time }) => `M${this.axes[0].place(time).toFixed(1)} 0V${this.height}`).join("");
    this.marks ??= drawn("path", { class: "level" }, this.field);
    this.marks.setAttribute("d", path);
  }

  classOf({ style, colour }, number) {
    return style === "dashes" ? `published p${colour ?? 0}` : style === "level" ? "" : `s${(colour ?? number) % 8}`;
  }

  drawLegend() {
    const named = this.lines.filter(({ name, style }) => name && style !== "level");
    const signature = named.map(({ name, className, style }) => `${name}|${className}|${style}`).join();
    if (signature === this.legendSignature) {
      return;
    }
    this.legendSignature = signature;
    this.values = named.map((line) => {
      const item = document.createElement("li");
      const sample = drawn("svg", { class: "sample", viewBox: "0 0 26 10", "aria-hidden": "true" });
      const group = drawn("g", { class: line.className }, sample);
      drawn("path", line.style === "steps" ? { class: "band", d: "M0 1H26V9H0Z" } : { d: "M0 5H26" }, group);
      item.append(sample, line.name, " ");
      const value = made("b", "", item);
      return { item, value, name: line.name };
    });
    this.legend.replaceChildren(...this.values.map(({ item }) => item));
  }

  /** Shows the values at x in the legend, and a line across the plot. Without x, shows the last values. */
  cursor(x) {
    this.at = x;
    const isThere = x !== undefined && this.lines.length > 0 && this.axes[0].hasPlace(x);
    const { top, bottom } = PLOT_EDGE;
    const place = isThere ? this.axes[0].place(x) : NaN;
    const isIn = isThere && place >= this.edge.left - 1 && place <= this.width - PLOT_EDGE.right + 1;
    this.hair.setAttribute("d", isIn ? `M${place.toFixed(1)} ${top}V${this.height - bottom}` : "");
    const dots = [];
    // Tiny values are round-off, and are shown as zero.
    const [, up] = this.axes;
    const least = up.isLogarithmic ? 0 : 1e-9 * (up.high - up.low);
    for (const { name, value } of this.values ?? []) {
      const line = this.lines.find((one) => one.name === name);
      const isLast = !isIn && (this.isTime || this.content.hasLast) && line?.style !== "dashes";
      const [left, seen] =
        line && isIn ? valueAt(line, x) : line && isLast ? [line.x, line.y].map((values) => values[values.length - 1]) : [];
      const words = seen === undefined ? "" : plotValue(Math.abs(seen) < least ? 0 : seen);
      if (value.textContent !== words) {
        value.textContent = words;
      }
      if (seen !== undefined && line.style !== "steps" && this.axes[0].hasPlace(left) && up.hasPlace(seen)) {
        dots.push(`${line.className}|${this.axes[0].place(left).toFixed(1)}|${up.place(seen).toFixed(1)}`);
      }
    }
    this.place(dots);
    this.tell(isIn ? x : undefined);
  }

  place(dots) {
    const circles = dots.map((dot) => {
      const [name, x, y] = dot.split("|");
      const group = drawn("g", { class: name });
      drawn("circle", { cx: x, cy: y, r: 3 }, group);
      return group;
    });
    this.dots.replaceChildren(...circles);
  }

  tell(x) {
    this.words ??= drawn("text", { class: "hair" }, this.over);
    this.words.textContent = x === undefined ? "" : plotValue(x);
    if (x !== undefined) {
      const place = this.axes[0].place(x);
      const isRight = place > this.width - 80;
      Object.entries({ x: place + (isRight ? -5 : 5), y: PLOT_EDGE.top + 10, "text-anchor": isRight ? "end" : "start" }).forEach(
        ([key, value]) => this.words.setAttribute(key, value),
      );
    }
  }

  save() {
    savePlot(this);
  }
}

/** Interpolates a curve at x. Returns an empty array outside the curve. */
function valueAt({ x: values, y, style, isLoose }, x) {
  let [low, high] = [0, values.length - 1];
  if (isLoose || !(x >= values[low] && x <= values[high])) {
    return [];
  }
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] > x) {
      high = middle;
    } else {
      low = middle;
    }
  }
  const part = values[high] > values[low] ? (x - values[low]) / (values[high] - values[low]) : 0;
  if (style === "steps") {
    return [x, part < 0.5 ? y[low] : y[high]];
  }
  return [x, y[low] + part * (y[high] - y[low])];
}
