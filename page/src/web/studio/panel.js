// The chosen part: the panel at the right.
import { css, el, icon } from "../dom.js";
import { aside } from "../maths.js";
import { figure } from "../view.js";
import { correct, isBelow, kindsOf, pointsOf, put, rename, saidOf, setKinds, tidy, turnsAt } from "./edits.js";
import { Form, refill } from "./fields.js";
import { jointCard } from "./jointcard.js";
import { deletePart } from "./side.js";

const KINDS = [["", "not: fixed"], ["revolute", "turns (revolute)"], ["continuous", "spins (continuous)"], ["prismatic", "slides (prismatic)"]];
const MATERIALS = ["oak", "wood", "plywood", "steel", "stainless steel", "aluminium", "brass", "plastic", "rubber", "glass", "ceramic", "fabric", "leather"];

function nameField(desk, form) {
  return form.text({ id: "part-name", label: "Name", get: () => desk.part()?.name, set: (value) => {
    const { doc, chosen } = desk;
    const isTaken = doc.parts.some((p, i) => i !== chosen && p.name === value);
    if (!/^[A-Za-z_][A-Za-z0-9_]*$/.test(value) || isTaken) return false;
    const before = doc.parts[chosen].name;
    if (before !== value) desk.view?.renames(before, value);
    desk.found.forEach((j) => j.part === before && (j.part = value));
    desk.store.edit(`${before}: named ${value}`, (next) => rename(next, chosen, value), { field: `name ${chosen}`, typing: true });
    return true;
  } });
}

function identity(desk, form) {
  const { doc } = desk;
  const field = (name) => `${name} ${desk.chosen}`;
  const parent = form.select({ id: "part-parent", label: "Hangs on", get: () => desk.part()?.parent ?? "",
    options: () => [["", "nothing: it is the base"], ...desk.doc.parts.filter((p) => p !== desk.part() && !isBelow(desk.doc, desk.chosen, p.name)).map((p) => [p.name, p.name])],
    set: (value) => desk.editPart(value ? `hangs on ${value}` : "is the base", (part) => {
      put(part, "parent", value);
      if (!value) setKinds(part, []);
    }) });
  const text = form.text({ id: "part-text", label: "In words", placeholder: doc.parts[desk.chosen].name.replaceAll("_", " "), get: () => desk.part()?.text ?? "",
    set: (value, typing) => desk.editPart("described", (part) => put(part, "text", value), { field: field("text"), typing }) || true });
  return [nameField(desk, form), text, parent];
}

/** Two joints of one kind need an axis each: the one that is known, and one across it to begin with. */
function twoWays(desk, kinds) {
  const j = desk.modelJoint(0);
  if (kinds.length < 2 || j < 0 || turnsAt(kinds[0]) !== turnsAt(kinds[1])) return [];
  const { axis, child } = desk.view.model.joints[j];
  const pivot = turnsAt(kinds[0]) ? { pivot: desk.body.fileOf(desk.view.scene.homes[child]) } : {};
  return [axis, aside(axis)].map((way) => ({ axis: desk.body.fileOf(way), ...pivot }));
}

function kindRows(desk, form) {
  const part = desk.part();
  if (!part.parent) return [];
  const kinds = () => kindsOf(desk.part() ?? {});
  const set = (k, value) => {
    const next = [...kinds()];
    if (value) next[k] = value;
    else next.splice(k, 1);
    const ways = twoWays(desk, next);
    desk.editPart(`joint ${value || "fixed"}`, (p) => {
      setKinds(p, next);
      ways.forEach((way, i) => saidOf(p, i).axis ?? correct(p, i, way));
    });
    desk.choose(desk.chosen, Math.min(k, Math.max(next.length - 1, 0)));
  };
  const row = (k, label, options) => form.select({ id: `part-kind-${k}`, label, options: () => options, get: () => kinds()[k] ?? "", set: (value) => set(k, value) });
  const rows = [row(0, "Moves", KINDS)];
  if (kinds().length) rows.push(row(1, "And", [["", "no second joint"], ...KINDS.slice(1)]));
  return rows;
}

