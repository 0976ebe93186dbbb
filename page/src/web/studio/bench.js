// The object under work: one mesh in groups of faces, a group a part, moved by the joints there are.
import { add, back, clamp, emptyBox, inside, isBox, matrix, outside, rotate, scale, size, sub } from "../maths.js";
import { View } from "../view.js";
import { Rig, boxesOf, carry, sceneOf } from "./rig.js";

const NONE = -1;
const BARE = [186, 192, 202];
/** What unsure faces fade to, light and dark. */
const PALE = { light: [0.97, 0.97, 0.98, 1], dark: [0.36, 0.38, 0.42, 1] };
/** More joints than that are shown only when chosen. */
const MANY_JOINTS = 14;

export class Bench extends View {
  constructor(canvas, body, palette) {
    super(canvas);
    this.body = body;
    this.palette = palette;
    this.whole = this.renderer.mesh(body.surface);
    this.words = [];
    this.face = new Int16Array(body.count).fill(NONE);
    this.sure = new Uint8Array(body.count).fill(255);
    this.found = null;
    this.joints = [];
    this.groups = [];
    this.extras = [];
    this.brush = null;
    this.tag = null;
  }

  colourOf(i) {
    return this.palette[i < this.palette.length ? i : 1 + ((i - this.palette.length) % (this.palette.length - 1))];
  }

  /** What the server says of every shown face. */
  label({ parts, faces, confidence }) {
    this.words = parts;
    this.face.set(faces);
    this.sure.set(confidence);
    this.fades();
  }

  /** A part has another name now. */
  renames(before, name) {
    this.words = this.words.map((word) => (word === before ? name : word));
  }

  /** Faces of a part, at once, before the server says so. */
  paint(faces, name) {
    let at = this.words.indexOf(name);
    if (at < 0) at = this.words.push(name) - 1;
    for (const f of faces) {
      this.face[f] = at;
      this.sure[f] = 255;
    }
  }

  /** How sure each face is, to the card. */
  fades() {
    const { colours } = this.body.surface;
    for (let c = 0; c < 3 * this.body.count; c++) colours[4 * c + 3] = this.sure[Math.floor(c / 3)];
    this.renderer.recolour(this.whole, colours);
  }

  /** Takes a condition; `joints` are those that were found. */
  takesDoc(doc, joints, unit) {
    this.doc = doc;
    this.joints = joints;
    this.unit = unit;
    this.regroup();
    this.rebuild();
  }

  /** Faces of each part; what is of none comes last. */
  regroup() {
    const of = this.words.map((name) => this.doc.parts.findIndex((p) => p.name === name));
    this.partOf = new Int16Array(this.body.count);
    const lists = [...this.doc.parts, null].map(() => []);
    for (let f = 0; f < this.body.count; f++) {
      const part = of[this.face[f]] ?? NONE;
      this.partOf[f] = part;
      lists[part < 0 ? lists.length - 1 : part].push(f);
    }
    this.counts = lists.map((l) => l.length);
    this.groups.forEach((mesh) => this.renderer.forget(mesh));
    this.groups = lists.map((list) => (list.length ? this.renderer.faces(this.whole, list) : null));
    this.partBoxes = lists.map((list) => this.boxOf(list));
  }

  boxOf(faces) {
    const { positions, indices } = this.body;
    const { low, high } = emptyBox();
    for (const f of faces) {
      for (let c = 3 * f; c < 3 * f + 3; c++) {
        for (let k = 0; k < 3; k++) {
          const x = positions[3 * indices[c] + k];
          if (x < low[k]) low[k] = x;
          if (x > high[k]) high[k] = x;
        }
      }
    }
    return { low, high };
  }

  /** Painted faces are shown with the next frame, however many strokes fall before it. */
  painted() {
    this.isWet = true;
    this.changed();
  }

  /** The model anew, from what is given and what was found. */
  rebuild() {
    const scene = sceneOf(this.doc, this.body, this.joints, this.unit, (i) => this.colourOf(i));
    if (!scene.links.length) {
      scene.links.push({ name: "", colour: BARE, collisions: [] });
      scene.homes.push([0, 0, 0]);
    }
    const boxes = boxesOf(scene, this.partBoxes);
    const spare = this.partBoxes.at(-1);
    if (this.counts.at(-1) && !boxes.some(isBox)) boxes[0] = { low: sub(spare.low, scene.homes[0]), high: sub(spare.high, scene.homes[0]) };
    const model = new Rig(scene, boxes);
    model.diagonal = size(sub(this.whole.box.high, this.whole.box.low)) || 1;
    carry(this.model, model);
    const { fresh, hidden, selected, playing } = this;
    const key = this.model?.joints[this.active]?.key;
    this.takes(scene, model);
    this.camera.knows(this.whole.box);
    this.model.box = this.whole.box;
    this.fresh = fresh ?? true;
    this.selected = selected ?? NONE;
    this.hidden = hidden ?? new Set();
    this.active = model.joints.findIndex((joint) => joint.key === key && joint.kind !== "fixed");
    this.playing = null;
    if (playing) this.stop();
  }

  /** A joint elsewhere or with other ends, as it is being pulled. */
  pull(j, { axis, pivot, range }) {
    const joint = this.model.joints[j];
    const { homes } = this.scene;
    if (axis) joint.axis = axis;
    if (range !== undefined) joint.range = range;
    if (pivot) {
      const moved = sub(pivot, homes[joint.child]);
      homes[joint.child] = pivot;
      joint.at = add(joint.at, moved);
      const own = this.model.boxes[joint.child];
      this.model.boxes[joint.child] = { low: sub(own.low, moved), high: sub(own.high, moved) };
      this.model.joints.filter((other) => other.parent === joint.child).forEach((other) => {
        other.at = sub(other.at, moved);
      });
    }
    this.model.joints.forEach((_, k) => this.marks.again(k));
    this.changed();
  }

