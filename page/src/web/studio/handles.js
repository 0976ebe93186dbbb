// Handles of the chosen joint: the shaft moves its axis, the tips turn it, the ends of its range are pulled.
import { TAU, add, cross, dot, outside, rotate, scale, size, sub, unit } from "../maths.js";
import { el } from "../dom.js";
import { restOf, saidOf, turnsAt } from "./edits.js";
import { alongLine, angleAbout, fromStretch, likewise, onBall, onPlane, tilt } from "./geometry.js";
import { snapDirection, snapPlace } from "./snaps.js";
import { six } from "./text.js";

/** As many of the lines that were found are drawn. */
const DRAWN = 5;

export class Handles {
  constructor(desk) {
    this.desk = desk;
    this.view = desk.view;
    this.pulled = null;
    this.view.extras.push((frame, theme) => this.draw(frame, theme));
  }

  /** The joint whose handles are shown; −1 for none. */
  joint() {
    const { desk } = this;
    return desk.tool === "point" && desk.chosen >= 0 ? desk.modelJoint() : -1;
  }

  /** Where the parts of its arrow are now. */
  arrow(j = this.joint()) {
    if (j < 0) return null;
    const { model, marks } = this.view;
    const { parent } = model.joints[j];
    const place = marks.places[j];
    const frame = model.frame(j, model.poses()[parent]);
    const way = rotate(frame.turn, place.axis);
    const isHinge = model.turns(j);
    const [low, high] = model.ends(j);
    const length = isHinge ? place.long + 0.06 * model.diagonal : Math.max(0.35 * (high - low), 0.14 * model.diagonal);
    const start = outside(frame, place.at);
    const centre = isHinge ? outside(frame, place.on) : add(start, scale(way, model.value(j)));
    const foot = isHinge ? add(centre, scale(way, -0.5 * length)) : centre;
    const onArc = (angle) => outside(frame, marks.onArc(place, angle, place.radius));
    const end = (value) => (isHinge ? onArc(value) : add(start, scale(way, value)));
    return { j, way, isHinge, length, centre, foot, start, tip: add(foot, scale(way, length)), end, across: rotate(frame.turn, place.across), low, high, frame };
  }

  /** Handles as buttons over the picture. */
  source() {
    const arrow = this.pulled?.arrow ?? this.arrow();
    if (!arrow) return [];
    const joint = this.view.model.joints[arrow.j];
    const one = (key, at, words, title) => ({ key: `handle ${key}`, at, make: () => this.button(key), update: (button) => {
      button.setAttribute("aria-label", `${joint.name}: ${words}`);
      button.title = title;
      button.classList.toggle("pulled", this.pulled?.what === key);
    } });
    const list = [one("tip", arrow.tip, "tip of the axis", "Pull to turn the axis. Alt: no snapping")];
    if (arrow.isHinge) list.push(one("foot", arrow.foot, "foot of the axis", "Pull to turn the axis. Alt: no snapping"), one("shaft", arrow.centre, "place of the axis", "Pull to move the axis. Alt: no snapping"));
    if (joint.kind !== "continuous") {
      list.push(one("low", arrow.end(arrow.low), "lower end", "Pull the lower end"), one("high", arrow.end(arrow.high), "upper end", "Pull the upper end"));
    }
    return this.pulled ? list : [...list, ...this.candidates(arrow)];
  }

  /** Numbers at the lines that were found. */
  candidates(arrow) {
    return this.lines(arrow).map(({ to, score, i }) => ({
      key: `candidate ${i}`, at: to,
      make: () => el("button", { type: "button", className: "candidate", onclick: () => takeCandidate(this.desk, i), onpointerenter: () => this.points(i), onpointerleave: () => this.points(-1) }),
      update: (button) => {
        button.textContent = i + 1;
        button.setAttribute("aria-label", `Take found line ${i + 1}, score ${score.toFixed(2)}`);
        button.title = `Found line ${i + 1}, score ${score.toFixed(2)}: click to take it`;
        button.style.setProperty("--score", score);
      },
    }));
  }

  points(i) {
    this.desk.candidate = i;
    this.view.changed();
  }

