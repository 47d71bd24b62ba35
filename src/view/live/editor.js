// The editor of a scene.

/** Pause in typing before the text is checked, in milliseconds. */
const EDITOR_PAUSE = 250;

/** Pause in typing before completions are offered, in milliseconds. */
const EDITOR_OFFERS = 70;

/** Longest time to wait for the worker, in milliseconds. */
const EDITOR_PATIENCE = 4000;

/** Returns a text with changes. Keys of changes are written as for `--set`. */
function changedText(text, changes) {
  return Object.entries(changes ?? {}).reduce((changed, [path, value]) => new Toml(changed).with(path, value), text);
}

/** Returns the line, column and length of a byte range in UTF-8. Lines and columns count from 1. */
function bytePlace(text, offset, length) {
  const bytes = new TextEncoder().encode(text);
  const letters = (from, to) => new TextDecoder().decode(bytes.subarray(from, to));
  const lines = letters(0, offset).split("\n");
  const marked = letters(offset, offset + length).split("\n")[0];
  return { line: lines.length, column: lines.at(-1).length + 1, length: marked.length };
}

class LiveEditor {
  constructor(live) {
    this.live = live;
    this.own = live.scene.text;
    this.build();
    this.editor = new TextEditor(this.place, this.own, (kind) => this.edited(kind));
    this.offers = new CompletionList(this.editor, new SceneSchema(JSON.parse(document.getElementById("schema").textContent)));
    const place = document.getElementById("live-sliders");
    this.sliders = new SliderSet(place, live.scene.live?.sliders, (...moved) => this.slide(...moved), this.offers.schema);
    this.runs = changedText(live.text ?? this.own, live.changes);
    this.number = 0;
    this.waiting = undefined;
    this.isBusy = false;
    this.listen();
    this.sliders.follow(this.editor.toml);
    this.section.hidden = false;
    this.state();
    this.read();
  }

  build() {
    this.section = document.getElementById("live-editor");
    const make = (name, className, parent, words = "") => {
      const node = document.createElement(name);
      node.className = className;
      node.textContent = words;
      parent.append(node);
      return node;
    };
    const button = (words, title, act, className = "") => {
      const made = make("button", className, this.tools, words);
      made.type = "button";
      made.title = title;
      made.addEventListener("click", act);
      return made;
    };
    this.section.replaceChildren();
    const head = make("div", "editor-head", this.section);
    make("h2", "", head, "Scene");
    this.tools = make("div", "editor-tools", head);
    this.note = make("span", "editor-note", this.tools);
    this.run = button("Run", "Run this text (Ctrl+Enter)", () => this.start(), "editor-run");
    this.revert = button("Original", "Back to the scene of this page", () => this.restore());
    this.share = button("Share", "A link that carries this scene", () => this.link());
    this.save = button("Download", "This scene as a file that `carom run` repeats", () => this.download());
    this.linked = make("p", "editor-link", this.section);
    this.linked.hidden = true;
    this.place = make("div", "editor-place", this.section);
    this.message = make("div", "editor-message", this.place);
    this.message.setAttribute("role", "status");
  }

  listen() {
    const { area } = this.editor;
    area.addEventListener("keydown", (event) => this.key(event), true);
    area.addEventListener("blur", () => this.offers.close());
    area.addEventListener("pointerdown", () => this.offers.close());
    this.live.listen("head", () => this.began());
    this.live.listen("error", (message) => this.refused(message));
    window.addEventListener("hashchange", () => this.read());
  }

  key(event) {
    const isCommand = event.ctrlKey || event.metaKey;
    const isTaken = isCommand && event.key === "Enter" ? (this.start(), true)
      : isCommand && event.key === " " ? (this.offers.update(true), true)
      : this.offers.key(event);
    if (isTaken) {
      event.preventDefault();
      event.stopImmediatePropagation();
    }
  }

  edited(kind) {
    clearTimeout(this.soon);
    if (kind === "type") {
      this.soon = setTimeout(() => this.offers.update(false), EDITOR_OFFERS);
    } else {
      this.offers.close();
    }
    this.state();
    clearTimeout(this.pause);
    this.pause = setTimeout(() => this.settle(kind), EDITOR_PAUSE);
  }

  settle(kind) {
    this.editor.paint();
    if (!kind?.startsWith("slider")) {
      this.sliders.follow(this.editor.toml);
    }
    this.check();
  }

  state() {
    const isOther = this.editor.text !== this.runs;
    this.note.textContent = isOther ? "not running yet" : "";
    this.run.classList.toggle("is-due", isOther);
    this.revert.hidden = this.editor.text === this.own;
  }

  /** Checks the text with the engine. Only one check runs at a time. */
  async check() {
    if (this.isAsking) {
      this.isStale = true;
      return;
    }
    this.isAsking = true;
    const { text } = this.editor;
    const answer = await this.live.ask({ kind: "check", text, changes: {} });
    this.isAsking = false;
    if (this.isStale || text !== this.editor.text) {
      this.isStale = false;
      this.check();
      return;
    }
    this.tell(answer);
  }

