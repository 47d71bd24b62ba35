/** A figure with a plot. It shows the value at the pointer, and saves the plot as a file. */
class Figure {
  /** Largest distance from the pointer to the point whose value is shown `[pixels of the plot]`. */
  static REACH = 40;

  constructor(element) {
    this.element = element;
    this.plot = element.querySelector('svg.plot');
    this.title = element.querySelector('h4').textContent;
    const values = element.querySelector('script.values');
    this.addTools();
    if (values) {
      this.values = JSON.parse(values.textContent);
      this.points = this.values.lines.flatMap((line, number) => line.x.map((x, at) => ({ line, number, at, place: this.place(line, at) })));
      this.listen();
    }
  }

  /** Returns the position of a point in the plot `[pixels]`. */
  place(line, at) {
    return [line.x[at], line.y[at]].map((value, k) => {
      const { isLogarithmic, ends: [low, high, from, to] } = this.values.axes[k];
      return from + ((isLogarithmic ? Math.log10(value) : value) - low) / (high - low) * (to - from);
    });
  }

  addTools() {
    const stage = document.createElement('div');
    stage.className = 'plot-stage';
    this.plot.replaceWith(stage);
    this.note = document.createElement('output');
    this.note.className = 'value';
    this.note.hidden = true;
    const button = document.createElement('button');
    button.type = 'button';
    button.className = 'save';
    button.textContent = '↓ SVG';
    button.title = 'Save this plot as a file';
    button.setAttribute('aria-label', `Save the plot “${this.title}” as SVG`);
    button.addEventListener('click', () => this.save());
    stage.append(this.plot, button, this.note);
  }

  listen() {
    this.spot = document.createElementNS(this.plot.namespaceURI, 'circle');
    this.spot.setAttribute('class', 'spot');
    this.spot.setAttribute('r', '5.5');
    this.plot.tabIndex = 0;
    this.plot.addEventListener('pointermove', (event) => this.point(event));
    this.plot.addEventListener('pointerdown', (event) => this.point(event));
    this.plot.addEventListener('pointerleave', (event) => event.pointerType === 'mouse' && this.leave());
    this.plot.addEventListener('blur', () => this.leave());
    this.plot.addEventListener('keydown', (event) => this.key(event));
  }

  point(event) {
    const box = this.plot.getBoundingClientRect();
    const scale = this.plot.viewBox.baseVal.width / box.width;
    const [x, y] = [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
    const distance = ({ place }) => Math.hypot(place[0] - x, place[1] - y);
    let [nearest, least] = [undefined, Figure.REACH];
    for (const point of this.points) {
      const far = distance(point);
      if (far < least) [nearest, least] = [point, far];
    }
    if (nearest) this.show(nearest); else this.leave();
  }

  /** The left and right keys move along a line. The up and down keys change the line. */
  key(event) {
    const along = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    const across = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (event.key === 'Escape') return this.leave();
    if (!(along || across) || !this.points.length) return undefined;
    event.preventDefault();
    if (!this.shown) return this.show(this.points[0]);
    if (along) {
      const next = this.points[this.points.indexOf(this.shown) + along];
      return next && next.line === this.shown.line ? this.show(next) : undefined;
    }
    const others = this.points.filter((point) => point.number === this.shown.number + across);
    const far = (point) => Math.abs(point.place[0] - this.shown.place[0]);
    return others.length ? this.show(others.reduce((best, point) => far(point) < far(best) ? point : best)) : undefined;
  }

  show(point) {
    const { line, at, place } = point;
    this.shown = point;
    const [x, y, cells] = this.values.axes.map((axis) => axis.title);
    const error = line.errors?.[at];
    const measured = (line.cells ?? line.y)[at];
    const value = error > 0 ? Figure.estimate(measured, error) : Figure.digits(measured);
    const deviation = line.deviations?.[at];
    const rows = [line.label, `${x}: ${Figure.digits(line.x[at])}`];
    if (line.cells) rows.push(`${y}: ${Figure.digits(line.y[at])}`);
    rows.push(`${line.cells ? cells : y}: ${value}`);
    if (typeof deviation === 'number') rows.push(`Δ / σ: ${Figure.digits(deviation, 3)}`);
    this.note.textContent = rows.filter((row) => row).join('\n');
    this.note.hidden = false;
    // The note is beside the point, on the side with more space.
    const scale = this.plot.clientWidth / this.plot.viewBox.baseVal.width;
    const [left, top] = place.map((coordinate) => coordinate * scale);
    const [room, width] = [this.plot.clientWidth, this.note.offsetWidth];
    const beside = left > 0.55 * room ? left - width - 14 : left + 14;
    this.note.style.left = `${Math.max(0, Math.min(beside, room - width))}px`;
    this.note.style.top = `${top + (width + 28 > room - left && width + 28 > left ? 40 : 0)}px`;
    this.spot.setAttribute('cx', place[0]);
    this.spot.setAttribute('cy', place[1]);
    this.plot.append(this.spot);
  }

  leave() {
    this.shown = undefined;
    this.note.hidden = true;
    this.spot?.remove();
  }

  /** Formats a number with true minus signs and raised exponents. */
  static sign(text) {
    const [digits, exponent] = text.replaceAll('-', '−').split('e');
    if (!exponent) return digits;
    const raised = [...exponent.replace('+', '')].map((letter) => letter === '−' ? '⁻' : '⁰¹²³⁴⁵⁶⁷⁸⁹'[Number(letter)]);
    return `${digits}×10${raised.join('')}`;
  }

  static digits(value, count = 5) {
    return Figure.sign(String(Number(value.toPrecision(count))));
  }

  /** Formats a value with two digits of its error. */
  static estimate(value, error) {
    const decimals = 1 - Math.floor(Math.log10(error));
    if (decimals < 0 || decimals > 8) return `${Figure.digits(value)} ± ${Figure.digits(error, 2)}`;
    return `${Figure.sign(value.toFixed(decimals))} ± ${error.toFixed(decimals)}`;
  }

  save() {
    this.leave();
    const name = this.title.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, '_').replace(/^_+|_+$/g, '') || 'plot';
    saveFile(`${name}.svg`, 'image/svg+xml', this.file());
  }

