// A camera that goes round a point.
import { add, clamp, corners, lookAt, middle, mix, perspective, scale, size, sub, times, unit, cross, dot } from "./maths.js";

const ANGLE = (32 * Math.PI) / 180;
const STEEPEST = Math.PI / 2 - 0.001;

/** Directions to look from: turn about z from the front, and height, radians. */
export const SIDES = {
  "three-quarter": [0.62, 0.42],
  front: [0, 0],
  right: [Math.PI / 2, 0],
  top: [0, STEEPEST],
  back: [Math.PI, 0],
};

export class Camera {
  constructor() {
    [this.yaw, this.pitch] = SIDES["three-quarter"];
    this.target = [0, 0, 0];
    this.distance = 1;
    this.extent = 1;
    this.spread = 1;
    this.goal = null;
  }

  /** From the target to the eye. */
  direction() {
    const c = Math.cos(this.pitch);
    return [c * Math.sin(this.yaw), -c * Math.cos(this.yaw), Math.sin(this.pitch)];
  }

  eye() {
    return add(this.target, scale(this.direction(), this.distance * this.spread));
  }

  axes() {
    const z = this.direction();
    const x = unit(cross([0, 0, 1], z), [1, 0, 0]);
    return { x, y: cross(z, x), z };
  }

  /** The ray from the eye through a place of the picture (−1 to 1 each way). */
  ray([u, v], aspect) {
    const { x, y, z } = this.axes();
    const slope = Math.tan(ANGLE / 2);
    const way = add(add(scale(x, u * slope * aspect), scale(y, v * slope)), scale(z, -1));
    return { from: this.eye(), way: unit(way) };
  }

  /** How long a pixel is at the target, of so many that are the height of the view. */
  pixel(height) {
    return (2 * this.distance * this.spread * Math.tan(ANGLE / 2)) / Math.max(height, 1);
  }

  matrices(aspect) {
    const away = this.distance * this.spread;
    const near = Math.max(away - 3 * this.extent, 0.01 * away);
    const far = away + 6 * this.extent;
    const view = lookAt(this.eye(), this.target, [0, 0, 1]);
    const projection = perspective(ANGLE, aspect, near, far);
    return { view, projection, both: times(projection, view), near, far };
  }

  orbit(dx, dy) {
    this.goal = null;
    this.yaw -= dx;
    this.pitch = clamp(this.pitch + dy, -STEEPEST, STEEPEST);
  }

  /** Moves across the view, by shares of its height. */
  pan(dx, dy) {
    this.goal = null;
    const { x, y } = this.axes();
    const height = 2 * this.distance * this.spread * Math.tan(ANGLE / 2);
    this.target = add(this.target, add(scale(x, -dx * height), scale(y, dy * height)));
  }

  /** Nearer or farther, towards a place of the picture (−1 to 1 each way). */
  zoom(factor, at = [0, 0], aspect = 1) {
    this.goal = null;
    const before = this.distance;
    this.distance = clamp(before * factor, 0.02 * this.extent, 12 * this.extent);
    const { x, y } = this.axes();
    const moved = (before - this.distance) * Math.tan(ANGLE / 2);
    this.target = add(this.target, add(scale(x, at[0] * moved * aspect), scale(y, at[1] * moved)));
  }

  /** The place and distance from which a box fills the view, but for what `tall` leaves of its height. */
  fitting(box, aspect, tall = 0.86, [yaw, pitch] = [this.yaw, this.pitch]) {
    const target = middle(box);
    const probe = Object.assign(new Camera(), { yaw, pitch });
    const { x, y, z } = probe.axes();
    const slope = Math.tan(ANGLE / 2);
    let distance = 1e-3;
    for (const corner of corners(box)) {
      const p = sub(corner, target);
      const needed = Math.max(Math.abs(dot(p, x)) / (0.9 * aspect), Math.abs(dot(p, y)) / tall) / slope;
      distance = Math.max(distance, needed + dot(p, z));
    }
    return { target, distance, yaw, pitch };
  }

  /** Goes to a place, in steps if `calmly`. */
  go(goal, calmly) {
    if (calmly) {
      this.goal = { from: { target: this.target, distance: this.distance, yaw: this.yaw, pitch: this.pitch }, to: goal, done: 0 };
      const round = (goal.yaw ?? this.yaw) - this.yaw;
      this.goal.to = { ...this.goal.from, ...goal, yaw: this.yaw + Math.atan2(Math.sin(round), Math.cos(round)) };
    } else {
      Object.assign(this, goal);
    }
  }

  /** Goes on; true while there is farther to go. */
  step(seconds) {
    if (!this.goal) return false;
    const { from, to } = this.goal;
    this.goal.done = Math.min(this.goal.done + seconds / 0.45, 1);
    const k = 1 - (1 - this.goal.done) ** 3;
    this.target = mix(from.target, to.target, k);
    this.distance = from.distance * (to.distance / from.distance) ** k;
    this.yaw = from.yaw + (to.yaw - from.yaw) * k;
    this.pitch = from.pitch + (to.pitch - from.pitch) * k;
    if (this.goal.done >= 1) this.goal = null;
    return this.goal !== null;
  }

  /** Knows how large the object is. */
  knows(box) {
    this.extent = Math.max(size(sub(box.high, box.low)), 1e-6);
  }
}