  /** The best lines that were found, but for the one that is taken. */
  lines(arrow) {
    const { desk, view } = this;
    const { model } = view;
    const joint = model.joints[arrow.j];
    const box = view.partBoxes[joint.part];
    const middle = scale(add(box.low, box.high), 0.5);
    const home = view.scene.homes[joint.child];
    const all = joint.candidates ?? [];
    return all.map((c, i) => ({ ...c, i })).slice(0, Math.max(DRAWN, desk.candidate + 1)).filter(({ axis, pivot, i }) => {
      const isSame = tilt(unit(axis), joint.axis) < 0.01 && (!arrow.isHinge || size(cross(sub(pivot, home), unit(axis))) < 0.005 * model.diagonal);
      return !isSame && (i < DRAWN || i === desk.candidate);
    }).map((c) => {
      const way = unit(c.axis);
      const on = arrow.isHinge ? add(c.pivot, scale(way, dot(sub(middle, c.pivot), way))) : middle;
      const half = scale(way, 0.28 * model.diagonal);
      return { ...c, from: sub(on, half), to: add(on, half) };
    });
  }

  draw(frame, theme) {
    const arrow = this.arrow();
    if (!arrow) return;
    const rgb = theme.lift > 1 ? [0.62, 0.78, 1] : [0.1, 0.32, 0.66];
    const { snapped, what } = this.pulled ?? {};
    if (what !== "low" && what !== "high") {
      for (const { from, to, score, i } of this.lines(arrow)) {
        const isPointed = i === this.desk.candidate;
        frame.lines.push([from, to, [...rgb, isPointed ? 1 : 0.12 + 0.3 * score], isPointed ? 3 : 1.5]);
      }
    }
    if (snapped?.line) frame.rings.push([...snapped.line, [...theme.mark, 1], 4]);
    if (snapped && !snapped.line && (what === "tip" || what === "foot" || what === "shaft")) {
      const reach = scale(arrow.way, 0.7 * this.view.model.diagonal);
      frame.rings.push([sub(arrow.centre, reach), add(arrow.centre, reach), [...theme.mark, 0.8], 2]);
    }
  }

