// Arrows, arcs, balls and boxes: what is known about an object and is no surface of it.
import { TAU, about, add, along, aside, clamp, corners, dot, isBox, matrix, middle, outside, rotate, scale, size, sub, unit, within } from "./maths.js";
import { bar, cone, cube, flat, sphere } from "./shapes.js";

const ARC_STEPS = 64;

export class Marks {
  constructor(renderer, model) {
    this.renderer = renderer;
    [this.bar, this.cone, this.ball, this.box] = [bar, cone, sphere, cube].map((make) => renderer.mesh(make()));
    this.fans = [];
    this.of(model);
  }

  /** Whose marks they are. */
  of(model) {
    this.model = model;
    this.fans.forEach((fan) => this.renderer.forget(fan));
    this.places = model.joints.map((_, j) => this.placeOf(j));
    this.fans = model.joints.map((_, j) => this.fanOf(j));
  }

  /** A joint is not as it was. */
  again(j) {
    this.renderer.forget(this.fans[j]);
    this.places[j] = this.placeOf(j);
    this.fans[j] = this.fanOf(j);
  }

  /** The middle of what a joint moves, in the frame of its child. */
  middleBelow(j) {
    const { model } = this;
    let link = model.joints[j].child;
    let pose = { at: [0, 0, 0], turn: [0, 0, 0, 1] };
    for (let depth = 0; depth < 8; depth++) {
      if (isBox(model.boxes[link])) return { at: outside(pose, middle(model.boxes[link])), box: model.boxes[link] };
      const next = model.joints.findIndex((joint) => joint.parent === link);
      if (next < 0) break;
      pose = model.frame(next, pose);
      link = model.joints[next].child;
    }
    return { at: [0, 0, 0], box: null };
  }

  /** Where a joint's marks stand, in its frame: the point of the axis, the way to its part, sizes. */
  placeOf(j) {
    const { model } = this;
    const axis = unit(model.joints[j].axis);
    const { at, box } = this.middleBelow(j);
    const foot = scale(axis, dot(at, axis));
    // A pivot that a person set stays where it was set.
    const on = model.joints[j].anchored ? [0, 0, 0] : foot;
    const off = sub(at, foot);
    const d = model.diagonal;
    const across = size(off) > 0.01 * d ? unit(off) : aside(axis);
    const spans = box ? corners(box).map((p) => dot(p, axis)) : [0, 0];
    const long = Math.max(...spans) - Math.min(...spans);
    return { axis, on, at, across, radius: clamp(size(off), 0.09 * d, 0.45 * d), long: clamp(0.62 * long, 0.08 * d, 0.6 * d) };
  }

  /** A point of the arc of a joint, in its frame. */
  onArc(place, angle, radius) {
    return add(place.on, scale(rotate(about(place.axis, angle), place.across), radius));
  }

  fanOf(j) {
    if (!this.model.moves(j) || !this.model.turns(j)) return null;
    const place = this.places[j];
    const [low, high] = this.model.ends(j);
    const span = Math.min(high - low, TAU);
    const triangles = [];
    for (let i = 0; i < ARC_STEPS; i++) {
      const [a, b] = [i, i + 1].map((k) => this.onArc(place, low + (span * k) / ARC_STEPS, place.radius));
      triangles.push(...place.on, ...a, ...b);
    }
    return this.renderer.mesh(flat(triangles));
  }

  arrow(into, from, way, length, thick, tint) {
    const tip = Math.min(6 * thick, 0.5 * length);
    const base = add(from, scale(way, length - tip));
    into.marks.push({ mesh: this.bar, matrix: along(from, way, thick, length - tip), tint, alpha: 1 });
    into.marks.push({ mesh: this.cone, matrix: along(base, way, 2.8 * thick, tip), tint, alpha: 1 });
  }

  /** The axis of a joint, and how far it goes. */
  joint(into, j, parent, colour, active) {
    const { model } = this;
    const place = this.places[j];
    const frame = model.frame(j, parent);
    const way = rotate(frame.turn, place.axis);
    const thick = (active ? 0.0055 : 0.004) * model.diagonal;
    const tint = [...colour, 1];
    if (model.turns(j)) this.hinge(into, j, frame, way, thick, tint, active);
    else this.slide(into, j, frame, way, thick, tint, active);
  }