  file() {
    const image = Figure.styled(this.plot);
    const { width, height } = this.plot.viewBox.baseVal;
    const entries = [...this.element.querySelectorAll('.legend li')];
    const [top, row] = [30, 19];
    const whole = top + height + row * entries.length + (entries.length ? 6 : 0);
    const { color, backgroundColor, fontFamily } = getComputedStyle(document.documentElement);
    const create = (name, attributes, text = '') => {
      const element = document.createElementNS(this.plot.namespaceURI, name);
      for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
      element.textContent = text;
      return element;
    };
    const file = create('svg', { viewBox: `0 0 ${width} ${whole}`, width, height: whole, 'font-family': fontFamily });
    file.append(create('rect', { width, height: whole, fill: backgroundColor }));
    file.append(create('text', { x: 12, y: 20, 'font-size': 15, 'font-weight': 600, fill: color }, this.title));
    for (const [key, value] of Object.entries({ y: top, width, height })) image.setAttribute(key, value);
    file.append(image);
    entries.forEach((entry, number) => {
      const y = top + height + row * number;
      const sample = Figure.styled(entry.querySelector('svg'));
      for (const [key, value] of Object.entries({ x: 90, y: y + 3, width: 26, height: 10 })) sample.setAttribute(key, value);
      file.append(sample, create('text', { x: 124, y: y + 13, 'font-size': 13, fill: color }, entry.textContent));
    });
    return `<?xml version="1.0" encoding="UTF-8"?>\n${new XMLSerializer().serializeToString(file)}\n`;
  }

  /** Returns a copy of an element with the styles of the page as attributes. */
  static styled(element) {
    const names = ['fill', 'stroke', 'stroke-width', 'stroke-dasharray', 'stroke-linejoin', 'opacity', 'font-size', 'shape-rendering'];
    const copy = element.cloneNode(true);
    const [own, copies] = [element, copy].map((root) => [...root.querySelectorAll('*')]);
    own.forEach((from, at) => {
      const style = getComputedStyle(from);
      const to = copies[at];
      to.removeAttribute('class');
      if (from.children.length && from.localName !== 'text') return;
      for (const name of names) {
        const value = style.getPropertyValue(name);
        const isText = from.localName === 'text';
        if ((name === 'font-size') === isText || (isText && name === 'fill')) to.setAttribute(name, value);
      }
    });
    for (const name of ['class', 'style', 'tabindex']) copy.removeAttribute(name);
    return copy;
  }
}

for (const element of document.querySelectorAll('figure')) {
  if (element.querySelector('svg.plot')) new Figure(element);
}

/** Folded parts of the page are open in print. */
const folded = [];
addEventListener('beforeprint', () => {
  for (const details of document.querySelectorAll('details:not([open])')) {
    details.open = true;
    folded.push(details);
  }
});
addEventListener('afterprint', () => {
  while (folded.length) folded.pop().open = false;
});