  button(what) {
    const button = el("button", { type: "button", className: `handle ${what}`, id: `handle-${what}` });
    button.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      button.setPointerCapture(event.pointerId);
      button.focus();
      this.grab(what, this.place(event));
      event.preventDefault();
      event.stopPropagation();
    });
    button.addEventListener("pointermove", (event) => this.pulled && this.move(this.place(event), event.altKey));
    for (const name of ["pointerup", "pointercancel"]) button.addEventListener(name, () => this.drop(name === "pointercancel"));
    button.addEventListener("keydown", (event) => this.nudge(what, event));
    return button;
  }

  place(event) {
    const box = this.view.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  /** A press on the shaft itself, between its handles; whether it was taken. */
  press(at) {
    const arrow = this.arrow();
    if (!arrow?.isHinge) return false;
    const [a, b] = [this.view.onScreen(arrow.foot), this.view.onScreen(arrow.tip)];
    if (!a || !b || fromStretch(at, a, b) > 6) return false;
    this.grab("shaft", at);
    return true;
  }

  grab(what, at) {
    const { view } = this;
    if (!this.arrow()) return;
    view.stop();
    if (what === "low" || what === "high") {
      const joint = view.model.joints[this.joint()];
      for (let l = joint.parent; l >= 0 && view.model.above[l] >= 0; l = view.model.joints[view.model.above[l]].parent) view.model.values[view.model.above[l]] = 0;
    } else view.model.values.fill(0);
    const arrow = this.arrow();
    if (!arrow) return;
    const joint = view.model.joints[arrow.j];
    this.pulled = { what, arrow, at, begun: arrow, before: { axis: joint.axis, range: joint.range, pivot: view.scene.homes[joint.child] }, value: what === "low" ? arrow.low : arrow.high, moved: false };
    this.desk.pulling = true;
    view.changed();
  }

  move(at, isFree) {
    const { pulled } = this;
    if (!pulled.moved && Math.hypot(at[0] - pulled.at[0], at[1] - pulled.at[1]) < 3) return;
    pulled.moved = true;
    if (pulled.what === "low" || pulled.what === "high") this.pullEnd(at, isFree);
    else if (pulled.what === "shaft") this.pullShaft(at, isFree);
    else this.pullTip(at, isFree);
    pulled.arrow = this.arrow(pulled.arrow.j);
    this.desk.said = pulled.words ?? "";
    this.desk.changed();
    this.view.changed();
  }

  pullTip(at, isFree) {
    const { pulled, view } = this;
    const { begun } = pulled;
    const { isHinge, length } = begun;
    const centre = isHinge ? begun.centre : begun.foot;
    const radius = isHinge ? length / 2 : length;
    const sign = pulled.what === "foot" ? -1 : 1;
    const ray = view.rayAt(at);
    const before = pulled.axis ?? begun.way;
    const ways = [true, false].map((isNear) => scale(onBall(centre, radius, ray, isNear), sign));
    let axis = dot(ways[0], before) >= dot(ways[1], before) ? ways[0] : ways[1];
    const offer = isFree ? null : snapDirection(view, view.model.joints[begun.j].candidates ?? [], centre, axis, at);
    if (offer) axis = offer.axis;
    Object.assign(pulled, { axis, pivot: isHinge ? offer?.pivot ?? centre : null, snapped: offer, words: `${offer ? `Snapped: ${offer.words}` : "Turning the axis freely"}, ${figureOf(between(begun.way, axis), true)} from before` });
    view.pull(begun.j, { axis, pivot: pulled.pivot });
    // The arrow keeps its length and turns about its middle while it is pulled.
    if (isHinge) Object.assign(view.marks.places[begun.j], { on: [0, 0, 0], long: length - 0.06 * view.model.diagonal });
  }

  pullShaft(at, isFree) {
    const { pulled, view } = this;
    const { begun } = pulled;
    const facing = view.camera.axes().z;
    const [from, to] = [pulled.at, at].map((p) => onPlane(begun.centre, facing, view.rayAt(p)));
    const free = sub(to, from);
    const moved = sub(free, scale(begun.way, dot(free, begun.way)));
    const centre = add(begun.centre, moved);
    const offer = isFree ? null : snapPlace(view, view.model.joints[begun.j].candidates ?? [], centre, begun.way, at);
    const pivot = offer?.pivot ?? centre;
    Object.assign(pulled, { axis: offer?.axis ?? begun.way, pivot, snapped: offer, turned: Boolean(offer?.axis), words: `${offer ? `Snapped: ${offer.words}` : "Moving the axis freely"}, ${figureOf(this.shifted(pivot, begun), false)} from before` });
    view.pull(begun.j, { axis: pulled.axis, pivot: pulled.pivot });
  }

  /** How far the axis was moved across where it was, metres. */
  shifted(pivot, { centre, way }) {
    const moved = sub(pivot, centre);
    return this.desk.keeper.scale * size(sub(moved, scale(way, dot(moved, way))));
  }

  pullEnd(at, isFree) {
    const { pulled, view, desk } = this;
    const { begun, what } = pulled;
    const turns = begun.isHinge;
    const raw = turns ? this.angleAt(at) : alongLine(begun.start, begun.way, view.rayAt(at));
    if (raw === null) return;
    const unitOf = turns ? Math.PI / 180 : 0.001 / desk.keeper.scale;
    let value = isFree ? raw : Math.round(raw / unitOf) * unitOf;
    const near = turns ? 4 * unitOf : 0.012 * view.model.diagonal;
    const isShown = !isFree && Math.abs(raw) < near;
    if (isShown) value = 0;
    const [low, high] = what === "low" ? [Math.min(value, begun.high), begun.high] : [begun.low, Math.max(value, begun.low)];
    pulled.range = [low, high];
    const end = what === "low" ? low : high;
    const rest = restOf(saidOf(desk.part(), desk.joint), turns);
    const shown = turns ? end + rest : end * desk.keeper.scale + rest;
    pulled.words = `${what === "low" ? "Lower" : "Upper"} end ${figureOf(shown, turns)}${isShown ? ", as shown" : ""}`;
    view.pull(begun.j, { range: pulled.range });
    view.model.values[begun.j] = end;
  }

  /** The angle under the pointer, going on from where it was. */
  angleAt(at) {
    const { pulled, view } = this;
    const { begun } = pulled;
    const ray = view.rayAt(at);
    const flat = Math.abs(dot(begun.way, ray.way)) > 0.12 ? onPlane(begun.centre, begun.way, ray) : null;
    const p = flat ?? onPlane(begun.centre, view.camera.axes().z, ray);
    const off = sub(p, begun.centre);
    const across = sub(off, scale(begun.way, dot(off, begun.way)));
    if (size(across) < 1e-9) return null;
    const angle = angleAbout(begun.way, begun.across, across);
    pulled.value += Math.atan2(Math.sin(angle - pulled.value), Math.cos(angle - pulled.value));
    pulled.value = Math.min(Math.max(pulled.value, -TAU), TAU);
    return pulled.value;
  }

  drop(isCancelled) {
    const { pulled, view, desk } = this;
    if (!pulled) return;
    this.pulled = null;
    desk.pulling = false;
    desk.said = "";
    view.changed();
    desk.changed();
    if (!pulled.moved) return;
    if (isCancelled) return view.pull(pulled.begun.j, pulled.before);
    if (pulled.range) return writeEnds(desk, pulled.range, pulled.begun.isHinge);
    const fields = {};
    if (pulled.what !== "shaft" || pulled.turned) fields.axis = desk.body.fileOf(pulled.axis);
    if (pulled.pivot && pulled.begun.isHinge) fields.pivot = desk.body.fileOf(pulled.pivot);
    desk.correct(pulled.what === "shaft" ? "axis moved" : "axis turned", fields);
    desk.say(pulled.snapped ? `Axis ${pulled.snapped.words}` : "Axis set");
  }

  /** Arrow keys on a handle. */
  nudge(what, event) {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (event.key === "Escape" && this.pulled) return this.drop(true);
    if (!step || !this.arrow()) return;
    event.preventDefault();
    event.stopPropagation();
    const fine = event.shiftKey ? 0.2 : 1;
    const arrow = this.arrow();
    const { x, y } = this.view.camera.axes();
    const push = add(scale(x, step[0]), scale(y, step[1]));
    const { desk } = this;
    if (what === "low" || what === "high") {
      const by = (step[0] + step[1]) * fine * (arrow.isHinge ? Math.PI / 36 : 0.01 / desk.keeper.scale);
      const range = what === "low" ? [Math.min(arrow.low + by, arrow.high), arrow.high] : [arrow.low, Math.max(arrow.high + by, arrow.low)];
      return writeEnds(desk, range, arrow.isHinge);
    }
    this.view.rest();
    const at = this.arrow();
    if (what === "shaft") {
      const moved = scale(push, 0.01 * fine * this.view.model.diagonal);
      const across = sub(moved, scale(at.way, dot(moved, at.way)));
      return desk.correct("axis moved", { pivot: desk.body.fileOf(add(at.centre, across)) }, { field: "nudge" });
    }
    const sign = what === "foot" ? -1 : 1;
    const axis = unit(add(at.way, scale(push, 0.05 * fine * sign)));
    return desk.correct("axis turned", { axis: desk.body.fileOf(axis), ...(at.isHinge ? { pivot: desk.body.fileOf(at.centre) } : {}) }, { field: "nudge" });
  }
}

