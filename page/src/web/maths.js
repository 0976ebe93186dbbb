// Vectors [x, y, z], quaternions [x, y, z, w], poses { at, turn }, matrices by columns.

export const TAU = 2 * Math.PI;

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];

export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

export const scale = (a, k) => [a[0] * k, a[1] * k, a[2] * k];

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

export const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

export const size = (a) => Math.hypot(a[0], a[1], a[2]);

export const mix = (a, b, k) => add(scale(a, 1 - k), scale(b, k));

export const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

/** The direction of a vector, or another where it has none. */
export function unit(a, otherwise = [0, 0, 1]) {
  const length = size(a);
  return length > 1e-12 ? scale(a, 1 / length) : otherwise;
}

/** A unit vector at right angles to another. */
export function aside(a) {
  const [x, y, z] = a.map(Math.abs);
  const other = x <= y && x <= z ? [1, 0, 0] : y <= z ? [0, 1, 0] : [0, 0, 1];
  return unit(cross(a, other));
}

/** Turns a vector by a quaternion. */
export function rotate(q, v) {
  const t = scale(cross(q, v), 2);
  return add(add(v, scale(t, q[3])), cross(q, t));
}

/** First b, then a. */
export function turns(a, b) {
  const v = add(add(scale(b, a[3]), scale(a, b[3])), cross(a, b));
  return [v[0], v[1], v[2], a[3] * b[3] - dot(a, b)];
}

/** The quaternion that turns by an angle about a unit axis. */
export function about(axis, angle) {
  const s = Math.sin(angle / 2);
  return [axis[0] * s, axis[1] * s, axis[2] * s, Math.cos(angle / 2)];
}

export const STILL = { at: [0, 0, 0], turn: [0, 0, 0, 1] };

/** The pose b, seen in a's frame, as seen where a is seen. */
export const within = (a, b) => ({
  at: add(a.at, rotate(a.turn, b.at)),
  turn: turns(a.turn, b.turn),
});

/** A point of a pose's frame, seen from outside. */
export const outside = (pose, p) => add(pose.at, rotate(pose.turn, p));

/** A point from outside, seen in a pose's frame. */
export const inside = (pose, p) => rotate(back(pose.turn), sub(p, pose.at));

/** The turn the other way. */
export const back = ([x, y, z, w]) => [-x, -y, -z, w];

/** A pose as a matrix, with a scale along each of its axes. */
export function matrix(pose, sides = [1, 1, 1]) {
  const [x, y, z] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((e, i) => scale(rotate(pose.turn, e), sides[i]));
  return new Float32Array([...x, 0, ...y, 0, ...z, 0, ...pose.at, 1]);
}

/** A matrix that takes z to a direction, with one scale along it and one across. */
export function along(at, direction, across, length) {
  const z = unit(direction);
  const x = aside(z);
  const y = cross(z, x);
  return new Float32Array([...scale(x, across), 0, ...scale(y, across), 0, ...scale(z, length), 0, ...at, 1]);
}

/** a · b. */
export function times(a, b) {
  const out = new Float32Array(16);
  for (let c = 0; c < 4; c++) {
    for (let r = 0; r < 4; r++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * k + r] * b[4 * c + k];
      out[4 * c + r] = sum;
    }
  }
  return out;
}

/** A point through a matrix, with its fourth coordinate. */
export const through = (m, p) => [0, 1, 2, 3].map((r) => m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r]);

/** What looks from an eye to a target, z up unless it looks along z. */
export function lookAt(eye, target, up) {
  const z = unit(sub(eye, target));
  const x = unit(cross(up, z), [1, 0, 0]);
  const y = cross(z, x);
  return new Float32Array([
    x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0,
    -dot(x, eye), -dot(y, eye), -dot(z, eye), 1,
  ]);
}

/** A camera's projection; angle of the whole height. */
export function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2);
  const out = new Float32Array(16);
  out[0] = f / aspect;
  out[5] = f;
  out[10] = (near + far) / (near - far);
  out[11] = -1;
  out[14] = (2 * near * far) / (near - far);
  return out;
}

/** A box without perspective, as lights look. */
export function orthographic(half, near, far) {
  const out = new Float32Array(16);
  out[0] = out[5] = 1 / half;
  out[10] = 2 / (near - far);
  out[14] = (near + far) / (near - far);
  out[15] = 1;
  return out;
}

/** Nothing, to be grown by points. */
export const emptyBox = () => ({ low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity] });

/** Grows a box by a point. */
export function grow(box, p) {
  for (let i = 0; i < 3; i++) {
    box.low[i] = Math.min(box.low[i], p[i]);
    box.high[i] = Math.max(box.high[i], p[i]);
  }
}

export const isBox = (box) => box.low[0] <= box.high[0];

export const middle = (box) => mix(box.low, box.high, 0.5);

export const corners = (box) =>
  [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [0, 1, 2].map((k) => ((i >> k) & 1 ? box.high[k] : box.low[k])));
