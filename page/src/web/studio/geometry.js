// Lines, rays and planes.
import { add, cross, dot, scale, size, sub, unit } from "../maths.js";

/** A degree in radians. */
export const DEGREE = Math.PI / 180;

/** How far along a line the point nearest to a ray lies; nothing where they run side by side. */
export function alongLine(at, axis, ray) {
  const between = sub(at, ray.from);
  const b = dot(axis, ray.way);
  const apart = 1 - b * b;
  if (apart < 1e-6) return null;
  return (b * dot(ray.way, between) - dot(axis, between)) / apart;
}

/** Where a ray meets a plane; nothing where it runs along it. */
export function onPlane(at, normal, ray) {
  const slope = dot(normal, ray.way);
  if (Math.abs(slope) < 1e-4) return null;
  const far = dot(normal, sub(at, ray.from)) / slope;
  return far > 0 ? add(ray.from, scale(ray.way, far)) : null;
}

/** The direction from a centre to where a ray meets a ball, on the near or the far side; beside it, the nearest. */
export function onBall(centre, radius, ray, isNear) {
  const between = sub(centre, ray.from);
  const middle = dot(between, ray.way);
  const off = sub(add(ray.from, scale(ray.way, middle)), centre);
  const left = radius * radius - dot(off, off);
  if (left <= 0) return unit(off);
  return unit(add(off, scale(ray.way, (isNear ? -1 : 1) * Math.sqrt(left))));
}

/** The angle between two lines, whichever way they point. */
export const tilt = (a, b) => Math.atan2(size(cross(a, b)), Math.abs(dot(a, b)));

/** The same line's direction that points the way of another. */
export const likewise = (a, other) => (dot(a, other) < 0 ? scale(a, -1) : a);

/** The angle from one vector to another about an axis, −π to π. */
export const angleAbout = (axis, from, to) => Math.atan2(dot(axis, cross(from, to)), dot(from, to));

/** How far a place of the screen lies from a stretch of it. */
export function fromStretch([x, y], a, b) {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  const long = dx * dx + dy * dy;
  const k = long > 0 ? Math.min(Math.max(((x - a[0]) * dx + (y - a[1]) * dy) / long, 0), 1) : 0;
  return Math.hypot(x - a[0] - k * dx, y - a[1] - k * dy);
}
