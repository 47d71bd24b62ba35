const COMPLETION_LENGTH = 60;

const bare = (word) => word.replace(/^["']|["']$/g, "");

/** Returns offers that contain a text. Offers that begin with the text come first. */
function fitting(offers, there) {
  const wanted = bare(there).toLowerCase();
  const rank = ({ word }) => {
    const at = bare(word).toLowerCase().indexOf(wanted);
    const isPart = at > 0 && (wanted.length > 2 || "._-".includes(bare(word)[at - 1]));
    return at === 0 ? 0 : isPart ? 1 : 2;
  };
  const ranked = offers.map((offer) => [rank(offer), offer]).filter(([place]) => place < 2);
  const kept = ranked.sort((one, other) => one[0] - other[0]).slice(0, COMPLETION_LENGTH).map(([, offer]) => offer);
  return kept.length === 1 && kept[0].word === there ? [] : kept;
}

/** Returns a key with the beginning of its value, and the new position of the caret. */
function keyInsertion({ word, type, standard }) {
  const [open, close] = { array: ["[", "]"], object: ["{ ", " }"] }[type] ?? (type === "string" && !standard ? ['"', '"'] : ["", ""]);
  const written = `${word} = ${open}`;
  return { insert: written + close, caret: written.length };
}

/**
 * Returns the completions at a caret, or undefined:
 * `{start, end, there, offers: [{word, about, detail, insert, caret}]}`.
 * An offer replaces the text from `start` to `end` by `insert`.
 */
function completions(toml, caret, schema) {
  const { text } = toml;
  // The text before the caret may end within a header, so headers are found in the whole text.
  const table = toml.tables.findLast(({ start, end }) => start < caret && end <= caret) ?? toml.tables[0];
  const before = text.slice(0, caret);
  const part = new Toml(before.slice(table.start));
  const { tokens } = part;
  const place = { ...part.place, path: [...table.at, ...part.place.path.slice(part.tables.at(-1).at.length)] };
  const last = tokens.at(-1);
  if (last?.[0] === "comment" && last[2] === caret - table.start) {
    return undefined;
  }
  const line = before.slice(before.lastIndexOf("\n") + 1);
  const after = text.slice(caret).match(/^[^\n]*/)[0];
  if (place.role === "header") {
    return headerCompletions({ line, after, caret, toml, schema });
  }
  return place.role === "key" ? keyCompletions({ place, line, after, caret, toml, schema }) : valueCompletions({ place, line, after, caret, toml, schema });
}

function headerOffers(toml, schema) {
  return schema.headers(toml).map(({ word, about, isArray }) => {
    const insert = isArray ? `[[${word}]]` : `[${word}]`;
    return { word, about, detail: isArray ? "[[ ]]" : "[ ]", insert: `${insert}\n`, caret: insert.length + 1 };
  });
}

function headerCompletions({ line, after, caret, toml, schema }) {
  const found = line.match(/^\s*\[\[?\s*([\w.-]*)$/);
  if (!found) {
    return undefined;
  }
  const end = caret + after.match(/^[\w.-]*\]{0,2}/)[0].length + (/^[\w.-]*\]{0,2}$/.test(after) && toml.text[caret + after.length] === "\n" ? 1 : 0);
  return { start: caret - line.trimStart().length, end, there: found[1], offers: fitting(headerOffers(toml, schema), found[1]) };
}

function keyCompletions({ place, line, after, caret, toml, schema }) {
  const found = line.match(/(^|[{,])\s*((?:[\w-]+\.)*)([\w-]*)$/);
  if (!found) {
    return undefined;
  }
  const [, , dotted, there] = found;
  const path = [...place.path, ...dotted.split(".").filter((key) => key !== "")];
  const isRoot = path.length === 0;
  const hasValue = /^[\w-]*\s*=/.test(after);
  const keys = schema.keys(path, toml).filter(({ type }) => !isRoot || (type !== "object" && type !== "array"));
  const offers = keys.map((key) => {
    const detail = key.isRequired ? "needed" : key.standard ? `= ${key.standard}` : key.type;
    const plain = { insert: key.word, caret: key.word.length };
    const isOffered = schema.values([...path, key.word], toml).length > 0;
    const whole = isOffered && key.type !== "array" ? { insert: `${key.word} = `, caret: key.word.length + 3, isContinued: true } : keyInsertion(key);
    return { word: key.word, about: key.about, detail, ...(hasValue ? plain : whole) };
  });
  if (line.trim() === there && there !== "" && after.trim() === "" && !dotted) {
    offers.push(...headerOffers(toml, schema));
  }
  const end = caret + after.match(/^[\w-]*/)[0].length;
  return { start: caret - there.length, end, there, offers: fitting(offers, there) };
}

function valueCompletions({ place, line, after, caret, toml, schema }) {
  const found = line.match(/[=[,]\s*(["']?[\w.-]*)$/);
  if (!found) {
    return undefined;
  }
  const there = found[1];
  const offers = schema.values(place.path, toml).map((offer) => ({ ...offer, detail: "", insert: offer.word, caret: offer.word.length }));
  const end = caret + after.match(/^[\w.-]*["']?/)[0].length;
  return { start: caret - there.length, end, there, offers: fitting(offers, there) };
}

class CompletionList {
  constructor(editor, schema) {
    this.editor = editor;
    this.schema = schema;
    this.box = document.createElement("div");
    this.box.className = "editor-offers";
    this.box.hidden = true;
    this.list = document.createElement("ul");
    this.list.id = "editor-offers";
    this.list.setAttribute("role", "listbox");
    this.list.setAttribute("aria-label", "Completions");
    this.about = document.createElement("p");
    this.box.append(this.list, this.about);
    editor.overlay.append(this.box);
    editor.area.setAttribute("aria-autocomplete", "list");
    // Keeps the caret in place.
    this.box.addEventListener("pointerdown", (event) => event.preventDefault());
    this.list.addEventListener("click", (event) => {
      const item = event.target.closest("li");
      if (item) {
        this.index = [...this.list.children].indexOf(item);
        this.accept();
      }
    });
  }

  get isOpen() {
    return !this.box.hidden;
  }

  /** `isAsked` is true if the user has requested the list with a key. */
  update(isAsked) {
    const { area } = this.editor;
    const found = area.selectionStart === area.selectionEnd ? completions(this.editor.toml, area.selectionStart, this.schema) : undefined;
    const isWorth = found && (isAsked || found.there !== "" || /[=[,]\s?$/.test(area.value.slice(0, area.selectionStart)));
    if (!isWorth || found.offers.length === 0) {
      this.close();
      return;
    }
    this.found = found;
    this.list.replaceChildren(...found.offers.map((offer, index) => this.item(offer, index)));
    this.box.hidden = false;
    this.editor.put(this.box, found.start);
    area.setAttribute("aria-controls", this.list.id);
    this.choose(0);
  }

  item({ word, detail }, index) {
    const item = document.createElement("li");
    item.id = `editor-offer-${index}`;
    item.setAttribute("role", "option");
    const [name, note] = [document.createElement("span"), document.createElement("small")];
    name.textContent = word;
    note.textContent = detail;
    item.append(name, note);
    return item;
  }

  choose(index) {
    const { offers } = this.found;
    this.index = (index + offers.length) % offers.length;
    [...this.list.children].forEach((item, at) => item.setAttribute("aria-selected", String(at === this.index)));
    this.list.children[this.index].scrollIntoView({ block: "nearest" });
    this.about.replaceChildren(...proseNodes(offers[this.index].about));
    this.about.hidden = offers[this.index].about === "";
    this.editor.area.setAttribute("aria-activedescendant", `editor-offer-${this.index}`);
  }

  accept() {
    const { start, end, offers } = this.found;
    const { insert, caret, isContinued } = offers[this.index];
    this.close();
    this.editor.replace(start, end, insert, start + caret);
    if (isContinued) {
      this.update(true);
    }
  }

  close() {
    this.box.hidden = true;
    this.editor.area.removeAttribute("aria-activedescendant");
    this.editor.area.removeAttribute("aria-controls");
  }

  key(event) {
    if (!this.isOpen) {
      return false;
    }
    if (event.key === "Escape") {
      this.close();
    } else if (event.key === "ArrowDown" || event.key === "ArrowUp") {
      this.choose(this.index + (event.key === "ArrowDown" ? 1 : -1));
    } else if (event.key === "Tab" || event.key === "Enter") {
      this.accept();
    } else {
      if (["ArrowLeft", "ArrowRight", "Home", "End", "PageUp", "PageDown"].includes(event.key)) {
        this.close();
      }
      return false;
    }
    return true;
  }
}
