// The links, as a tree.
import { css, el, factList, icon } from "./dom.js";
import { figure } from "./view.js";

function part(view, l, depth) {
  const { name, facts, colour, inertial, visual, collisions } = view.scene.links[l];
  const eye = el("button", { type: "button", className: "icon", "aria-label": `Show ${name}`, "aria-pressed": "true", onclick: () => view.hide(l, !view.hidden.has(l)) }, icon("eye"));
  const pick = el("button", { type: "button", className: "pick", onclick: () => view.select(view.selected === l ? -1 : l), ondblclick: () => view.lookAt(l) },
    el("span", { className: "swatch" }), el("span", { className: "name" }, name), inertial ? el("span", { className: "dim" }, `${figure(inertial.mass)} kg`) : null);
  const counts = [visual ? `${visual.faces} faces` : "nothing to see", collisions.length ? `${collisions.length} collision ${collisions.length === 1 ? "piece" : "pieces"}` : "no collision piece"];
  const more = el("div", { className: "more", hidden: true }, el("p", { className: "dim" }, counts.join(" · ")), factList(facts));
  const row = el("li", { style: { "--colour": css(colour), "--depth": depth } }, el("div", { className: "row" }, pick, eye), more);
  view.listen(() => {
    const shown = !view.hidden.has(l);
    eye.setAttribute("aria-pressed", shown);
    row.classList.toggle("hidden", !shown);
    row.classList.toggle("selected", view.selected === l);
    pick.setAttribute("aria-pressed", view.selected === l);
    more.hidden = view.selected !== l;
  });
  return row;
}

/** The list of links. */
export function partList(view) {
  const { model } = view;
  const depth = (l) => (model.above[l] < 0 ? 0 : 1 + depth(model.joints[model.above[l]].parent));
  const rows = [];
  const walk = (l) => {
    rows.push(part(view, l, Math.min(depth(l), 6)));
    model.joints.filter((joint) => joint.parent === l).forEach((joint) => walk(joint.child));
  };
  model.links.forEach((_, l) => model.above[l] < 0 && walk(l));
  return { count: model.links.length, body: el("ul", { className: "parts" }, ...rows) };
}