function pointList(desk) {
  const part = desk.part();
  const list = pointsOf(part);
  const rows = list.map((p, i) => {
    const isNot = p.list === "not";
    return el("li", {}, el("span", { className: isNot ? "badge not" : "badge" }, isNot ? "not" : "is"), el("span", { className: "figures" }, p.at.map((x) => figure(x)).join("  ")),
      el("button", { type: "button", className: "icon", id: `point-${i}-delete`, "aria-label": `Delete point ${i + 1}`, onclick: () => desk.removePoint(p) }, icon("close")));
  });
  const painted = desk.paintedCount(part);
  if (painted) {
    rows.push(el("li", {}, el("span", { className: "badge" }, "is"), el("span", { className: "figures" }, `${painted} painted ${painted === 1 ? "face" : "faces"}`),
      el("button", { type: "button", className: "icon", id: "unpaint", "aria-label": "Take the paint off", onclick: () => desk.editPart("paint taken off", (p, doc) => {
        delete p.faces;
        tidy(doc);
      }) }, icon("close"))));
  }
  const none = desk.view ? `Click on ${part.name} on the model to say where it is.` : "No point yet.";
  return el("section", { "aria-label": "Where it is" }, el("h3", {}, "Where it is"),
    rows.length ? el("ul", { className: "points" }, ...rows) : el("p", { className: "dim" }, none));
}

function matter(desk, form) {
  const positive = (field, words) => (value) => {
    if (value !== null && !(value > 0)) return false;
    desk.editPart(words, (part) => put(part, field, value));
    return true;
  };
  const material = form.text({ id: "part-material", label: "Material", placeholder: "usual for its kind", get: () => desk.part()?.material ?? "",
    set: (value, typing) => desk.editPart("material set", (part) => put(part, "material", value), { field: `material ${desk.chosen}`, typing }) || true });
  material.querySelector("input").setAttribute("list", "materials");
  return el("section", { "aria-label": "What it is made of" }, el("h3", {}, "What it is made of"), material,
    el("datalist", { id: "materials" }, ...MATERIALS.map((value) => el("option", { value }))),
    form.number({ id: "part-mass", label: "Mass", unit: "kg", min: 0, placeholder: "from material", get: () => desk.part()?.mass, set: positive("mass", "mass set") }));
}

/** What decides which fields there are. */
const shapeOf = (desk) => {
  const part = desk.part();
  return JSON.stringify(part ? [desk.chosen, kindsOf(part), part.point, part.points, part.not, part.faces, Boolean(part.parent)] : null);
};

function fill(desk, root) {
  const form = new Form();
  const part = desk.part();
  if (!part) {
    refill(root, el("p", { className: "dim empty" }, desk.doc.parts.length ? "Choose a part, or add one." : "The parts of the object appear here."));
    return form;
  }
  const kinds = part.parent ? kindsOf(part) : [];
  root.style.setProperty("--colour", css(desk.view?.colourOf(desk.chosen) ?? desk.palette[desk.chosen % desk.palette.length]));
  const title = el("h2", { className: "title" }, el("span", { className: "swatch" }), el("span", {}));
  form.add(() => title.lastChild.replaceChildren(desk.part()?.name ?? ""));
  const bin = el("button", { type: "button", className: "icon", id: "delete-part", title: "Delete this part", "aria-label": `Delete ${part.name}`, onclick: () => deletePart(desk) }, icon("bin"));
  refill(root, el("div", { className: "row head" }, title, bin), el("section", { "aria-label": "Part" }, ...identity(desk, form), ...kindRows(desk, form)),
    ...kinds.map((kind, k) => jointCard(desk, form, kind, k)), pointList(desk), matter(desk, form));
  return form;
}

/** Fills the panel and keeps it. */
export function partPanel(desk, root) {
  let shown = null;
  let form = null;
  desk.listen(() => {
    const shape = shapeOf(desk);
    if (shape !== shown) form = fill(desk, root);
    else form.follow();
    shown = shape;
  });
  desk.view?.listen(() => form?.moved?.());
}