  tell({ error, line, help, offset, length: bytes } = {}, text = this.editor.text) {
    this.message.replaceChildren();
    const place = line && Number.isFinite(offset) ? bytePlace(text, offset, bytes ?? 0) : undefined;
    // An error that spans several lines is marked in the first line.
    const { column, length } = place && place.line === line && place.length > 0 ? place : {};
    this.editor.mark(error ? line : undefined, column, length);
    this.editor.area.setAttribute("aria-invalid", String(Boolean(error)));
    this.message.classList.toggle("is-wrong", Boolean(error));
    if (!error) {
      return;
    }
    if (line) {
      const jump = document.createElement("button");
      jump.type = "button";
      jump.textContent = `line ${line}`;
      jump.addEventListener("click", () => this.editor.jump(line, column));
      this.message.append(jump, " ");
    }
    this.message.append(...proseNodes(error));
    if (help) {
      const cure = document.createElement("p");
      cure.append(...proseNodes(help));
      this.message.append(cure);
    }
  }

  /** Runs the text. If the text has an error, the present simulation continues. */
  async start() {
    const { text } = this.editor;
    this.offers.close();
    clearTimeout(this.pause);
    const answer = await this.live.ask({ kind: "check", text, changes: {} });
    this.tell(answer, text);
    if (!answer.error) {
      this.queue({ text });
    }
  }

  slide(slider, written) {
    const { toml } = this.editor;
    const value = written(toml);
    const text = toml.with(slider.key, value);
    this.editor.write(text, `slider ${slider.key}`);
    // A live slider changes the running scene, unless the text has other changes. Then the scene restarts.
    const isAlone = this.runs === text || this.isOnly(slider.key);
    this.queue(slider.isLive && isAlone ? { changes: { [slider.key]: value } } : { text });
  }

  /** Returns whether the running text and the text in the editor differ only in one value. */
  isOnly(key) {
    const plain = (text) => new Toml(text).with(key, "0");
    const waiting = this.waiting?.changes ?? {};
    return this.waiting?.text === undefined && plain(changedText(this.runs, waiting)) === plain(this.editor.text);
  }

  /** Queues a change. The worker gets one change at a time, and new values replace queued values. */
  queue(wanted) {
    const changes = wanted.changes && this.waiting?.changes ? { ...this.waiting.changes, ...wanted.changes } : wanted.changes;
    this.waiting = { ...wanted, changes };
    if (!this.isBusy) {
      this.send();
    }
  }

  send() {
    const wanted = this.waiting;
    this.waiting = undefined;
    if (!wanted) {
      return;
    }
    this.isBusy = true;
    this.sent = wanted;
    clearTimeout(this.patience);
    this.patience = setTimeout(() => this.free(), EDITOR_PATIENCE);
    if (wanted.text === undefined) {
      this.live.change(wanted.changes);
    } else {
      this.live.start(wanted.text, {});
    }
  }

  free() {
    clearTimeout(this.patience);
    this.isBusy = false;
    this.sent = undefined;
    this.send();
  }

  /** Updates the text after a scene has started or has accepted new values. */
  began() {
    const { text, changes } = this.live;
    this.runs = changedText(text, changes);
    const shown = changedText(this.editor.text, changes);
    if (!this.waiting) {
      this.editor.write(shown);
    }
    this.tell();
    this.state();
    this.free();
  }

  refused(message) {
    // If the running simulation rejects a value, the scene restarts with this value.
    if (this.sent?.changes && !this.waiting) {
      this.waiting = { text: this.editor.text };
    } else {
      this.tell(message);
    }
    this.free();
  }

  restore() {
    this.editor.write(this.own);
    this.start();
    this.linked.hidden = true;
    if (location.hash) {
      history.replaceState(null, "", location.pathname + location.search);
    }
  }

  async read() {
    if (location.hash === this.hash) {
      return;
    }
    this.hash = location.hash;
    try {
      const text = await sharedText(location.hash);
      if (text !== undefined && text !== this.editor.text) {
        this.editor.write(text);
        this.sliders.settle();
        this.sliders.follow(this.editor.toml);
        this.note.textContent = "";
        this.say("This scene came with the link.");
        document.getElementById("live-description").hidden = true;
        this.start();
      }
    } catch (error) {
      this.say(error.message);
    }
  }

  say(words, ...nodes) {
    this.linked.replaceChildren(words, ...nodes);
    this.linked.hidden = false;
  }

  async link() {
    const fragment = await shareFragment(this.editor.text);
    const address = `${location.href.replace(/#.*$/, "")}#${fragment}`;
    this.hash = `#${fragment}`;
    history.replaceState(null, "", address);
    const field = document.createElement("input");
    Object.assign(field, { readOnly: true, value: address });
    field.setAttribute("aria-label", "Link");
    let isCopied = true;
    try {
      await navigator.clipboard.writeText(address);
    } catch {
      isCopied = false;
    }
    const size = address.length > 8000 ? ` It has ${address.length} letters; some programs cut links of more than 8,000.` : "";
    this.say(`${isCopied ? "The link is copied." : "Copy this link:"}${size} `, field);
    field.focus();
    field.select();
  }

  /** Saves the text in the editor, or the present state after particles were moved by hand. */
  async download() {
    const { text, error } = this.live.isKicked ? await this.live.ask({ kind: "scene" }) : this.editor;
    if (error) {
      this.live.say(error);
      return;
    }
    saveFile("scene.toml", "application/toml", text);
  }
}