/** The angle between two unit vectors, radians. */
const between = (a, b) => Math.atan2(size(cross(a, b)), dot(a, b));

/** Degrees or millimetres in words. */
export const figureOf = (value, turns) => (turns ? `${Number(((value * 180) / Math.PI).toFixed(1)) || 0}°` : `${Number((value * 1000).toFixed(1)) || 0} mm`);

/** Writes ends that are measured from the shown pose, in the model's units. */
export function writeEnds(desk, [low, high], turns, more = {}) {
  const rest = restOf(saidOf(desk.part(), desk.joint), turns);
  const metres = turns ? 1 : desk.keeper.scale;
  desk.correct("range set", { range: [low, high].map((end) => six(end * metres + rest)) }, { field: "range", ...more });
}

/** Takes one of the lines that were found as the axis. */
export function takeCandidate(desk, i) {
  const j = desk.modelJoint();
  const joint = desk.view.model.joints[j];
  const line = joint?.candidates[i];
  if (!line) return;
  const axis = likewise(unit(line.axis), joint.axis);
  const turns = turnsAt(joint.kind);
  desk.candidate = -1;
  desk.correct(`found line ${i + 1} taken`, { axis: desk.body.fileOf(axis), ...(turns ? { pivot: desk.body.fileOf(line.pivot) } : {}) });
  desk.say(`Found line ${i + 1} is the axis now`);
}

