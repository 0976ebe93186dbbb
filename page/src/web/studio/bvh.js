// Boxes within boxes over the faces of a surface: what a ray meets, what a ball touches.

const LEAF = 4;
const DEEPEST = 64;

export class Tree {
  constructor(positions, indices) {
    this.positions = positions;
    this.indices = indices;
    const count = indices.length / 3;
    this.order = Uint32Array.from({ length: count }, (_, f) => f);
    this.centres = new Float32Array(3 * count);
    for (let f = 0; f < count; f++) {
      for (let k = 0; k < 3; k++) this.centres[3 * f + k] = (this.at(f, 0, k) + this.at(f, 1, k) + this.at(f, 2, k)) / 3;
    }
    const most = Math.max(2 * count, 1);
    this.boxes = new Float32Array(6 * most);
    this.first = new Uint32Array(most);
    this.count = new Uint32Array(most);
    this.used = 1;
    if (count) this.split(0, 0, count, 0);
  }

  /** A coordinate of a corner of a face. */
  at(f, corner, k) {
    return this.positions[3 * this.indices[3 * f + corner] + k];
  }

  /** Bounds a node, and halves it where it is large. */
  split(node, from, to, depth) {
    this.bound(node, from, to);
    this.first[node] = from;
    this.count[node] = to - from;
    if (to - from <= LEAF || depth > DEEPEST) return;
    const { axis, low, high } = this.widest(from, to);
    const half = this.part(from, to, axis, (low + high) / 2);
    if (half === from || half === to) return;
    const left = this.used;
    this.used += 2;
    this.first[node] = left;
    this.count[node] = 0;
    this.split(left, from, half, depth + 1);
    this.split(left + 1, half, to, depth + 1);
  }

  bound(node, from, to) {
    const box = this.boxes.subarray(6 * node, 6 * node + 6);
    box.fill(Infinity, 0, 3);
    box.fill(-Infinity, 3, 6);
    for (let i = from; i < to; i++) {
      for (let corner = 0; corner < 3; corner++) {
        for (let k = 0; k < 3; k++) {
          const x = this.at(this.order[i], corner, k);
          if (x < box[k]) box[k] = x;
          if (x > box[3 + k]) box[3 + k] = x;
        }
      }
    }
  }

  /** The axis along which the centres of faces lie farthest apart. */
  widest(from, to) {
    let best = { axis: 0, low: 0, high: -Infinity };
    for (let axis = 0; axis < 3; axis++) {
      let [low, high] = [Infinity, -Infinity];
      for (let i = from; i < to; i++) {
        const x = this.centres[3 * this.order[i] + axis];
        if (x < low) low = x;
        if (x > high) high = x;
      }
      if (high - low > best.high - best.low || axis === 0) best = { axis, low, high };
    }
    return best;
  }

  part(from, to, axis, middle) {
    const { order, centres } = this;
    let half = from;
    for (let i = from; i < to; i++) {
      if (centres[3 * order[i] + axis] >= middle) continue;
      [order[i], order[half]] = [order[half], order[i]];
      half += 1;
    }
    return half;
  }

  /** Where a ray first meets a face that `takes` lets through: its face, how far, the point; or nothing. */
  ray(from, way, takes = () => true) {
    const inverse = way.map((w) => 1 / w);
    let best = null;
    let far = Infinity;
    const open = [0];
    while (open.length && this.order.length) {
      const node = open.pop();
      if (this.enters(node, from, inverse) >= far) continue;
      if (!this.count[node]) {
        const left = this.first[node];
        const [a, b] = [left, left + 1].map((n) => this.enters(n, from, inverse));
        open.push(...(a < b ? [left + 1, left] : [left, left + 1]));
        continue;
      }
      for (let i = this.first[node]; i < this.first[node] + this.count[node]; i++) {
        const f = this.order[i];
        const t = this.meets(f, from, way);
        if (t >= far || !takes(f)) continue;
        far = t;
        best = f;
      }
    }
    return best === null ? null : { face: best, far, point: from.map((x, k) => x + far * way[k]) };
  }

  /** How far away a ray enters a node's box. */
  enters(node, from, inverse) {
    let [near, far] = [0, Infinity];
    for (let k = 0; k < 3; k++) {
      const a = (this.boxes[6 * node + k] - from[k]) * inverse[k];
      const b = (this.boxes[6 * node + 3 + k] - from[k]) * inverse[k];
      // A ray within a face of the box makes 0 · ∞.
      if (Number.isNaN(a) || Number.isNaN(b)) continue;
      near = Math.max(near, Math.min(a, b));
      far = Math.min(far, Math.max(a, b));
    }
    return near <= far ? near : Infinity;
  }

  /** How far away a ray meets a face, from either side. */
  meets(f, o, d) {
    const [ax, ay, az] = [this.at(f, 0, 0), this.at(f, 0, 1), this.at(f, 0, 2)];
    const [ux, uy, uz] = [this.at(f, 1, 0) - ax, this.at(f, 1, 1) - ay, this.at(f, 1, 2) - az];
    const [vx, vy, vz] = [this.at(f, 2, 0) - ax, this.at(f, 2, 1) - ay, this.at(f, 2, 2) - az];
    const [px, py, pz] = [d[1] * vz - d[2] * vy, d[2] * vx - d[0] * vz, d[0] * vy - d[1] * vx];
    const det = ux * px + uy * py + uz * pz;
    if (det === 0) return Infinity;
    const [sx, sy, sz] = [o[0] - ax, o[1] - ay, o[2] - az];
    const u = (sx * px + sy * py + sz * pz) / det;
    if (!(u >= 0 && u <= 1)) return Infinity;
    const [qx, qy, qz] = [sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux];
    const v = (d[0] * qx + d[1] * qy + d[2] * qz) / det;
    if (!(v >= 0 && u + v <= 1)) return Infinity;
    const t = (vx * qx + vy * qy + vz * qz) / det;
    return t > 0 ? t : Infinity;
  }

  /** Faces whose centres lie in a ball. */
  ball(centre, radius) {
    const found = [];
    const open = this.order.length ? [0] : [];
    while (open.length) {
      const node = open.pop();
      let away = 0;
      for (let k = 0; k < 3; k++) {
        const d = Math.max(this.boxes[6 * node + k] - centre[k], 0, centre[k] - this.boxes[6 * node + 3 + k]);
        away += d * d;
      }
      if (away > radius * radius) continue;
      if (!this.count[node]) {
        open.push(this.first[node], this.first[node] + 1);
        continue;
      }
      for (let i = this.first[node]; i < this.first[node] + this.count[node]; i++) found.push(this.order[i]);
    }
    return found;
  }
}
