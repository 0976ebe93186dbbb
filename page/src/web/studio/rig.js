// The parts of a condition and their joints as a model that moves.
import { clamp, emptyBox, isBox, sub } from "../maths.js";
import { Model } from "../model.js";
import { givenEnds, kindsOf, saidOf, turnsAt } from "./edits.js";

const FIXED = { kind: "fixed", axis: [0, 0, 1], range: null };

/** A model whose joints can be tried past their ends. */
export class Rig extends Model {
  constructor(scene, boxes) {
    super(scene, boxes);
    this.free ??= new Set();
  }

  /** How far a person can try a joint; past its ends, if they ask for it. */
  reach(j) {
    const [low, high] = super.reach(j);
    const { key } = this.joints[j];
    if (!this.free?.has(key)) return [low, high];
    const far = this.turns(j) ? Math.PI : 0.6 * this.diagonal;
    return [Math.min(low, -far), Math.max(high, far)];
  }

  /** The joint of a part, by number; −1 if there is none. */
  jointOf(part, index) {
    return this.joints.findIndex((joint) => joint.part === part && joint.index === index && joint.kind !== "fixed");
  }
}

/** A joint of a part as it is found and as it is given, in the object's frame; nothing where neither says a place. */
function placed(part, k, found, body, scale) {
  const kind = kindsOf(part)[k];
  const said = saidOf(part, k);
  const known = found.find((j) => j.part === part.name && j.index === k && turnsAt(j.kind) === turnsAt(kind));
  const axis = Array.isArray(said.axis) ? body.objectOf(said.axis) : known?.axis;
  const pivot = Array.isArray(said.pivot) ? body.objectOf(said.pivot) : known?.pivot;
  if (!axis || !pivot || !axis.some((x) => x !== 0)) return null;
  const ends = kind === "continuous" ? null : givenEnds(said, turnsAt(kind)) ?? known?.range ?? null;
  const range = ends && turnsAt(kind) ? ends : ends?.map((end) => end / scale) ?? null;
  return { kind, axis, pivot, range, candidates: known?.candidates ?? [], anchored: Array.isArray(said.pivot) };
}

/** Links and joints of a condition; link i is part i, and what lies between two joints of a part comes behind. */
export function sceneOf(doc, body, found, scale, colourOf) {
  const links = doc.parts.map((part, i) => ({ name: part.name, colour: colourOf(i), collisions: [] }));
  const homes = links.map(() => [0, 0, 0]);
  const joints = [];
  const join = (parent, child, place, more) => {
    const pivot = place ? place.pivot : homes[parent];
    homes[child] = pivot;
    joints.push({ ...FIXED, ...place, ...more, parent, child, at: sub(pivot, homes[parent]), turn: [0, 0, 0, 1], mimic: null, facts: [] });
  };
  for (const i of rootFirst(doc)) {
    const part = doc.parts[i];
    let parent = doc.parts.findIndex((p) => p.name === part.parent);
    if (parent < 0 || !part.parent) continue;
    const kinds = kindsOf(part);
    kinds.forEach((_, k) => {
      const isLast = k === kinds.length - 1;
      const child = isLast ? i : links.push({ name: "", colour: colourOf(i), collisions: [] }) - 1;
      if (!isLast) homes.push([0, 0, 0]);
      const place = placed(part, k, found, body, scale);
      join(parent, child, place, { part: i, index: k, key: `${part.name} ${k}`, name: kinds.length > 1 ? `${part.name} ${k + 1}` : part.name });
      parent = child;
    });
    if (!kinds.length) join(parent, i, null, { part: i, index: 0, key: part.name, name: part.name });
  }
  return { title: doc.category, links, joints, checks: [], homes };
}

/** Parts, each behind its parent; what hangs on nobody comes where it stands, rings are left out. */
function rootFirst(doc) {
  const byName = new Map(doc.parts.map((p, i) => [p.name, i]));
  const order = [];
  const seen = new Set();
  const visit = (i, above) => {
    if (seen.has(i) || above.has(i)) return;
    const parent = byName.get(doc.parts[i].parent);
    if (parent !== undefined) visit(parent, new Set([...above, i]));
    seen.add(i);
    order.push(i);
  };
  doc.parts.forEach((_, i) => visit(i, new Set()));
  return order;
}

/** The boxes of links in their frames, from those of parts in the object's. */
export function boxesOf(scene, partBoxes) {
  return scene.links.map((_, l) => {
    const own = partBoxes[l];
    if (!own || !isBox(own)) return emptyBox();
    return { low: sub(own.low, scene.homes[l]), high: sub(own.high, scene.homes[l]) };
  });
}

/** Takes over the values of an earlier model. */
export function carry(from, to) {
  if (!from) return;
  to.free = from.free ?? new Set();
  to.joints.forEach((joint, j) => {
    const before = from.joints.findIndex((other) => other.key === joint.key && other.kind !== "fixed");
    if (before < 0 || joint.kind === "fixed") return;
    const [low, high] = to.reach(j);
    to.values[j] = clamp(from.values[before], low, high);
  });
}
