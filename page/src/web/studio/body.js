// The mesh that is worked on: its faces as shown and as the file counts them, its edges, its frame.
import { cross, dot, sub, unit } from "../maths.js";
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

  /** The edges at which some faces meet sharply, or end: [from, to]. Only edges all of whose faces are given are told right. */
  edgesOf(faces) {
    const known = new Map();
    for (const f of faces) {
      const corners = [0, 1, 2].map((k) => this.corner(f, k));
      const words = corners.map((p) => p.join());
      for (let k = 0; k < 3; k++) {
        const [a, b] = [k, (k + 1) % 3];
        const key = words[a] < words[b] ? `${words[a]} ${words[b]}` : `${words[b]} ${words[a]}`;
        if (!known.has(key)) known.set(key, { edge: [corners[a], corners[b]], faces: [] });
        known.get(key).faces.push(f);
      }
    }
    const isSharp = ({ faces: [f, g], faces: { length } }) => length !== 2 || dot(this.normal(f), this.normal(g)) < SHARP;
    return [...known.values()].filter(isSharp).map(({ edge }) => edge);
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
