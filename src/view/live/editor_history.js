const HISTORY_LENGTH = 500;

/** A longer pause starts a new undo step, in milliseconds. */
const HISTORY_PAUSE = 1200;

/**
 * Returns the difference between two texts, `{at, removed, inserted}`, or undefined if they are equal. The new caret
 * position distinguishes a new letter from equal letters beside it.
 */
function textChange(before, after, caret = Infinity) {
  if (before === after) {
    return undefined;
  }
  const most = Math.min(before.length, after.length);
  const latest = Math.min(most, Math.max(0, caret - Math.max(0, after.length - before.length)));
  let at = 0;
  while (at < latest && before.charCodeAt(at) === after.charCodeAt(at)) {
    at += 1;
  }
  let tail = 0;
  while (tail < most - at && before.charCodeAt(before.length - 1 - tail) === after.charCodeAt(after.length - 1 - tail)) {
    tail += 1;
  }
  return { at, removed: before.slice(at, before.length - tail), inserted: after.slice(at, after.length - tail) };
}

class TextHistory {
  constructor(text) {
    this.text = text;
    this.steps = [];
    this.place = 0;
    this.last = -Infinity;
  }

  /** Records a new text and returns the change. Successive changes of the same `kind` may form one step. */
  note(text, kind, caret, now = performance.now()) {
    const change = textChange(this.text, text, caret);
    if (!change) {
      return undefined;
    }
    this.steps.length = this.place;
    const before = this.steps.at(-1);
    if (before && this.isContinued(before, change, kind, now)) {
      Object.assign(before, textChange(this.before(before), text, caret) ?? { removed: "", inserted: "" });
    } else {
      this.steps.push({ ...change, kind });
      if (this.steps.length > HISTORY_LENGTH) {
        this.steps.shift();
      }
    }
    this.text = text;
    this.place = this.steps.length;
    this.last = now;
    return change;
  }

  isContinued(before, change, kind, now) {
    if (!kind || before.kind !== kind || now - this.last > HISTORY_PAUSE) {
      return false;
    }
    if (kind === "type") {
      return change.removed === "" && !change.inserted.includes("\n") && change.at === before.at + before.inserted.length;
    }
    return true;
  }

  before({ at, removed, inserted }) {
    return this.text.slice(0, at) + removed + this.text.slice(at + inserted.length);
  }

  undo() {
    if (this.place === 0) {
      return undefined;
    }
    this.place -= 1;
    const step = this.steps[this.place];
    this.text = this.before(step);
    return { text: this.text, caret: step.at + step.removed.length };
  }

  redo() {
    if (this.place === this.steps.length) {
      return undefined;
    }
    const { at, removed, inserted } = this.steps[this.place];
    this.place += 1;
    this.text = this.text.slice(0, at) + inserted + this.text.slice(at + removed.length);
    return { text: this.text, caret: at + inserted.length };
  }
}
