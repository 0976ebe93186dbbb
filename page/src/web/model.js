// Links, joints and their poses.
import { STILL, about, add, clamp, corners, dot, emptyBox, grow, isBox, middle, outside, rotate, scale, size, sub, unit, within } from "./maths.js";

/** A range for joints whose file gives none, in radians. */
const UNSAID = Math.PI;

export class Model {
  /** `boxes` has the box of each link in its own frame. */
  constructor(scene, boxes) {
    this.links = scene.links;
    this.joints = scene.joints;
    this.boxes = boxes;
    this.values = new Float64Array(this.joints.length);
    this.above = this.links.map(() => -1);
    this.joints.forEach((joint, j) => {
      this.above[joint.child] = j;
    });
    this.order = this.rootFirst();
    this.box = this.boxAt(this.poses());
    this.diagonal = Math.max(size(sub(this.box.high, this.box.low)), 1e-6);
  }

  /** All links, each parent before its children; what hangs on no root comes last. */
  rootFirst() {
    const order = this.links.map((_, l) => l).filter((l) => this.above[l] < 0);
    const below = this.links.map(() => []);
    this.joints.forEach((joint) => below[joint.parent].push(joint.child));
    for (let i = 0; i < order.length && order.length <= this.links.length; i++) order.push(...below[order[i]]);
    return order;
  }

  /** The joints that a person can move. */
  movable() {
    return this.joints.map((_, j) => j).filter((j) => this.moves(j) && !this.joints[j].mimic);
  }

  moves(j) {
    return ["revolute", "continuous", "prismatic"].includes(this.joints[j].kind);
  }

  turns(j) {
    return this.joints[j].kind !== "prismatic";
  }

  /** The ends of a joint; where the file gives none, ends to play with. */
  ends(j) {
    const { kind, range } = this.joints[j];
    if (kind === "continuous") return [-Math.PI, Math.PI];
    if (range && range[0] <= range[1]) return range;
    if (range) return [range[1], range[0]];
    return kind === "prismatic" ? [0, (this.diagonal ?? 1) / 2] : [-UNSAID, UNSAID];
  }

  /** The same with the pose as the file has it, where that lies outside. */
  reach(j) {
    const [low, high] = this.ends(j);
    return [Math.min(low, 0), Math.max(high, 0)];
  }

  value(j, depth = 0) {
    const mimic = this.joints[j].mimic;
    if (!mimic || depth > this.joints.length) return this.values[j];
    return mimic.factor * this.value(mimic.joint, depth + 1) + mimic.offset;
  }

  set(j, value) {
    const [low, high] = this.reach(j);
    this.values[j] = clamp(value, low, high);
  }

  /** Where joint j has its frame, before it moves, given where its parent is. */
  frame(j, parent) {
    const { at, turn } = this.joints[j];
    return within(parent, { at, turn });
  }

  /** The motion of a joint alone. */
  motion(j) {
    const { kind, axis } = this.joints[j];
    const value = this.value(j);
    if (kind === "prismatic") return { at: scale(axis, value), turn: STILL.turn };
    if (kind === "revolute" || kind === "continuous") return { at: STILL.at, turn: about(axis, value) };
    return STILL;
  }

  /** Where every link is. */
  poses() {
    const poses = this.links.map(() => STILL);
    for (const l of this.order) {
      const j = this.above[l];
      if (j >= 0) poses[l] = within(this.frame(j, poses[this.joints[j].parent]), this.motion(j));
    }
    return poses;
  }

  /** How far each link is moved when the object is pulled apart by a share of 0 to 1. */
  apart(poses, share) {
    const offsets = this.links.map(() => [0, 0, 0]);
    if (share <= 0) return offsets;
    const centre = middle(this.box);
    for (const l of this.order) {
      const j = this.above[l];
      if (j < 0) continue;
      const parent = this.joints[j].parent;
      offsets[l] = offsets[parent];
      if (!isBox(this.boxes[l])) continue;
      const own = outside(poses[l], middle(this.boxes[l]));
      const other = isBox(this.boxes[parent]) ? outside(poses[parent], middle(this.boxes[parent])) : centre;
      let away = sub(own, other);
      if (size(away) < 0.02 * this.diagonal) away = sub(own, centre);
      const way = this.wayOut(j, poses, own, away);
      const extent = size(sub(this.boxes[l].high, this.boxes[l].low)) / this.diagonal;
      const length = share * this.diagonal * (0.14 + 0.3 * Math.min(extent, 1));
      offsets[l] = add(offsets[parent], scale(unit(way, [0, -1, 0]), length));
    }
    return offsets;
  }

  /** Where a part goes when it is pulled off: a slide along its way, a wheel along its axle, the rest away from what holds it. */
  wayOut(j, poses, own, away) {
    if (!this.moves(j)) return away;
    const frame = this.frame(j, poses[this.joints[j].parent]);
    const axis = rotate(frame.turn, unit(this.joints[j].axis));
    const [low, high] = this.ends(j);
    if (!this.turns(j)) return scale(axis, Math.abs(high) >= Math.abs(low) ? 1 : -1);
    const arm = sub(own, frame.at);
    const off = sub(arm, scale(axis, dot(arm, axis)));
    const box = this.boxes[this.joints[j].child];
    const lengthwise = scale(axis, dot(away, axis));
    if (size(off) < 0.12 * size(sub(box.high, box.low)) && size(lengthwise) > 0.2 * size(away)) return lengthwise;
    const across = sub(away, lengthwise);
    return size(across) > 0.1 * size(away) ? across : away;
  }

  /** The box of all that is seen. */
  boxAt(poses) {
    const box = emptyBox();
    this.boxes.forEach((own, l) => {
      if (isBox(own)) corners(own).forEach((p) => grow(box, outside(poses[l], p)));
    });
    if (!isBox(box)) poses.forEach((pose) => grow(box, pose.at));
    if (!isBox(box)) grow(box, [0, 0, 0]);
    return box;
  }

  mass() {
    return this.links.reduce((sum, l) => sum + (l.inertial ? l.inertial.mass : 0), 0);
  }
}
