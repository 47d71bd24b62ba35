const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

/** Replaces an exponent such as `e-5` by a power of ten. */
function plainNumber(text) {
  const [digits, exponent] = text.split("e");
  const plain = digits.replace("-", "−");
  return exponent ? `${plain}×10${[...String(Number(exponent))].map((digit) => RAISED[digit]).join("")}` : plain;
}

/** Returns a value with four digits. */
function plotValue(value) {
  if (!Number.isFinite(value)) {
    return "–";
  }
  const size = Math.abs(value);
  return plainNumber(size === 0 || (size >= 1e-3 && size < 1e6) ? String(Number(value.toPrecision(4))) : value.toExponential(3));
}

/** A linear or logarithmic axis in pixels. Its limits stay while the data fit and fill most of it. */
class PlotAxis {
  constructor() {
    this.low = NaN;
    this.high = NaN;
    this.isLogarithmic = false;
  }

  /** Returns a step of 1, 2 or 5 times a power of ten, for about `number` steps. */
  static step(span, number) {
    const raw = span / number;
    const power = 10 ** Math.floor(Math.log10(raw));
    return power * ([1, 2, 5, 10].find((factor) => factor * power >= raw * (1 - 1e-9)) ?? 10);
  }

  /**
   * Fits the axis to a range of values. If a limit is `kept`, it is exact. If the axis `grows`, it leaves room for
   * later values.
   */
  show([low, high], { isLogarithmic = false, kept = [false, false], grows = false, fills = 0.5 } = {}) {
    if (isLogarithmic !== this.isLogarithmic) {
      [this.low, this.high] = [NaN, NaN];
      this.isLogarithmic = isLogarithmic;
    }
    const [from, to] = isLogarithmic ? [Math.log10(low), Math.log10(high)] : [low, high];
    const smallest = isLogarithmic ? 0.5 : 0.1 * Math.max(Math.abs(from), Math.abs(to)) || 1;
    const least = kept[0] ? from : Math.min(from, 0.5 * (from + to - smallest));
    const most = kept[1] ? to : Math.max(to, 0.5 * (from + to + smallest));
    const isIn = from >= this.low && to <= this.high && (!kept[0] || this.low === least) && (!kept[1] || this.high === most);
    if (isIn && most - least >= fills * (this.high - this.low)) {
      return;
    }
    const span = most - least;
    const step = PlotAxis.step(span, 10);
    const room = isLogarithmic ? 0.06 * span : 0;
    const down = isLogarithmic ? least - room : Math.floor(least / step - 0.2) * step;
    const up = isLogarithmic ? most + room : Math.ceil(most / step + 0.2) * step;
    // The axis of a quantity that is never negative does not extend below zero.
    this.low = kept[0] ? least : !isLogarithmic && from >= 0 ? Math.max(0, down) : down;
    this.high = kept[1] ? most : grows ? Math.ceil((least + 1.25 * span) / step) * step : up;
  }

  between(from, to) {
    [this.from, this.to] = [from, to];
    this.factor = (to - from) / (this.high - this.low);
  }

  hasPlace(value) {
    return Number.isFinite(value) && (!this.isLogarithmic || value > 0);
  }

  place(value) {
    return this.from + ((this.isLogarithmic ? Math.log10(value) : value) - this.low) * this.factor;
  }

  value(place) {
    const at = this.low + (place - this.from) / this.factor;
    return this.isLogarithmic ? 10 ** at : at;
  }

  marks(number) {
    return this.isLogarithmic ? this.decades() : this.steps(number);
  }

  steps(number) {
    const step = PlotAxis.step(this.high - this.low, number);
    const first = Math.ceil(this.low / step - 1e-9);
    const count = Math.floor(this.high / step + 1e-9) - first + 1;
    return Array.from({ length: Math.min(count, 30) }, (_, k) => ({
      value: (first + k) * step,
      label: this.label((first + k) * step, step),
    }));
  }

  label(value, step) {
    if (Math.abs(value) < 1e-9 * step) {
      return "0";
    }
    const largest = Math.max(Math.abs(this.low), Math.abs(this.high));
    const exponent = Math.floor(Math.log10(step) + 1e-9);
    if (largest >= 1e-3 && largest < 1e5 && exponent > -7) {
      return plainNumber(value.toFixed(Math.max(0, -exponent)));
    }
    const power = Math.floor(Math.log10(largest));
    const digits = Math.min(Math.max(power - exponent, 0), 6);
    return plainNumber(`${(value / 10 ** power).toFixed(digits)}e${power}`);
  }

  decades() {
    const number = this.high - this.low;
    const stride = Math.max(1, Math.ceil(number / 6));
    const marks = [];
    for (let decade = Math.floor(this.low); decade <= Math.ceil(this.high); decade += 1) {
      for (let digit = 1; digit < 10; digit += 1) {
        const value = Number(`${digit}e${decade}`);
        const isLabelled = digit === 1 ? decade % stride === 0 : number < 1.6 && (digit === 2 || digit === 5);
        const at = Math.log10(value);
        if (at >= this.low - 1e-9 && at <= this.high + 1e-9 && (isLabelled || number < 7 || digit === 1)) {
          const isShort = value >= 0.01 && value < 1000;
          marks.push({
            value,
            label: !isLabelled
              ? undefined
              : isShort
                ? String(Number(value.toPrecision(1)))
                : `${digit === 1 ? "" : `${digit}×`}10${[...String(decade)].map((c) => RAISED[c]).join("")}`,
          });
        }
      }
    }
    return marks;
  }
}
