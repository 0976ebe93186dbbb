// The condition as text: the same words give the same bytes.

const QUANTITIES = ["axis", "pivot", "range", "rest", "effort", "damping"];
const FIELDS = {
  file: ["$schema", "schema", "category", "up", "size", "mesh", "notes", "parts"],
  part: ["name", "text", "parent", "joint", "joints", "point", "points", "not", "faces", ...QUANTITIES, "material", "density", "mass", "friction"],
  joint: ["type", ...QUANTITIES],
};
const INSIDE = { parts: "part", joints: "joint" };
/** The longest list or object that stands on one line. */
const WIDE = 96;

const isObject = (value) => typeof value === "object" && value !== null;

/** Fields in the order of the format; those it does not know come last, by name. */
function ordered(object, kind) {
  const known = FIELDS[kind] ?? [];
  const others = Object.keys(object).filter((k) => !known.includes(k)).sort();
  return [...known.filter((k) => k in object), ...others].filter((k) => object[k] !== undefined);
}

function inline(value, kind) {
  if (Array.isArray(value)) return `[${value.map((v) => inline(v, kind)).join(", ")}]`;
  if (!isObject(value)) return JSON.stringify(Object.is(value, -0) ? 0 : value);
  const fields = ordered(value, kind).map((k) => `${JSON.stringify(k)}: ${inline(value[k], INSIDE[k])}`);
  return fields.length ? `{ ${fields.join(", ")} }` : "{}";
}

/** What holds lists or objects stands on lines of its own, and so do parts. */
function isShort(value, kind, text) {
  if (kind === "part" || kind === "file" || text.length > WIDE) return false;
  const inner = Array.isArray(value) ? value.filter(isObject) : Object.values(value).filter((v) => isObject(v) && !Array.isArray(v));
  return inner.length === 0;
}

function block(value, kind, indent) {
  const text = inline(value, kind);
  const isList = Array.isArray(value);
  if (!isObject(value) || text.length <= 2 || isShort(value, isList ? null : kind, text)) return text;
  const deep = `${indent}  `;
  const lines = isList
    ? value.map((v) => deep + block(v, kind, deep))
    : ordered(value, kind).map((k) => `${deep}${JSON.stringify(k)}: ${block(value[k], INSIDE[k], deep)}`);
  const [open, close] = isList ? "[]" : "{}";
  return `${open}\n${lines.join(",\n")}\n${indent}${close}`;
}

/** A condition as it is written to its file. */
export const written = (doc) => `${block(doc, "file", "")}\n`;

/** A number with six digits that count. */
export const six = (x) => Number(x.toPrecision(6)) || 0;

/** A point or direction with six digits that count; of a part of its size, nothing is left. */
export function rounded(p) {
  const most = Math.max(...p.map(Math.abs));
  return p.map((x) => (Math.abs(x) < 1e-7 * most ? 0 : six(x)));
}

const ANGLES = { rad: 1, "°": Math.PI / 180, deg: Math.PI / 180, degree: Math.PI / 180, degrees: Math.PI / 180, turn: 2 * Math.PI };
const LENGTHS = { m: 1, cm: 0.01, mm: 0.001, in: 0.0254 };

/** Radians or metres of what a file says: a number, or a text with its unit; nothing if it is neither. */
export function quantity(said, turns) {
  if (typeof said === "number") return said;
  const [, number, unitName] = /^\s*([-+.\d]+(?:e[-+]?\d+)?)\s*(\S*)\s*$/i.exec(String(said ?? "")) ?? [];
  const factor = (turns ? ANGLES : LENGTHS)[unitName];
  const value = Number(number) * factor;
  return Number.isFinite(value) ? value : null;
}

/** Faces as runs: `0-119 340`. */
export function runs(faces) {
  const words = [];
  for (let i = 0; i < faces.length; i++) {
    const first = faces[i];
    while (i + 1 < faces.length && faces[i + 1] === faces[i] + 1) i += 1;
    words.push(faces[i] === first ? `${first}` : `${first}-${faces[i]}`);
  }
  return words.join(" ");
}

/** Calls back for every face of some runs, up to a number of faces. */
export function eachFace(text, count, back) {
  for (const word of String(text ?? "").split(/[ ,]+/).filter(Boolean)) {
    const [first, last] = word.split("-").map(Number);
    for (let f = first; f <= Math.min(last ?? first, count - 1); f++) back(f);
  }
}

/** A name that a part may have, from words. */
export function nameOf(words, taken) {
  const plain = words.trim().toLowerCase().normalize("NFKD").replace(/[\u0300-\u036f]/g, "").replace(/[^a-z0-9_]+/g, "_").replace(/^_+|_+$/g, "") || "part";
  const sound = /^[a-z_]/.test(plain) ? plain : `_${plain}`;
  let name = sound;
  for (let i = 2; taken.includes(name); i++) name = `${sound}_${i}`;
  return name;
}
