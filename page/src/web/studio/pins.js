// Points of parts, as pins on the object.
import { css, el, icon } from "../dom.js";
import { size, sub } from "../maths.js";
import { questionPins } from "./question.js";
import { eachFace } from "./text.js";

const keyOf = (p) => `${p.part} ${p.list} ${p.index ?? 0}`;

/** Whether a point is the chosen one. */
const isPin = (desk, p) => desk.pin === keyOf(p);

/** The chosen pin, or nothing. */
export const chosenPin = (desk) => desk.points().find((p) => isPin(desk, p));

function choosePin(desk, p) {
  if (p.part !== desk.chosen) desk.choose(p.part);
  desk.pin = keyOf(p);
  desk.view.changed();
  desk.changed();
}

function pinOf(desk, p) {
  const dot = el("span", { className: "dot" }, p.list === "not" ? icon("close") : "");
  const pick = el("button", { type: "button", className: "pick", onclick: () => choosePin(desk, pick.point) }, dot);
  const bin = el("button", { type: "button", className: "icon bin", "aria-label": "Delete this point", title: "Delete (Del)", onclick: () => desk.removePoint(pick.point) }, icon("bin"));
  const pin = el("div", { className: "pin" }, pick, bin);
  pin.addEventListener("keydown", (event) => {
    if (event.key !== "Delete" && event.key !== "Backspace") return;
    desk.removePoint(pick.point);
    event.preventDefault();
    event.stopPropagation();
  });
  return pin;
}

function update(desk, pin, p, isSeen) {
  const { name } = desk.doc.parts[p.part];
  const pick = pin.firstChild;
  pick.point = p;
  const number = p.list === "point" ? 1 : p.list === "points" ? p.index + 2 : p.index + 1;
  pick.setAttribute("aria-label", p.list === "not" ? `${name}: not here, ${number}` : `${name}: point ${number}`);
  pick.setAttribute("aria-pressed", isPin(desk, p));
  pin.className = `pin ${p.list === "not" ? "not" : ""} ${p.part === desk.chosen ? "own" : ""} ${isSeen ? "" : "behind"} ${isPin(desk, p) ? "chosen" : ""}`;
  pin.style.setProperty("--colour", css(desk.view.colourOf(p.part)));
}

/** All points there are. */
export function pinSource(desk) {
  const { view } = desk;
  return () => {
    if (desk.pulling) return [];
    return desk.points().filter((p) => !view.hidden.has(p.part) && Array.isArray(p.at) && p.at.length === 3).map((p) => {
      const at = view.nowAt(desk.body.objectOf(p.at), p.part);
      return { key: `pin ${keyOf(p)}`, at, make: () => pinOf(desk, p), update: (pin) => update(desk, pin, p, view.isSeen(at)) };
    }).concat(questionPins(desk));
  };
}

/** Brush strokes: faces that become a part's, or lose their paint. */
export class Brush {
  constructor(desk) {
    this.desk = desk;
    this.owner = null;
    this.isErasing = false;
  }

  /** How wide it is on the object where it touches. */
  radius(found) {
    const { view } = this.desk;
    const away = size(sub(found.world, view.camera.eye())) / (view.camera.distance * view.camera.spread);
    return this.desk.brush * view.camera.pixel(view.canvas.clientHeight) * away;
  }

  /** The faces under it: near, on the same side. */
  under(found) {
    const { body, view } = this.desk;
    const radius = this.radius(found);
    const own = body.normal(found.face);
    const { centres } = body.tree;
    const near = body.tree.ball(found.point, radius).filter((f) => {
      const away = size([0, 1, 2].map((k) => centres[3 * f + k] - found.point[k]));
      if (away > radius || view.hidden.has(view.partOf[f])) return false;
      const n = body.normal(f);
      return n[0] * own[0] + n[1] * own[1] + n[2] * own[2] > -0.1;
    });
    return near.includes(found.face) ? near : [found.face, ...near];
  }

  begin(found, isErasing) {
    this.owner = this.desk.body.painted(this.desk.doc);
    this.isErasing = isErasing;
    this.touched = 0;
    this.move(found);
  }

  move(found) {
    const { desk } = this;
    if (!this.owner || !found || desk.chosen < 0) return;
    const faces = this.under(found);
    const name = desk.part().name;
    const shown = [];
    for (const f of faces) {
      for (const g of desk.body.standsFor(f)) {
        const to = this.isErasing ? -1 : desk.chosen;
        if (this.owner[g] === to || (this.isErasing && this.owner[g] !== desk.chosen)) continue;
        this.owner[g] = to;
        this.touched += 1;
        shown.push(f);
      }
    }
    if (!shown.length) return;
    if (!this.isErasing) desk.view.paint(shown, name);
    desk.view.painted();
  }

  end() {
    const { desk, owner, touched } = this;
    this.owner = null;
    if (!touched) return;
    const { name } = desk.part();
    desk.paint(owner, this.isErasing ? `${name}: paint taken off` : `${name}: faces painted`);
  }
}

/** Shown faces that a person painted as a part. */
export function paintedOf(body, part) {
  const faces = new Set();
  eachFace(part.faces, body.all, (g) => faces.add(body.shownOf ? body.shownOf[g] : g));
  return faces;
}
