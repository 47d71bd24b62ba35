// Parser of TOML for the editor. It accepts any text, because the engine reports errors.

/** Kind of a piece by its first character. Other characters begin words. */
const TOML_KINDS = {
  " ": "space", "\t": "space", "\r": "space", "\n": "newline", "#": "comment", '"': "string", "'": "string",
  "[": "mark", "]": "mark", "{": "mark", "}": "mark", "=": "mark", ",": "mark", ".": "mark",
};

const TOML_PIECES = {
  space: /[ \t\r]+/y,
  newline: /\n/y,
  comment: /[^\n]*/y,
  string: /"""[^]*?(?:"""(?!")|$)|'''[^]*?(?:'''(?!')|$)|"(?:[^"\\\n]|\\[^\n])*(?:"|(?=\n)|\\?$)|'[^'\n]*(?:'|(?=\n)|$)/y,
  mark: /\[\[|\]\]|[^]/y,
  word: /[^\s#"'[\]{}=,]+/y,
};

const TOML_NUMBER = /^[+-]?(?:inf|nan|\d[\d_]*(?:\.\d[\d_]*)?(?:[eE][+-]?\d[\d_]*)?|0x[\da-fA-F_]+|0o[0-7_]+|0b[01_]+)$/;

const TOML_HEADER = /\[\[?[A-Za-z_][\w-]*(?:\.[\w-]+)*\]\]?[ \t]*(?:#[^\n]*)?(?:\n|$)/y;

/** Largest nesting depth. Deeper content is a single value. */
const TOML_DEPTH = 32;

function tomlScalar(raw) {
  if (TOML_NUMBER.test(raw)) {
    const plain = raw.replaceAll("_", "");
    const sign = plain.startsWith("-") ? -1 : 1;
    const digits = plain.replace(/^[+-]/, "");
    return digits === "inf" ? sign * Infinity : digits === "nan" ? NaN : sign * Number(digits);
  }
  if (raw === "true" || raw === "false") {
    return raw === "true";
  }
  if (/^'[^']*'$/.test(raw)) {
    return raw.slice(1, -1);
  }
  if (/^"(?:[^"\\]|\\.)*"$/.test(raw)) {
    try {
      return JSON.parse(raw);
    } catch {
      return raw.slice(1, -1);
    }
  }
  return undefined;
}

function tomlNumber(value, isInteger = false) {
  if (!Number.isFinite(value)) {
    return Number.isNaN(value) ? "nan" : value > 0 ? "inf" : "-inf";
  }
  const written = String(isInteger ? Math.round(value) : value).replace("e+", "e");
  return isInteger || /[.e]/.test(written) ? written : `${written}.0`;
}

class Toml {
  /**
   * `tokens`: `[kind, start, end]`. The kinds are comment, table, key, string, number, constant and error.
   * `tables`: `{at, isArray, start, end, last}`. `at` is the path with indices. The header extends from `start` to
   * `end`, and the entries below it to `last`.
   * `place`: `{path, role}` at the end of the text. `path` is the enclosing table or value, and `role` the expected
   * content: key, value or header.
   * `entries`: `{path, keyStart, start, end, value}` by path, such as "fill.0.temperature". The value extends from
   * `start` to `end`.
   */
  constructor(text) {
    this.text = text;
    this.tokens = [];
    this.tables = [{ at: [], isArray: false, start: 0, end: 0, last: 0 }];
    this.entries = new Map();
    this.counts = new Map();
    this.place = { path: [], role: "key" };
    this.at = 0;
    this.next();
    while (this.kind) {
      this.line();
    }
  }

  /** Reads the next piece that is not a space. `kind` is empty at the end. */
  next() {
    do {
      this.start = this.at;
      this.kind = this.at < this.text.length ? TOML_KINDS[this.text[this.at]] ?? "word" : "";
      if (this.kind) {
        const pattern = TOML_PIECES[this.kind];
        pattern.lastIndex = this.at;
        // Unusual spaces match no pattern, nor do strings that end in a backslash.
        this.at = pattern.test(this.text) ? pattern.lastIndex : this.at + 1;
      }
    } while (this.kind === "space");
    this.piece = this.text.slice(this.start, this.at);
  }

  is(mark) {
    return this.kind === "mark" && this.piece === mark;
  }

  token(kind, start = this.start, end = this.at) {
    this.tokens.push([kind, start, end]);
  }

  /** Splits a mark of two brackets. */
  half() {
    if (this.kind === "mark" && this.piece.length === 2) {
      this.piece = this.piece[0];
      this.at = this.start + 1;
    }
  }

  line() {
    this.place = { path: this.tables.at(-1).at, role: "key" };
    if (this.kind === "newline") {
      this.next();
    } else if (this.kind === "comment") {
      this.token("comment");
      this.next();
    } else if (this.is("[[") || this.is("[")) {
      this.header();
      this.rest();
    } else {
      this.pair(this.tables.at(-1).at, 0);
      this.rest();
    }
  }

  /** Reads to the end of the line. Only a comment is valid there. */
  rest() {
    while (this.kind && this.kind !== "newline" && !this.isHeader()) {
      this.token(this.kind === "comment" ? "comment" : "error");
      this.next();
    }
  }

  keys(kind) {
    const keys = [];
    const first = this.start;
    let end = this.start;
    while (this.kind === "word" || this.kind === "string" || this.is(".")) {
      if (this.kind === "string") {
        keys.push(String(tomlScalar(this.piece) ?? this.piece));
      } else if (this.kind === "word") {
        keys.push(...this.piece.split(".").filter((key) => key !== ""));
      }
      end = this.at;
      this.next();
    }
    if (end > first) {
      this.token(kind, first, end);
    }
    return { keys, first, end };
  }

  header() {
    const isArray = this.is("[[");
    const start = this.start;
    this.next();
    const { keys } = this.keys("table");
    this.place = { path: keys, role: "header" };
    const close = isArray ? "]]" : "]";
    let end = this.start;
    if (this.is(close)) {
      end = this.at;
      this.next();
    }
    this.tables.push({ at: this.resolved(keys, isArray), isArray, start, end, last: end });
  }

  /** Returns the path of a header with the indices in arrays of tables. */
  resolved(keys, isArray) {
    const path = [];
    keys.forEach((key, depth) => {
      path.push(key);
      const name = path.join("\0");
      const isLast = depth === keys.length - 1;
      if (isLast && isArray) {
        this.counts.set(name, (this.counts.get(name) ?? -1) + 1);
      }
      if (this.counts.has(name)) {
        path.push(this.counts.get(name));
      }
    });
    return path;
  }

  pair(prefix, depth) {
    const { keys, first } = this.keys("key");
    if (keys.length === 0) {
      this.token("error");
      this.next();
      return;
    }
    if (!this.is("=")) {
      return;
    }
    this.next();
    const path = [...prefix, ...keys];
    this.place = { path, role: "value" };
    this.value(path, first, depth);
    if (depth === 0) {
      this.tables.at(-1).last = Math.max(this.tables.at(-1).last, this.entries.get(path.join("."))?.end ?? 0);
    }
  }

  value(path, keyStart, depth) {
    this.half();
    const start = this.start;
    let end = this.at;
    let value;
    if (this.is("[") && depth < TOML_DEPTH) {
      end = this.array(path, depth);
    } else if (this.is("{") && depth < TOML_DEPTH) {
      end = this.braces(path, depth);
    } else if (this.kind === "word" || this.kind === "string") {
      value = tomlScalar(this.piece);
      const kind = this.kind === "string" ? "string" : { number: "number", boolean: "constant" }[typeof value] ?? "error";
      this.token(kind);
      this.next();
    } else {
      if (this.kind && this.kind !== "newline" && this.kind !== "comment") {
        this.token("error");
        this.next();
      }
      return;
    }
    this.entries.set(path.join("."), { path, keyStart, start, end, value });
  }

  /** Skips separators, line ends and comments between elements. Returns false at the end of the text. */
  between(place) {
    if (this.kind) {
      this.place = place();
    }
    while (this.kind === "newline" || this.kind === "comment" || this.is(",")) {
      if (this.kind === "comment") {
        this.token("comment");
      }
      this.next();
    }
    return this.kind !== "";
  }

  array(path, depth) {
    this.place = { path: [...path, 0], role: "value" };
    this.next();
    let index = 0;
    while (this.between(() => ({ path: [...path, index], role: "value" }))) {
      if (this.kind === "mark" && this.piece === "]]") {
        this.half();
      }
      const end = this.at;
      if (this.is("]")) {
        this.next();
        return end;
      }
      if (this.isHeader()) {
        return this.start;
      }
      this.value([...path, index], this.start, depth + 1);
      index += 1;
    }
    return this.text.length;
  }

  /** Returns whether a header begins inside an open bracket or brace. Parsing then continues with the header. */
  isHeader() {
    TOML_HEADER.lastIndex = this.start;
    return TOML_HEADER.test(this.text) && /(?:^|\n)[ \t]*$/.test(this.text.slice(Math.max(0, this.start - 80), this.start));
  }

  braces(path, depth) {
    this.place = { path, role: "key" };
    this.next();
    while (this.between(() => ({ path, role: "key" }))) {
      const end = this.at;
      if (this.is("}")) {
        this.next();
        return end;
      }
      if (this.isHeader()) {
        return this.start;
      }
      this.pair(path, depth + 1);
    }
    return this.text.length;
  }

  /** Returns the entry at a path, such as `fill.0.temperature` or `species.disk.mass`. */
  find(path) {
    return this.entries.get(path) ?? this.entries.get(this.numbered(path));
  }

  get(path) {
    return this.find(path)?.value;
  }

  /** Replaces names in a path by indices. */
  numbered(path) {
    const steps = [];
    for (const step of path.split(".")) {
      const place = steps.join(".");
      const isNamed = ({ path: at, value }) =>
        value === step && at.length === steps.length + 2 && at.at(-1) === "name" && at.slice(0, -2).join(".") === place && Number.isInteger(at.at(-2));
      const isPlain = /^\d+$/.test(step) || steps.length === 0;
      const named = isPlain ? undefined : [...this.entries.values()].find(isNamed);
      steps.push(named ? named.path.at(-2) : step);
    }
    return steps.join(".");
  }

  count(name) {
    return (this.counts.get(name) ?? -1) + 1;
  }

  /** Returns the change that sets a value, `{start, end, insert}`, or undefined if the table is missing. */
  edit(path, value) {
    const found = this.find(path);
    if (found) {
      return { start: found.start, end: found.end, insert: value };
    }
    const steps = this.numbered(path).split(".");
    for (let length = steps.length - 1; length >= 0; length -= 1) {
      const place = steps.slice(0, length).join(".");
      const rest = steps.slice(length).join(".");
      if (/(?:^|\.)\d+(?:\.|$)/.test(rest)) {
        continue;
      }
      const inline = length > 0 ? this.find(place) : undefined;
      if (inline && this.text[inline.start] === "{") {
        const isEmpty = this.text.slice(inline.start + 1, inline.end - 1).trim() === "";
        return { start: inline.start + 1, end: inline.start + 1, insert: ` ${rest} = ${value}${isEmpty ? " " : ","}` };
      }
      const table = this.tables.findLast((one) => one.at.join(".") === place);
      if (table) {
        return this.insertion(table, `${rest} = ${value}`);
      }
    }
    return undefined;
  }

  /** Returns the change that adds a line to a table. The first key of the scene itself precedes the first table. */
  insertion(table, line) {
    if (table.last > 0) {
      const end = this.text.indexOf("\n", table.last);
      const start = end < 0 ? this.text.length : end;
      return { start, end: start, insert: `\n${line}` };
    }
    const lines = this.text.match(/^(?:#[^\n]*\n)*/)[0].length;
    return { start: lines, end: lines, insert: `${line}\n` };
  }

  with(path, value) {
    const change = this.edit(path, value);
    return change ? this.text.slice(0, change.start) + change.insert + this.text.slice(change.end) : this.text;
  }
}
