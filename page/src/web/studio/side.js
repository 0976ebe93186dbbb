// The object and its parts: the panel at the left.
import { css, el, icon } from "../dom.js";
import { addPart, kindsOf, put, removePart } from "./edits.js";
import { Form, refill } from "./fields.js";
import { six } from "./text.js";

const MOVES = { revolute: "turns", continuous: "spins", prismatic: "slides" };
const SIDES_OF = [["height", "Height"], ["width", "Width"], ["depth", "Depth"], ["largest", "Longest"]];

const movesHow = (part) => (part.parent ? kindsOf(part).map((k) => MOVES[k] ?? k).join(" + ") || "fixed" : "base");

/** Adds a part and chooses it. */
export function newPart(desk, words) {
  let at = -1;
  desk.store.edit(`part ${words} added`, (doc) => {
    at = addPart(doc, words);
  });
  desk.choose(at);
}

/** Takes the chosen part away. */
export function deletePart(desk, i = desk.chosen) {
  if (i < 0) return;
  const { name } = desk.doc.parts[i];
  desk.store.edit(`part ${name} deleted`, (doc) => removePart(doc, i));
  desk.choose(Math.min(i, desk.doc.parts.length - 1));
  desk.say(`Deleted ${name}. Ctrl+Z brings it back.`);
}

function objectForm(desk) {
  const form = new Form();
  const [which] = Object.entries(desk.doc.size ?? {})[0] ?? ["height"];
  let side = which;
  const size = () => Object.entries(desk.doc.size ?? {})[0];
  const write = (metres) => {
    if (metres !== null && !(metres > 0)) return false;
    desk.store.edit("size set", (doc) => put(doc, "size", metres === null ? null : { [side]: metres }), { field: "size" });
    return true;
  };
  const rows = [
    form.text({ id: "object-category", label: "Object", placeholder: "what it is, like oven", get: () => desk.doc.category, set: (value, typing) => desk.store.edit("named", (doc) => {
      doc.category = value;
    }, { field: "category", typing }) || true }),
    el("div", { className: "field" },
      form.select({ id: "object-size-of", label: "Which size", bare: true, options: () => SIDES_OF, get: () => size()?.[0] ?? side, set: (value) => {
        side = value;
        if (size()) write(size()[1]);
      } }),
      form.number({ id: "object-size", label: "Size in metres", bare: true, unit: "m", min: 0, placeholder: "unknown", get: () => size() && six(size()[1]), set: write })),
  ];
  return { form, body: el("section", { className: "object", "aria-label": "Object" }, ...rows) };
}

function rowOf(desk, i, depth) {
  const part = desk.doc.parts[i];
  const { view } = desk;
  const colour = view?.colourOf(i) ?? desk.palette[i % desk.palette.length];
  const points = (part.point ? 1 : 0) + (part.points?.length ?? 0) + (part.faces ? 1 : 0);
  const isEmpty = view?.counts && desk.keeper.work === null && view.words.includes(part.name) && !view.counts[i];
  const pick = el("button", { type: "button", className: "pick", id: `part-${i}`, "aria-pressed": i === desk.chosen, onclick: () => desk.choose(i), ondblclick: () => view?.lookAt(i) },
    el("span", { className: "swatch" }), el("span", { className: "name" }, part.name),
    el("span", { className: "dim", title: isEmpty ? "No face of the mesh is of this part" : "" }, isEmpty ? "nowhere" : movesHow(part)), points || !part.parent ? null : el("span", { className: "todo", title: "No point on the object yet" }));
  pick.addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step) {
      desk.chooseNext(step);
      queueMicrotask(() => document.getElementById(`part-${desk.chosen}`)?.focus());
    } else if (event.key === "Delete") deletePart(desk, i);
    else return;
    event.preventDefault();
  });
  const isShown = !view?.hidden?.has(i);
  const eye = view ? el("button", { type: "button", className: "icon eye", id: `eye-${i}`, "aria-label": `Show ${part.name}`, "aria-pressed": isShown, onclick: () => {
    view.hide(i, isShown);
    desk.changed();
  } }, icon("eye")) : null;
  return el("li", { style: { "--colour": css(colour), "--depth": depth }, className: i === desk.chosen ? "selected" : "" }, el("div", { className: "row" }, pick, eye));
}

function treeOf(desk) {
  const { parts } = desk.doc;
  const rows = [];
  const seen = new Set();
  const walk = (i, depth) => {
    if (seen.has(i)) return;
    seen.add(i);
    rows.push(rowOf(desk, i, Math.min(depth, 5)));
    parts.forEach((p, k) => p.parent === parts[i].name && k !== i && walk(k, depth + 1));
  };
  parts.forEach((p, i) => !parts.some((q) => q.name === p.parent) && walk(i, 0));
  parts.forEach((_, i) => walk(i, 0));
  return rows;
}

function addRow(desk) {
  const input = el("input", { type: "text", id: "new-part", placeholder: "Add a part…", autocomplete: "off", spellcheck: false, "aria-label": "Name of a new part" });
  const add = () => {
    if (!input.value.trim()) return input.focus();
    newPart(desk, input.value);
    input.value = "";
  };
  const form = el("form", { className: "adds", onsubmit: (event) => {
    event.preventDefault();
    add();
    desk.view?.canvas.focus();
  } }, input, el("button", { type: "submit", className: "icon", id: "add-part", title: "Add a part (a)", "aria-label": "Add a part" }, icon("plus")));
  input.addEventListener("keydown", (event) => {
    if (event.key === "Escape") desk.view?.canvas.focus();
  });
  return form;
}

const listOf = (name, words) => el("section", { className: "faults", role: "status", "aria-label": name }, el("h3", {}, name), ...words.map((text) => el("p", {}, text)));

/** What is wrong with the condition; where nothing is, what was noticed of its parts. */
function faultList(desk) {
  const { faults } = desk.keeper;
  if (!desk.doc.parts.length) return [];
  if (faults.length) return [listOf("Not right yet", faults.map((f) => f.message))];
  const told = desk.notes.map(({ part, message }) => (part && !message.includes(part) ? `${part}: ${message}` : message));
  return told.length ? [listOf("Noticed", [...new Set(told)].slice(0, 8))] : [];
}

/** Fills the panel and keeps it. */
export function sidePanel(desk, root) {
  const { form, body } = objectForm(desk);
  const list = el("ul", { className: "parts", "aria-label": "Parts" });
  const faults = el("div", {});
  root.append(body, el("div", { className: "scroll" }, list, addRow(desk), faults));
  let shown = "";
  desk.listen(() => {
    form.follow();
    const key = JSON.stringify([desk.doc.parts, desk.chosen, [...(desk.view?.hidden ?? [])], desk.view?.counts, desk.keeper.work === null]);
    if (key !== shown) refill(list, ...treeOf(desk));
    shown = key;
    faults.replaceChildren(...faultList(desk));
  });
}

