// The mesh that is worked on: its faces as shown and as the file counts them, its edges, its frame.
import { cross, dot, size, sub, unit } from "../maths.js";
import { shaded } from "../surface.js";
import { Tree } from "./bvh.js";
import { eachFace, rounded } from "./text.js";

/** Faces that meet at more than 30° make an edge that can be snapped to. */
const SHARP = Math.cos((30 * Math.PI) / 180);

export class Body {
  /** `bytes` as `/api/mesh` has them, `state` as `/api/state`. */
  constructor(bytes, state) {
    const [vertices, faces, all] = new Uint32Array(bytes.buffer, bytes.byteOffset, 3);
    this.count = faces;
    this.all = all;
    let at = bytes.byteOffset + 16;
    const take = (Kind, length) => {
      const taken = new Kind(bytes.buffer, at, length);
      at += taken.byteLength;
      return taken;
    };
    this.positions = take(Float32Array, 3 * vertices);
    const colours = take(Uint8Array, 4 * vertices);
    this.indices = take(Uint32Array, 3 * faces);
    this.shownOf = faces === all ? null : take(Uint32Array, all);
    this.toFile = state.to_file;
    this.digest = state.mesh.digest;
    this.surface = shaded({ positions: this.positions, colours: plain(colours), indices: this.indices });
    this.tree = new Tree(this.positions, this.indices);
    this.members = this.shownOf ? membersOf(this.shownOf, faces) : null;
  }

  corner(f, k) {
    const at = 3 * this.indices[3 * f + k];
    return [this.positions[at], this.positions[at + 1], this.positions[at + 2]];
  }

  normal(f) {
    const [a, b, c] = [0, 1, 2].map((k) => this.corner(f, k));
    return unit(cross(sub(b, a), sub(c, a)));
  }

  /** A point or direction of the object's frame in the file's. */
  fileOf(p) {
    return rounded(this.toFile.map((row) => dot(row, p)));
  }

  /** The other way. */
  objectOf(p) {
    return [0, 1, 2].map((k) => this.toFile[0][k] * p[0] + this.toFile[1][k] * p[1] + this.toFile[2][k] * p[2]);
  }

  /** The faces of the mesh that a shown face stands for. */
  standsFor(f) {
    if (!this.members) return [f];
    return this.members.list.subarray(this.members.start[f], this.members.start[f + 1]);
  }

  /** Which part each face of the mesh is painted as, −1 for none. */
  painted(doc) {
    const owner = new Int16Array(this.all).fill(-1);
    doc.parts.forEach((part, i) => part.faces && eachFace(part.faces, this.all, (f) => {
      owner[f] = i;
    }));
    return owner;
  }

  /** Edges at which faces meet sharply or end, by face; made when first asked for. */
  edges() {
    this.sharp ??= sharpEdges(this);
    return this.sharp;
  }
}

const plain = (rgba) => {
  const rgb = new Uint8Array((3 * rgba.length) / 4);
  for (let v = 0; 4 * v < rgba.length; v++) rgb.set(rgba.subarray(4 * v, 4 * v + 3), 3 * v);
  return rgb;
};

function membersOf(shownOf, faces) {
  const start = new Uint32Array(faces + 1);
  for (const f of shownOf) start[f + 1] += 1;
  for (let f = 0; f < faces; f++) start[f + 1] += start[f];
  const next = start.slice(0, faces);
  const list = new Uint32Array(shownOf.length);
  shownOf.forEach((f, g) => {
    list[next[f]++] = g;
  });
  return { start, list };
}

/** For each face that has some, its sharp edges: [from, to]. */
function sharpEdges(body) {
  const places = new Map();
  const place = (v) => {
    const key = `${body.positions[3 * v]},${body.positions[3 * v + 1]},${body.positions[3 * v + 2]}`;
    if (!places.has(key)) places.set(key, places.size);
    return places.get(key);
  };
  const number = Uint32Array.from({ length: body.positions.length / 3 }, (_, v) => place(v));
  const sides = new Map();
  for (let f = 0; f < body.count; f++) {
    for (let k = 0; k < 3; k++) {
      const [a, b] = [k, (k + 1) % 3].map((c) => number[body.indices[3 * f + c]]);
      const key = a < b ? a * places.size + b : b * places.size + a;
      if (!sides.has(key)) sides.set(key, []);
      sides.get(key).push([f, k]);
    }
  }
  const found = new Map();
  for (const faces of sides.values()) {
    if (faces.length === 2 && dot(body.normal(faces[0][0]), body.normal(faces[1][0])) > SHARP) continue;
    for (const [f, k] of faces) {
      if (!found.has(f)) found.set(f, []);
      found.get(f).push([body.corner(f, k), body.corner(f, (k + 1) % 3)]);
    }
  }
  return found;
}

/** How long the longest side of a box is. */
export const diagonalOf = ({ low, high }) => Math.max(size(sub(high, low)), 1e-9);
