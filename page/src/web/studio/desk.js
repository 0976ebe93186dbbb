// What everything on the page shares: the document, who is chosen, which tool is in hand.
import { addPoint, correct, kindsOf, pointsOf, removePoint, tidy } from "./edits.js";
import { eachFace, runs } from "./text.js";

export class Desk {
  constructor({ api, store, keeper, state, body, view }) {
    Object.assign(this, { api, store, keeper, state, body, view });
    this.chosen = store.doc.parts.length ? 0 : -1;
    this.joint = 0;
    this.tool = "point";
    this.brush = 26;
    this.pin = null;
    this.found = [];
    this.notes = [];
    this.candidate = -1;
    this.said = "";
    this.listeners = [];
  }

  get doc() {
    return this.store.doc;
  }

  part() {
    return this.doc.parts[this.chosen];
  }

  listen(callback) {
    this.listeners.push(callback);
  }

  /** Something is not as it was shown; everybody looks once. */
  changed() {
    if (this.waiting) return;
    this.waiting = true;
    queueMicrotask(() => {
      this.waiting = false;
      this.listeners.forEach((callback) => callback());
    });
  }

  /** Says something for a while. */
  say(words) {
    this.said = words;
    clearTimeout(this.quiet);
    this.quiet = setTimeout(() => {
      this.said = "";
      this.changed();
    }, 6000);
    this.changed();
  }

  choose(part, joint = 0) {
    this.chosen = part < this.doc.parts.length ? part : -1;
    this.joint = joint;
    this.pin = null;
    this.candidate = -1;
    this.view?.chooses(this.chosen, joint);
    this.changed();
  }

  chooseNext(step) {
    const count = this.doc.parts.length;
    if (count) this.choose((Math.max(this.chosen, step > 0 ? -1 : 0) + step + count) % count);
  }

  takes(tool) {
    this.tool = tool;
    this.pin = null;
    this.view?.changed();
    this.changed();
  }

  /** Changes the chosen part. */
  editPart(words, change, more) {
    const i = this.chosen;
    return this.store.edit(`${this.part().name}: ${words}`, (doc) => change(doc.parts[i], doc), more);
  }

  /** Says something of a joint of the chosen part. */
  correct(words, fields, more = {}) {
    const { joint } = this;
    return this.editPart(words, (part) => correct(part, joint, fields), more);
  }

  addPoint(p, isNot) {
    this.editPart(isNot ? "a place that is not of it" : "a point", (part) => addPoint(part, this.body.fileOf(p), isNot));
  }

  removePoint(pin) {
    this.pin = null;
    this.editPart("a point taken away", (part) => removePoint(part, pin));
  }

  points() {
    return this.doc.parts.flatMap((part, i) => pointsOf(part).map((point) => ({ ...point, part: i })));
  }

  /** Writes which faces are painted as what. */
  paint(owner, words) {
    const lists = this.doc.parts.map(() => []);
    owner.forEach((part, f) => part >= 0 && lists[part].push(f));
    this.store.edit(words, (doc) => {
      doc.parts.forEach((part, i) => {
        if (lists[i].length) part.faces = runs(lists[i]);
        else delete part.faces;
      });
      tidy(doc, this.body.digest);
    });
  }

  paintedCount(part) {
    let count = 0;
    if (part.faces) eachFace(part.faces, this.body?.all ?? Infinity, () => (count += 1));
    return count;
  }

  /** The joint of the chosen part in the model; −1 where nobody knows it yet. */
  modelJoint(index = this.joint) {
    return this.view?.model && this.chosen >= 0 && kindsOf(this.part())[index] ? this.view.model.jointOf(this.chosen, index) : -1;
  }

  /** What was found for a joint of the chosen part. */
  foundJoint(index = this.joint) {
    const name = this.part()?.name;
    return this.found.find((j) => j.part === name && j.index === index);
  }
}
