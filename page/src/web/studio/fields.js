// Fields of forms that follow what they show and leave alone who types.
import { el } from "../dom.js";

/** Fields of one form: made once, refreshed often. */
export class Form {
  constructor() {
    this.follows = [];
  }

  follow() {
    this.follows.forEach((callback) => callback());
  }

  add(callback) {
    this.follows.push(callback);
    callback();
    return this;
  }

  /** A labelled input. `get` gives its value, `set` takes it; what `set` calls wrong is marked so. */
  text({ id, label, get, set, ...more }) {
    const input = el("input", { type: "text", id, autocomplete: "off", spellcheck: false, ...more, oninput: () => this.given(input, set(input.value, true)), onchange: () => this.given(input, set(input.value, false)) });
    this.keeps(input, get);
    return row(label, input);
  }

  /** A number; `set` gets a number, or null for none, when it is finished or stepped. */
  number({ id, label, get, set, unit = null, bare = false, ...more }) {
    const input = el("input", { type: "number", id, step: "any", "aria-label": bare ? label : undefined, ...more, onchange: () => this.given(input, input.value === "" ? set(null) : set(Number(input.value))) });
    this.keeps(input, get);
    const field = unit ? el("span", { className: "with-unit" }, input, el("span", { className: "unit" }, unit)) : input;
    return bare ? field : row(label, field, id);
  }

  select({ id, label, get, set, options, bare = false }) {
    const input = el("select", { id, "aria-label": bare ? label : undefined, onchange: () => set(input.value) });
    let shown = "";
    this.add(() => {
      const list = options();
      const key = JSON.stringify(list);
      if (key !== shown) input.replaceChildren(...list.map(([value, words]) => el("option", { value }, words)));
      shown = key;
      input.value = get();
    });
    return bare ? input : row(label, input);
  }

  keeps(input, get) {
    let before;
    this.add(() => {
      const value = get() ?? "";
      if (document.activeElement === input && value === before) return;
      before = value;
      if (document.activeElement === input && sameNumber(input.value, value)) return;
      if (input.value !== String(value)) input.value = value;
      this.given(input, true);
    });
  }

  given(input, isSound) {
    input.setAttribute("aria-invalid", isSound === false);
  }
}

const sameNumber = (text, value) => text !== "" && value !== "" && Number(text) === Number(value);

/** A label and what it is of. */
export function row(label, field, id = field.id) {
  return el("div", { className: "field" }, el("label", { htmlFor: id }, label), field);
}

/** Fills a place anew and gives the focus back to what had it. */
export function refill(root, ...children) {
  const { id, selectionStart } = document.activeElement ?? {};
  const had = id && root.contains(document.activeElement);
  const top = root.scrollTop;
  root.replaceChildren(...children);
  root.scrollTop = top;
  const again = had && document.getElementById(id);
  if (!again) return;
  again.focus({ preventScroll: true });
  if (again.type === "text" && selectionStart !== null) again.setSelectionRange(selectionStart, selectionStart);
}
