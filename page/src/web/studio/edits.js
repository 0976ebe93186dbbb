// What can be done to a condition. Every function changes the document that it is given.
import { nameOf, quantity } from "./text.js";

export const turnsAt = (kind) => kind !== "prismatic";

const SLIDES = /drawer|slid|tray|rack|button|plunger|telescop/;
const SPINS = /wheel|knob|dial|fan|propell|roller|caster|castor|crank/;
const HINGES = /door|lid|flap|cover|hatch|arm|lever|pedal|handle|hinge|gate|shutter|screen|cap/;

/** How a part of that name may move: a guess to begin with. */
function likely(name) {
  if (SLIDES.test(name)) return "prismatic";
  if (SPINS.test(name)) return "continuous";
  return HINGES.test(name) ? "revolute" : null;
}

/** The kinds of a part's joints, the first nearest the parent. */
export function kindsOf(part) {
  if (Array.isArray(part.joints) && part.joints.length) return part.joints.map((j) => j.type);
  return [part.joint ?? []].flat();
}

/** What is said of a joint of a part. */
export function saidOf(part, index) {
  if (Array.isArray(part.joints) && part.joints.length) return part.joints[index] ?? {};
  return kindsOf(part).length < 2 ? part : {};
}

/** The part without a parent, or nothing. */
export const baseOf = (doc) => doc.parts.find((p) => !p.parent);

/** Adds a part by its words; returns its index. */
export function addPart(doc, words) {
  const name = nameOf(words, doc.parts.map((p) => p.name));
  const part = { name };
  if (words.trim() !== name.replaceAll("_", " ") && words.trim() !== name) part.text = words.trim();
  const base = baseOf(doc);
  if (base) {
    part.parent = base.name;
    const kind = likely(name);
    if (kind) part.joint = kind;
  }
  doc.parts.push(part);
  return doc.parts.length - 1;
}

/** Takes a part away; its children hang on its parent. */
export function removePart(doc, i) {
  const [gone] = doc.parts.splice(i, 1);
  for (const part of doc.parts) {
    if (part.parent !== gone.name) continue;
    if (gone.parent) part.parent = gone.parent;
    else delete part.parent;
  }
  const roots = doc.parts.filter((p) => !p.parent);
  roots.slice(1).forEach((part) => {
    part.parent = roots[0].name;
  });
  if (roots[0]) setKinds(roots[0], []);
  tidy(doc);
}

/** Another name, for its children, too. */
export function rename(doc, i, name) {
  const before = doc.parts[i].name;
  doc.parts[i].name = name;
  doc.parts.forEach((part) => {
    if (part.parent === before) part.parent = name;
  });
}

/** Whether a part would hang on itself. */
export function isBelow(doc, i, name) {
  const seen = new Set();
  for (let at = doc.parts.find((p) => p.name === name); at && !seen.has(at); at = doc.parts.find((p) => p.name === at.parent)) {
    if (at === doc.parts[i]) return true;
    seen.add(at);
  }
  return false;
}

/** A field with a value; none where the value says nothing. */
export function put(object, field, value) {
  if (value === null || value === undefined || value === "") delete object[field];
  else object[field] = value;
}

const SAID = ["axis", "pivot", "range", "rest", "effort", "damping"];
const OF_KIND = ["range", "rest", "effort", "damping"];

/** Other kinds of joints; what is said of them stays where it still means something. */
export function setKinds(part, kinds) {
  const before = kindsOf(part);
  const said = kinds.map((type, k) => {
    const own = before[k] === undefined ? {} : saidOf(part, k);
    const stays = SAID.filter((f) => own[f] !== undefined && (turnsAt(before[k]) === turnsAt(type) || !OF_KIND.includes(f)));
    const kept = stays.filter((f) => type !== "continuous" || (f !== "range" && f !== "rest"));
    return { type, ...Object.fromEntries(kept.map((f) => [f, own[f]])) };
  });
  writeJoints(part, said);
}

/** Writes joints in the shortest way there is. */
function writeJoints(part, said) {
  for (const field of ["joint", "joints", ...SAID]) delete part[field];
  const kinds = said.map((s) => s.type);
  const isBare = said.every((s) => Object.keys(s).length === 1);
  if (said.length === 1) {
    part.joint = kinds[0];
    SAID.forEach((f) => put(part, f, said[0][f]));
  } else if (said.length && isBare && turnsAt(kinds[0]) !== turnsAt(kinds[1])) part.joint = kinds;
  else if (said.length) part.joints = said;
}