  /** The picture without anything that moved. */
  boxOfMotion() {
    return this.whole.box;
  }

  boxNow() {
    return this.isAtRest() ? this.whole.box : this.model.boxAt(this.model.poses());
  }

  isAtRest() {
    return this.model.values.every((v) => v === 0);
  }

  /** The pose of a link that takes points of the object's frame at rest. */
  carrier(pose, l) {
    return { at: outside(pose, scale(this.scene.homes[l], -1)), turn: pose.turn };
  }

  bodies(frame, poses, theme) {
    const { look, xray } = this.shows;
    const pale = look === "sure" ? PALE[theme.lift > 1 ? "dark" : "light"] : [0, 0, 0, 0];
    const draw = (mesh, place, colour, glow) => {
      const tint = [...colour.map((c) => c / 255), look === "true" ? 0 : 1];
      const item = { mesh, matrix: matrix(place), tint, pale, glow, alpha: xray ? 0.35 : 1 };
      (xray ? frame.sheer : frame.solid).push(item);
    };
    this.poses = poses;
    this.groups.forEach((mesh, i) => {
      if (!mesh || this.hidden.has(i)) return;
      const isSpare = i === this.groups.length - 1;
      const place = isSpare ? { at: [0, 0, 0], turn: [0, 0, 0, 1] } : this.carrier(poses[i], i);
      draw(mesh, place, isSpare ? BARE : this.colourOf(i), i === this.lit ? 0.35 : 0);
    });
    this.touchable = [];
  }

  jointMarks(frame, poses, theme) {
    const few = this.model.movable().length <= MANY_JOINTS;
    this.model.joints.forEach((joint, j) => {
      if (joint.kind === "fixed" || this.hidden.has(joint.part)) return;
      const isChosen = joint.part === this.selected;
      if (few || isChosen) this.marks.joint(frame, j, poses[joint.parent], this.markColour(joint.child, theme), isChosen && j === this.active);
    });
  }

  content(now, ratio) {
    if (this.isWet) {
      this.isWet = false;
      this.fades();
      this.regroup();
    }
    const frame = super.content(now, ratio);
    this.extras.forEach((extra) => extra(frame, this.theme()));
    return frame;
  }

  names(poses) {
    this.doc?.parts.forEach(({ name }, i) => {
      if (this.hidden.has(i) || !this.counts[i]) return;
      const box = this.partBoxes[i];
      const at = outside(this.carrier(poses[i], i), scale(add(box.low, box.high), 0.5));
      this.tags.push({ text: name, at, colour: this.colourOf(i), strong: i === this.selected });
    });
  }

  /** The ray through a place of the canvas, in CSS pixels. */
  rayAt([x, y]) {
    const { clientWidth, clientHeight } = this.canvas;
    return this.camera.ray([(2 * x) / clientWidth - 1, 1 - (2 * y) / clientHeight], clientWidth / Math.max(clientHeight, 1));
  }

  /** How parts are carried: groups of parts that stand alike. */
  carriers() {
    const poses = this.model.poses();
    const known = new Map([["0,0,0,0,0,0,1", { pose: { at: [0, 0, 0], turn: [0, 0, 0, 1] }, parts: new Set([NONE]) }]]);
    this.doc.parts.forEach((_, i) => {
      if (this.hidden.has(i)) return;
      const pose = this.carrier(poses[i], i);
      const key = [...pose.at, ...pose.turn].map((v) => Number(v.toFixed(9)) + 0).join();
      if (!known.has(key)) known.set(key, { pose, parts: new Set() });
      known.get(key).parts.add(i);
    });
    return [...known.values()];
  }

  /** What of the surface lies under a place of the canvas: face, part, and the point where it is at rest. */
  hit(at) {
    if (!this.model || !this.doc) return null;
    return this.met(this.rayAt(at));
  }

  /** What a ray meets first. */
  met({ from, way }) {
    let best = null;
    for (const { pose, parts } of this.carriers()) {
      const takes = (f) => parts.has(this.partOf[f]);
      const found = this.body.tree.ray(inside(pose, from), rotate(back(pose.turn), way), takes);
      if (found && (!best || found.far < best.far)) best = { ...found, part: this.partOf[found.face], pose };
    }
    return best && { ...best, world: outside(best.pose, best.point) };
  }

  /** Where a point of the object at rest is now, as it goes with its part. */
  nowAt(p, part) {
    const poses = this.model.poses();
    return part >= 0 && poses[part] ? outside(this.carrier(poses[part], part), p) : p;
  }

  pick(x, y) {
    const found = this.hit([x, y]);
    return found && found.part >= 0 ? { link: found.part, depth: found.far } : null;
  }

  /** Whether nothing stands before a point of the picture. */
  isSeen(p) {
    const eye = this.camera.eye();
    const way = sub(p, eye);
    const far = size(way);
    const found = this.met({ from: eye, way: scale(way, 1 / far) });
    return !found || found.far > far - 0.004 * this.model.diagonal;
  }

  /** Chooses a part and its first joint. */
  chooses(part, index = 0) {
    this.selected = part;
    this.active = part < 0 ? NONE : this.model.jointOf(part, clamp(index, 0, 1));
    this.changed();
  }
}
