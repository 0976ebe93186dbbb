// What is edited, and what it was before.
import { written } from "./text.js";

/** Edits of one field within so many milliseconds are one step back. */
const ONE_STEP = 1500;
const MOST_STEPS = 500;

export class Store {
  constructor(doc) {
    this.doc = doc;
    this.past = [];
    this.future = [];
    this.listeners = [];
    this.last = null;
  }

  listen(callback) {
    this.listeners.push(callback);
  }

  tell(what) {
    this.listeners.forEach((callback) => callback(what));
  }

  /** Changes the document. `words` say what was done; edits with one `field` that follow soon are one. */
  edit(words, change, { field = null, typing = false } = {}) {
    const next = structuredClone(this.doc);
    change(next);
    if (next.schema === "kinfold-condition/1" || !next.schema) next.schema = "kinfold-condition/2";
    if (written(next) === written(this.doc)) return false;
    const now = performance.now();
    const goesOn = field && this.last?.field === field && now - this.last.at < ONE_STEP;
    if (!goesOn) this.past.push({ doc: this.doc, words });
    if (this.past.length > MOST_STEPS) this.past.shift();
    this.last = { field, at: now };
    this.future = [];
    this.doc = next;
    this.tell({ words, typing });
    return true;
  }

  undo() {
    this.step(this.past, this.future, "Undone");
  }

  redo() {
    this.step(this.future, this.past, "Done again");
  }

  step(from, to, word) {
    const step = from.pop();
    if (!step) return;
    to.push({ doc: this.doc, words: step.words });
    this.doc = step.doc;
    this.last = null;
    this.tell({ words: `${word}: ${step.words}`, typing: false });
  }

  /** Takes another document, as somebody else wrote it; a step back leads to ours. */
  take(doc, words) {
    this.past.push({ doc: this.doc, words });
    this.future = [];
    this.last = null;
    this.doc = doc;
    this.tell({ words, typing: false, theirs: true });
  }
}
