// What a person should know now: notes over the picture, questions in a dialog.
import { el, icon } from "../dom.js";

export class Notices {
  constructor(root) {
    this.root = root;
    this.known = new Map();
    this.lost = new Set();
  }

  /** A note with buttons: [words, act], and something more before them. It stands until it is cleared, or waved away where that is allowed; then it calls `gone`. */
  set(key, text, { actions = [], kind = "note", stays = false, more = null, gone = () => {} } = {}) {
    this.clear(key);
    const buttons = actions.map(([words, act]) => el("button", { type: "button", onclick: act }, words));
    const away = stays ? null : el("button", { type: "button", className: "icon", "aria-label": "Close this note", onclick: () => {
      this.clear(key);
      gone();
    } }, icon("close"));
    const note = el("div", { className: `notice ${kind}`, id: `notice-${key}`, role: kind === "bad" ? "alert" : "status" }, el("span", {}, text), more, ...buttons, away);
    this.known.set(key, note);
    this.root.append(note);
  }

  clear(key) {
    this.known.get(key)?.remove();
    this.known.delete(key);
  }
}

/** Asks in a dialog; answers: [words, act, main]. There is no way out but an answer. */
export function askPerson(dialog, title, body, answers) {
  const buttons = answers.map(([words, act, isMain]) => el("button", { type: "button", className: isMain ? "main plain" : "", onclick: () => {
    dialog.close();
    act();
  } }, words));
  dialog.replaceChildren(el("h2", { id: "ask-title" }, title), ...body, el("div", { className: "row answers" }, ...buttons));
  dialog.oncancel = (event) => event.preventDefault();
  if (!dialog.open) dialog.showModal();
  buttons.at(-1).focus();
}

/** What differs between two conditions, as a table. */
export function differenceTable(found) {
  if (!found.length) return el("p", { className: "dim" }, "The words are the same; only their layout differs.");
  const head = el("tr", {}, ...["Field", "On this page", "On disk"].map((words) => el("th", { scope: "col" }, words)));
  const rows = found.slice(0, 40).map(({ field, mine, theirs }) => el("tr", {}, el("th", { scope: "row" }, field), el("td", {}, mine), el("td", {}, theirs)));
  const rest = found.length > 40 ? el("p", { className: "dim" }, `and ${found.length - 40} more`) : null;
  return el("div", { className: "differences" }, el("table", {}, el("thead", {}, head), el("tbody", {}, ...rows)), rest);
}