  hinge(into, j, frame, way, thick, tint, active) {
    const { model } = this;
    const place = this.places[j];
    const centre = outside(frame, place.on);
    const length = place.long + 0.06 * model.diagonal;
    this.arrow(into, add(centre, scale(way, -0.5 * length)), way, length, thick, tint);
    const [low, high] = model.ends(j);
    const at = (angle, radius) => outside(frame, this.onArc(place, angle, radius));
    const rgb = tint.slice(0, 3);
    const width = active ? 3 : 2;
    const span = Math.min(high - low, TAU);
    for (let i = 0; i < ARC_STEPS; i++) {
      const [a, b] = [i, i + 1].map((k) => at(low + (span * k) / ARC_STEPS, place.radius));
      into.lines.push([a, b, [...rgb, 0.95], width]);
    }
    if (model.joints[j].kind === "revolute") {
      for (const end of [low, high]) {
        into.lines.push([at(end, 0.86 * place.radius), at(end, 1.1 * place.radius), [...rgb, 1], width]);
      }
    }
    into.lines.push([centre, at(model.value(j), place.radius), [...rgb, 1], width]);
    into.marks.push({ mesh: this.ball, matrix: matrix({ at: at(model.value(j), place.radius), turn: [0, 0, 0, 1] }, Array(3).fill(2.2 * thick)), tint, alpha: 1 });
    if (this.fans[j]) into.marks.push({ mesh: this.fans[j], matrix: matrix(frame), tint, alpha: active ? 0.26 : 0.14, plain: true });
  }

  slide(into, j, frame, way, thick, tint, active) {
    const { model } = this;
    const place = this.places[j];
    const [low, high] = model.ends(j);
    const start = outside(frame, place.at);
    const at = (value) => add(start, scale(way, value));
    const rgb = tint.slice(0, 3);
    const width = active ? 3 : 2;
    into.lines.push([at(low), at(high), [...rgb, 0.95], width]);
    const cross = [aside(way)];
    cross.push(unit([way[1] * cross[0][2] - way[2] * cross[0][1], way[2] * cross[0][0] - way[0] * cross[0][2], way[0] * cross[0][1] - way[1] * cross[0][0]]));
    for (const end of [low, high]) {
      for (const side of cross) {
        const tick = scale(side, 0.03 * model.diagonal);
        into.lines.push([add(at(end), tick), sub(at(end), tick), [...rgb, 1], width]);
      }
    }
    const length = Math.max(0.35 * (high - low), 0.14 * model.diagonal);
    this.arrow(into, at(model.value(j)), way, length, thick, tint);
    into.marks.push({ mesh: this.ball, matrix: matrix({ at: at(model.value(j)), turn: [0, 0, 0, 1] }, Array(3).fill(2 * thick)), tint, alpha: 1 });
  }

  /** Mass, centre and box of inertia of a link; returns its centre. */
  mass(into, inertial, pose, heaviest, colour) {
    const d = this.model.diagonal;
    const share = Math.cbrt(Math.max(inertial.mass, 0) / Math.max(heaviest, 1e-12));
    const radius = d * (0.008 + 0.016 * share);
    const frame = within(pose, { at: inertial.centre, turn: inertial.turn });
    into.marks.push({ mesh: this.ball, matrix: matrix(frame, [radius, radius, radius]), tint: [...colour, 1], alpha: 1 });
    const box = { low: inertial.half.map((h) => -h), high: inertial.half };
    const points = corners(box).map((p) => outside(frame, p));
    for (let i = 0; i < 8; i++) {
      for (const bit of [1, 2, 4]) {
        if (!(i & bit)) into.lines.push([points[i], points[i | bit], [...colour, 0.7], 1.2]);
      }
    }
    return frame.at;
  }

  /** A cross where the whole object has its centre of mass. */
  whole(into, at, floor, colour) {
    const arm = 0.05 * this.model.diagonal;
    for (const way of [[1, 0, 0], [0, 1, 0], [0, 0, 1]]) {
      into.lines.push([sub(at, scale(way, arm)), add(at, scale(way, arm)), [...colour, 1], 2]);
    }
    into.lines.push([at, [at[0], at[1], floor], [...colour, 0.5], 1.2]);
  }

  /** A place that something was found at: a ball, and rings that face the eye. */
  spot(into, at, camera, colour, pulse) {
    const { x, y } = camera.axes();
    const radius = 0.009 * camera.distance;
    into.spots.push({ mesh: this.ball, matrix: matrix({ at, turn: [0, 0, 0, 1] }, [radius, radius, radius]), tint: [...colour, 1], alpha: 1, plain: true });
    for (const [wide, alpha] of [[2.2, 1], [2.6 + 2.2 * pulse, 1 - pulse]]) {
      const point = (i) => add(at, add(scale(x, Math.cos((TAU * i) / 40) * wide * radius), scale(y, Math.sin((TAU * i) / 40) * wide * radius)));
      for (let i = 0; i < 40; i++) into.rings.push([point(i), point(i + 1), [...colour, alpha], 2.5]);
    }
  }
}
