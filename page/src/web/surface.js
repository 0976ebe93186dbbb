// Surfaces with normals, as a graphics card wants them.
import { emptyBox, grow } from "./maths.js";

/** Faces that meet at a sharper angle than 40° are shaded apart. */
const CREASE = Math.cos((40 * Math.PI) / 180);

/** Unit normals of all faces, and the angles of their corners. */
function ofFaces(positions, indices) {
  const count = indices.length / 3;
  const normals = new Float32Array(3 * count);
  const angles = new Float32Array(3 * count);
  const edges = [new Float64Array(3), new Float64Array(3), new Float64Array(3)];
  for (let f = 0; f < count; f++) {
    for (let k = 0; k < 3; k++) {
      const a = 3 * indices[3 * f + k];
      const b = 3 * indices[3 * f + ((k + 1) % 3)];
      for (let i = 0; i < 3; i++) edges[k][i] = positions[b + i] - positions[a + i];
    }
    const [u, v] = edges;
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const length = Math.hypot(...n) || 1;
    for (let i = 0; i < 3; i++) normals[3 * f + i] = n[i] / length;
    for (let k = 0; k < 3; k++) {
      const [out, back] = [edges[k], edges[(k + 2) % 3]];
      const dots = -(out[0] * back[0] + out[1] * back[1] + out[2] * back[2]);
      const sizes = Math.hypot(...out) * Math.hypot(...back) || 1;
      angles[3 * f + k] = Math.acos(Math.min(Math.max(dots / sizes, -1), 1));
    }
  }
  return { normals, angles };
}

/** Points of one place have one number, whatever their colours. */
function places(positions, indices) {
  const known = new Map();
  const place = new Uint32Array(positions.length / 3);
  for (let v = 0; v < place.length; v++) {
    const key = `${positions[3 * v]},${positions[3 * v + 1]},${positions[3 * v + 2]}`;
    if (!known.has(key)) known.set(key, known.size);
    place[v] = known.get(key);
  }
  return { corner: indices.map((v) => place[v]), count: known.size };
}

/** For each place, the corners there: `list[start[p]] .. list[start[p + 1] - 1]`. */
function cornersAt({ corner, count }) {
  const start = new Uint32Array(count + 1);
  for (const p of corner) start[p + 1]++;
  for (let p = 0; p < count; p++) start[p + 1] += start[p];
  const next = start.slice(0, count);
  const list = new Uint32Array(corner.length);
  corner.forEach((p, c) => {
    list[next[p]++] = c;
  });
  return { start, list };
}

/** Three points a face with normals that are smooth but over creases. */
export function shaded({ positions, colours, indices }) {
  const { normals, angles } = ofFaces(positions, indices);
  const at = places(positions, indices);
  const { start, list } = cornersAt(at);
  const count = indices.length;
  const out = {
    positions: new Float32Array(3 * count),
    normals: new Int8Array(4 * count),
    colours: new Uint8Array(4 * count),
    count,
    box: emptyBox(),
  };
  for (let c = 0; c < count; c++) {
    const own = 3 * Math.floor(c / 3);
    const n = [0, 0, 0];
    for (let k = start[at.corner[c]]; k < start[at.corner[c] + 1]; k++) {
      const other = 3 * Math.floor(list[k] / 3);
      const like = normals[own] * normals[other] + normals[own + 1] * normals[other + 1] + normals[own + 2] * normals[other + 2];
      if (like < CREASE) continue;
      for (let i = 0; i < 3; i++) n[i] += normals[other + i] * angles[list[k]];
    }
    const length = Math.hypot(...n) || 1;
    for (let i = 0; i < 3; i++) {
      out.positions[3 * c + i] = positions[3 * indices[c] + i];
      out.normals[4 * c + i] = Math.round((127 * n[i]) / length);
      out.colours[4 * c + i] = colours[3 * indices[c] + i];
    }
    out.colours[4 * c + 3] = 255;
    grow(out.box, out.positions.subarray(3 * c, 3 * c + 3));
  }
  return out;
}
