// Keeps the file as the page has it, and asks what the new words lead to.
import { written } from "./text.js";

/** How long typing waits for the next key, and how long a lost server is left alone, milliseconds. */
const TYPING = 50;
const AGAIN = 1500;

const pause = (time) => new Promise((done) => setTimeout(done, time));

/**
 * `phase`: saved, unsaved, saving, offline, conflict, held (until a person agrees), refused.
 * `work`: null, labelling or articulating.
 */
export class Keeper {
  constructor(api, store, state) {
    this.api = api;
    this.store = store;
    this.revision = state.revision;
    this.kept = written(store.doc);
    this.hasFile = Boolean(state.text);
    this.phase = "saved";
    this.work = null;
    this.faults = state.faults;
    this.scale = state.scale || 1;
    this.held = false;
    this.comments = false;
    this.guard = ({ document }) => ({ document, isForeign: false });
    this.listeners = [];
    this.turn = 0;
    store.listen((what) => this.changed(what));
  }

  /** Calls back with a name and what belongs to it: phase, labels, joints, conflict, trouble. */
  listen(callback) {
    this.listeners.push(callback);
  }

  tell(name, what) {
    this.listeners.forEach((callback) => callback(name, what));
  }

  become(phase) {
    this.phase = phase;
    this.tell("phase", phase);
  }

  changed({ typing, theirs }) {
    if (theirs) return;
    clearTimeout(this.timer);
    this.turn += 1;
    this.asking?.abort();
    this.work = null;
    if (this.phase === "conflict") return;
    if (this.held) return this.become("held");
    this.become("unsaved");
    this.timer = setTimeout(() => this.save(), typing ? TYPING : 0);
  }

  isDirty() {
    return written(this.store.doc) !== this.kept;
  }

  /** Writes what is not written yet, one after the other. */
  async save() {
    if (this.saving || this.phase === "conflict" || this.held) return;
    this.saving = true;
    try {
      while (this.isDirty() && this.phase !== "conflict") {
        if (!(await this.send(written(this.store.doc)))) return;
      }
      if (this.phase !== "conflict") this.become("saved");
    } finally {
      this.saving = false;
    }
    if (this.phase === "saved") this.ask();
  }

  /** Sends a text; whether it was taken. */
  async send(text) {
    this.become(this.phase === "offline" ? "offline" : "saving");
    try {
      this.takeSaved(await this.api.put("condition", { text, base: this.revision }), text);
      return true;
    } catch (error) {
      this.notSaved(error, text);
      return false;
    }
  }

  takeSaved({ revision, faults, scale }, text) {
    this.revision = revision;
    this.faults = faults ?? [];
    this.scale = scale || this.scale;
    this.kept = text;
    this.hasFile = true;
    this.tell("faults", this.faults);
  }

  notSaved(error, text) {
    if (error.status === 409 && error.body.revision) {
      this.become("conflict");
      this.tell("conflict", error.body);
    } else if (error.status === 0) {
      this.become("offline");
      this.timer = setTimeout(() => this.save(), AGAIN);
    } else {
      this.become("refused");
      this.tell("trouble", error);
      this.refused = text;
      // A full disk or a folder that may not be written to is no fault of the text.
      if (error.status >= 500) this.timer = setTimeout(() => this.save(), 2 * AGAIN);
    }
  }

  /** A person agrees to what is lost by saving. */
  agree() {
    this.held = false;
    this.save();
  }

  /** What stands on disk wins. */
  takeTheirs(state) {
    this.turn += 1;
    this.revision = state.revision;
    this.faults = state.faults ?? [];
    this.scale = state.scale || this.scale;
    this.phase = "saved";
    this.hasFile = true;
    const document = this.guards(state);
    this.store.take(document, "the file changed on disk");
    this.kept = written(document);
    this.become("saved");
    this.ask();
  }

  /** What of a file can be edited; where saving would lose a word of it, a person is asked first. */
  guards(state) {
    const { document, isForeign } = this.guard(state);
    this.comments = Boolean(state.has_comments);
    this.held = isForeign || this.comments;
    return document;
  }

  /** What stands here wins. */
  keepMine({ revision }) {
    this.revision = revision;
    this.kept = null;
    this.become("unsaved");
    this.save();
  }

  /** Somebody says that the file is another one now. */
  async looksAgain() {
    while (this.saving) await pause(20);
    if (this.phase === "conflict") return;
    let state;
    try {
      state = await this.api.get("state");
    } catch (error) {
      this.tell("trouble", error);
      return;
    }
    if (state.revision === this.revision) {
      if (this.phase === "offline") this.save();
    } else if (this.isDirty()) {
      this.become("conflict");
      this.tell("conflict", state);
    } else {
      this.takeTheirs(state);
    }
  }

  doing(work) {
    this.work = work;
    this.tell("phase", this.phase);
  }

  /** Labels, then joints. What is no longer asked is dropped. */
  async ask() {
    const turn = (this.turn += 1);
    this.asking?.abort();
    this.asking = new AbortController();
    const { signal } = this.asking;
    const asked = async (what, work) => {
      this.doing(work);
      const answer = await this.answer(what, signal, () => turn === this.turn);
      if (turn === this.turn && answer) this.tell(what === "labels" ? "labels" : "joints", answer);
      return turn === this.turn && answer;
    };
    const isAskable = this.store.doc.parts.length > 0 && this.faults.length === 0;
    if (isAskable && !((await asked("labels", "labelling")) && (await asked("articulate", "articulating")))) {
      if (turn === this.turn) this.doing(null);
      return;
    }
    if (turn === this.turn) this.doing(null);
  }

  async answer(what, signal, isWanted) {
    for (let tries = 0; isWanted() && tries < 20; tries++) {
      try {
        return await this.api.post(what, { revision: this.revision }, signal);
      } catch (error) {
        if (error.name === "AbortError") return null;
        if (error.status === 422) {
          this.faults = error.body.faults ?? [];
          this.tell("faults", this.faults);
          return null;
        }
        if (error.status !== 503 && error.status !== 0) {
          this.tell("trouble", error);
          return null;
        }
        await pause(error.status ? 150 : AGAIN);
      }
    }
    return null;
  }
}
