// A text area with line numbers, syntax colours and error marks.

const EDITOR_INDENT = "    ";

/** Returns the pieces of each line, `[[kind, from, to], ...]`. A piece that spans several lines is split. */
function linePieces(text, tokens) {
  const lines = text.split("\n");
  const pieces = lines.map(() => []);
  let [line, first] = [0, 0];
  for (const [kind, start, end] of tokens) {
    let from = start;
    while (from < end) {
      while (line < lines.length - 1 && from > first + lines[line].length) {
        first += lines[line].length + 1;
        line += 1;
      }
      const to = Math.min(end, first + lines[line].length);
      if (to > from) {
        pieces[line].push([kind, from - first, to - first]);
      }
      from = to + 1;
    }
  }
  return lines.map((words, index) => ({ words, pieces: pieces[index] }));
}

function proseNodes(words) {
  return words.split(/`([^`]+)`/).map((part, index) => {
    const node = document.createElement(index % 2 ? "code" : "span");
    node.textContent = part;
    return node;
  });
}

class TextEditor {
  constructor(container, text, changed) {
    this.changed = changed;
    this.container = container;
    this.build();
    this.history = new TextHistory(text);
    this.lines = [];
    this.area.value = text;
    this.paint();
    this.listen();
  }

  build() {
    const make = (name, className, parent) => {
      const node = document.createElement(name);
      node.className = className;
      parent.append(node);
      return node;
    };
    this.overlay = make("div", "editor-frame", this.container);
    this.container.prepend(this.overlay);
    this.window = make("div", "editor-window", this.overlay);
    this.sheet = make("div", "editor-sheet", this.window);
    this.numbers = make("div", "editor-numbers", this.sheet);
    this.layers = make("div", "editor-layers", this.sheet);
    this.colours = make("div", "editor-colours", this.layers);
    this.area = make("textarea", "editor-area", this.layers);
    this.numbers.setAttribute("aria-hidden", "true");
    this.colours.setAttribute("aria-hidden", "true");
    const settings = { wrap: "off", spellcheck: "false", autocomplete: "off", autocapitalize: "off", autocorrect: "off", rows: "1" };
    settings["aria-label"] = "Text of the scene";
    Object.entries(settings).forEach(([name, value]) => this.area.setAttribute(name, value));
  }

  listen() {
    const { area } = this;
    area.addEventListener("input", (event) => this.noted(event.inputType?.startsWith("insertText") ? "type" : undefined));
    area.addEventListener("beforeinput", (event) => {
      if (event.inputType === "historyUndo" || event.inputType === "historyRedo") {
        event.preventDefault();
        this.travel(event.inputType === "historyUndo");
      }
    });
    area.addEventListener("keydown", (event) => this.key(event));
    // Only the window scrolls.
    area.addEventListener("scroll", () => area.scrollTo(0, 0));
    new ResizeObserver(() => this.remark()).observe(this.colours);
  }

  get text() {
    return this.area.value;
  }

  /** Changes of the same `kind` may form one undo step. */
  write(text, kind) {
    if (text === this.text) {
      return;
    }
    const { at, removed, inserted } = textChange(this.text, text);
    this.area.setRangeText(inserted, at, at + removed.length, "preserve");
    this.noted(kind);
  }

  replace(start, end, insert, caret = start + insert.length) {
    this.area.setRangeText(insert, start, end, "end");
    this.area.setSelectionRange(caret, caret);
    this.noted();
    this.reveal(caret);
  }

  noted(kind) {
    const change = this.history.note(this.text, kind, kind === "type" ? this.area.selectionEnd : undefined);
    if (change) {
      this.touch(change);
      this.changed(kind);
    }
  }

  travel(isBack) {
    const step = isBack ? this.history.undo() : this.history.redo();
    if (step) {
      this.area.value = step.text;
      this.area.setSelectionRange(step.caret, step.caret);
      this.paint();
      this.reveal(step.caret);
      this.changed("history");
    }
  }

  key(event) {
    const isCommand = event.ctrlKey || event.metaKey;
    const letter = event.key.toLowerCase();
    if (isCommand && !event.altKey && (letter === "z" || letter === "y")) {
      event.preventDefault();
      this.travel(letter === "z" && !event.shiftKey);
    } else if (event.key === "Escape") {
      // After Escape, the Tab key leaves the editor.
      this.isLeaving = true;
      return;
    } else if (event.key === "Tab" && !isCommand && !event.altKey && !this.isLeaving) {
      event.preventDefault();
      this.indent(event.shiftKey);
    } else if (event.key === "Enter" && !isCommand && !event.isComposing) {
      event.preventDefault();
      const { selectionStart: start, selectionEnd: end } = this.area;
      const indent = this.text.slice(this.text.lastIndexOf("\n", start - 1) + 1, start).match(/^[ \t]*/)[0];
      this.replace(start, end, `\n${indent}`);
    }
    this.isLeaving = false;
  }

  indent(isOut) {
    const { selectionStart: start, selectionEnd: end } = this.area;
    if (start === end && !isOut) {
      this.replace(start, end, EDITOR_INDENT);
      return;
    }
    const first = this.text.lastIndexOf("\n", start - 1) + 1;
    const block = this.text.slice(first, end);
    const moved = isOut ? block.replace(/^(?: {1,4}|\t)/gm, "") : block.replace(/^(?=[^\n])/gm, EDITOR_INDENT);
    if (moved !== block) {
      this.replace(first, end, moved);
      this.area.setSelectionRange(start === end ? first + moved.length : first, first + moved.length);
    }
  }

  get toml() {
    if (this.read?.text !== this.text) {
      this.read = new Toml(this.text);
    }
    return this.read;
  }

  /** Colours the whole text. Unchanged lines are not rebuilt. */
  paint() {
    this.lay(0, this.lines.length, linePieces(this.text, this.toml.tokens));
  }

  /** Colours the changed tables. Open quotes or brackets can leave wrong colours until the next `paint`. */
  touch({ at, removed, inserted }) {
    const isHead = ({ pieces: [first] }) => first?.[0] === "table";
    let [line, start] = [0, 0];
    while (line < this.lines.length - 1 && start + this.lines[line].words.length < at) {
      start += this.lines[line].words.length + 1;
      line += 1;
    }
    let [tail, end] = [line, start + this.lines[line].words.length];
    while (tail < this.lines.length - 1 && (end < at + removed.length || !isHead(this.lines[tail + 1]))) {
      tail += 1;
      end += this.lines[tail].words.length + 1;
    }
    // A changed header can affect the table before it.
    while (line > 0) {
      line -= 1;
      start -= this.lines[line].words.length + 1;
      if (isHead(this.lines[line])) {
        break;
      }
    }
    const part = this.text.slice(start, end + inserted.length - removed.length);
    this.lay(line, tail + 1, linePieces(part, new Toml(part).tokens));
  }

  /** Replaces the lines from `from` to `to - 1`. */
  lay(from, to, lines) {
    const isSame = (one, other) => one.words === other.words && one.pieces.length === other.pieces.length
      && one.pieces.every(([kind, start, end], k) => other.pieces[k][0] === kind && other.pieces[k][1] === start && other.pieces[k][2] === end);
    let [head, tail] = [0, 0];
    const most = Math.min(lines.length, to - from);
    while (head < most && isSame(lines[head], this.lines[from + head])) {
      head += 1;
    }
    while (tail < most - head && isSame(lines[lines.length - 1 - tail], this.lines[to - 1 - tail])) {
      tail += 1;
    }
    const rows = document.createDocumentFragment();
    rows.append(...lines.slice(head, lines.length - tail).map((line) => this.row(line)));
    const next = this.colours.children[to - tail] ?? null;
    for (let gone = to - tail - from - head; gone > 0; gone -= 1) {
      (next ? next.previousSibling : this.colours.lastChild).remove();
    }
    this.colours.insertBefore(rows, next);
    this.lines.splice(from, to - from, ...lines);
    // Rows have no width of their own. The widest row sets the width of all rows.
    const widest = this.lines.reduce((most, { words }) => Math.max(most, words.length), 0);
    this.colours.style.minWidth = `${widest + 2}ch`;
    if (this.lines.length !== this.numbered) {
      this.numbered = this.lines.length;
      this.numbers.textContent = Array.from(this.lines, (_, index) => index + 1).join("\n");
      this.remark();
    }
  }

  row({ words, pieces }) {
    const row = document.createElement("div");
    let at = 0;
    for (const [kind, from, to] of pieces) {
      row.append(words.slice(at, from));
      const piece = document.createElement("span");
      piece.className = `toml-${kind}`;
      piece.textContent = words.slice(from, to);
      row.append(piece);
      at = to;
    }
    row.append(words.slice(at) || (words === "" ? "\u200b" : ""));
    return row;
  }

  /**
   * Marks `length` letters of a line, or the whole line if the column is unknown. Lines and columns count from 1.
   * Without a line, removes the mark.
   */
  mark(line, column, length) {
    this.marked = line ? { line, column, length } : undefined;
    this.remark();
  }

  remark() {
    this.wrong?.remove();
    this.wrong = undefined;
    const row = this.marked && this.colours.children[this.marked.line - 1];
    if (!row) {
      return;
    }
    this.wrong = document.createElement("div");
    this.wrong.className = "editor-wrong";
    this.wrong.style.top = `${this.colours.offsetTop + row.offsetTop}px`;
    this.wrong.style.height = `${row.offsetHeight}px`;
    const { column, length } = this.marked;
    const range = column && this.range(row, column - 1, column - 1 + (length || 1));
    if (range) {
      const [box, layer] = [range.getBoundingClientRect(), this.layers.getBoundingClientRect()];
      const wave = document.createElement("i");
      wave.style.left = `${box.left - layer.left}px`;
      wave.style.width = `${Math.max(box.width, 6)}px`;
      this.wrong.append(wave);
    }
    this.layers.prepend(this.wrong);
  }

  range(row, from, to) {
    const range = document.createRange();
    const walker = document.createTreeWalker(row, NodeFilter.SHOW_TEXT);
    let at = 0;
    range.setStart(row, 0);
    range.setEnd(row, row.childNodes.length);
    let hasStart = false;
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
      if (!hasStart && from <= at + node.length) {
        range.setStart(node, Math.max(0, from - at));
        hasStart = true;
      }
      if (to <= at + node.length) {
        range.setEnd(node, Math.max(0, to - at));
        break;
      }
      at += node.length;
    }
    if (!hasStart) {
      range.collapse(false);
    }
    return range;
  }

  box(at) {
    const before = this.text.slice(0, at);
    const row = this.colours.children[before.split("\n").length - 1];
    const column = at - before.lastIndexOf("\n") - 1;
    const range = this.range(row, column, column);
    range.collapse(true);
    const [letter, line] = [range.getBoundingClientRect(), row.getBoundingClientRect()];
    return { left: letter.left || line.left, top: line.top, bottom: line.bottom };
  }

  /** Places a box below a position in the text, or above it if there is no room. */
  put(box, at) {
    const [place, frame] = [this.box(at), this.overlay.getBoundingClientRect()];
    const left = Math.min(place.left - frame.left, frame.width - box.offsetWidth - 4);
    box.style.left = `${Math.max(left, 4)}px`;
    const isBelow = place.bottom + box.offsetHeight < Math.max(frame.bottom, window.innerHeight) || place.top - box.offsetHeight < 0;
    box.style.top = `${isBelow ? place.bottom - frame.top + 2 : place.top - frame.top - box.offsetHeight - 2}px`;
  }

  reveal(at) {
    const [{ left, top, bottom }, frame] = [this.box(at), this.window.getBoundingClientRect()];
    const margin = bottom - top;
    const edge = frame.left + this.numbers.offsetWidth;
    if (top < frame.top + margin) {
      this.window.scrollTop += top - frame.top - margin;
    } else if (bottom > frame.bottom - margin) {
      this.window.scrollTop += bottom - frame.bottom + margin;
    }
    if (left < edge + 20) {
      this.window.scrollLeft += left - edge - 60;
    } else if (left > frame.right - 30) {
      this.window.scrollLeft += left - frame.right + 90;
    }
  }

  jump(line, column = 1) {
    const lines = this.text.split("\n").slice(0, line - 1);
    const at = Math.min(lines.reduce((sum, words) => sum + words.length + 1, 0) + column - 1, this.text.length);
    this.area.focus({ preventScroll: true });
    this.area.setSelectionRange(at, at);
    const frame = this.window.getBoundingClientRect();
    this.window.scrollTop += this.box(at).top - frame.top - frame.height / 3;
    this.reveal(at);
  }
}