/** Says something of a joint of a part; a value null takes a word back. */
export function correct(part, index, fields) {
  const kinds = kindsOf(part);
  const all = kinds.map((type, k) => {
    const own = saidOf(part, k);
    return { type, ...Object.fromEntries(SAID.filter((f) => own[f] !== undefined).map((f) => [f, own[f]])) };
  });
  if (!all[index]) return;
  Object.entries(fields).forEach(([field, value]) => put(all[index], field, value));
  writeJoints(part, all);
}

/** What an answer to a question says of a part: a further point on it, or fields of one of its joints. */
export function answer(doc, { part: name, index, point, set }) {
  const part = doc.parts.find((p) => p.name === name);
  if (!part) return;
  if (point) addPoint(part, point, false);
  if (set) correct(part, index ?? 0, set);
}

/** What a remedy sets: on a part, on one of its joints, or on the whole. */
export function amend(doc, remedy) {
  const part = remedy.part ? doc.parts.find((p) => p.name === remedy.part) : null;
  if (!remedy.part) Object.entries(remedy.set).forEach(([f, value]) => put(doc, f, value));
  if (!part) return;
  const ofJoint = Object.fromEntries(Object.entries(remedy.set).filter(([f]) => SAID.includes(f)));
  if (Object.keys(ofJoint).length) correct(part, remedy.index ?? 0, ofJoint);
  Object.entries(remedy.set).filter(([f]) => !SAID.includes(f)).forEach(([f, value]) => put(part, f, value));
}

/** Where in its range a joint is shown. */
export const restOf = (said, turns) => quantity(said.rest, turns) ?? 0;

/** The ends that a person gave, from the shown pose; nothing where none are given. */
export function givenEnds(said, turns) {
  if (!Array.isArray(said.range)) return null;
  const ends = said.range.map((end) => quantity(end, turns));
  return ends.some((end) => end === null) ? null : ends.map((end) => end - restOf(said, turns));
}

const isPoint = (p) => Array.isArray(p) && p.length === 3 && p.every(Number.isFinite);

/** Points of a part with their places in the document; what is no point is left out. */
export function pointsOf(part) {
  const own = [{ list: "point", at: part.point }];
  const listed = (list) => (Array.isArray(part[list]) ? part[list].map((at, index) => ({ list, index, at })) : []);
  return [...own, ...listed("points"), ...listed("not")].filter(({ at }) => isPoint(at));
}

/** Adds a point, or a place that is not of the part. */
export function addPoint(part, at, isNot) {
  if (isNot) part.not = [...(part.not ?? []), at];
  else if (!part.point) part.point = at;
  else part.points = [...(part.points ?? []), at];
}

/** Takes a point away; the next one moves up. */
export function removePoint(part, { list, index }) {
  if (list === "point") {
    delete part.point;
    if (part.points?.length) part.point = part.points.shift();
  } else part[list].splice(index, 1);
  for (const field of ["points", "not"]) if (part[field]?.length === 0) delete part[field];
}

/** The mesh is named where faces are painted. */
export function tidy(doc, digest) {
  if (!doc.parts.some((p) => p.faces)) delete doc.mesh;
  else if (digest) doc.mesh = digest;
}

/** The fields in which two conditions differ, in words. */
export function differences(ours, theirs) {
  const found = [];
  const say = (field, a, b) => {
    if (JSON.stringify(a) === JSON.stringify(b)) return;
    const short = (v) => (v === undefined ? "nothing" : clip(JSON.stringify(v)));
    found.push({ field, mine: short(a), theirs: short(b) });
  };
  const keys = (a, b, but) => [...new Set([...Object.keys(a), ...Object.keys(b)])].filter((k) => k !== but);
  keys(ours, theirs, "parts").filter((k) => k !== "schema").forEach((k) => say(k, ours[k], theirs[k]));
  const parts = (doc) => new Map((Array.isArray(doc.parts) ? doc.parts : []).map((p) => [p.name, p]));
  const [mine, other] = [parts(ours), parts(theirs)];
  for (const name of new Set([...mine.keys(), ...other.keys()])) {
    const [a, b] = [mine.get(name), other.get(name)];
    if (!a || !b) found.push({ field: `part ${name}`, mine: a ? "is there" : "nothing", theirs: b ? "is there" : "nothing" });
    else keys(a, b, "name").forEach((k) => say(`${name}, ${k}`, a[k], b[k]));
  }
  return found;
}

const clip = (text) => (text.length > 60 ? `${text.slice(0, 57)}…` : text);
