// What an axis can be pulled to: lines that were found, edges of the mesh, the object's own directions.
import { add, dot, scale, size, sub, unit } from "../maths.js";
import { DEGREE, fromStretch, likewise, tilt } from "./geometry.js";

/** How near, degrees and pixels. */
const NEAR = { candidate: 7, own: 4, edge: 30, side: 15, pixels: 12 };
const OWN = [[[1, 0, 0], "left to right"], [[0, 1, 0], "front to back"], [[0, 0, 1], "straight up"]];

/** The sharp edge of the mesh next to a place of the screen, or nothing. */
export function edgeNear(view, at) {
  const found = view.hit(at);
  if (!found) return null;
  const away = size(sub(found.world, view.camera.eye())) / (view.camera.distance * view.camera.spread);
  const reach = NEAR.pixels * view.camera.pixel(view.canvas.clientHeight) * away;
  let best = null;
  let least = NEAR.pixels;
  for (const [from, to] of view.body.edgesOf(new Set([found.face, ...view.body.tree.ball(found.point, reach)]))) {
    const [a, b] = [view.onScreen(from), view.onScreen(to)];
    if (!a || !b) continue;
    const far = fromStretch(at, a, b);
    if (far >= least) continue;
    least = far;
    best = { from, to };
  }
  return best && { ...best, far: least, axis: unit(sub(best.to, best.from)) };
}

const nearestOn = (at, axis, p) => add(at, scale(axis, dot(sub(p, at), axis)));

/** A direction that an axis through a centre can be snapped to, with words. */
export function snapDirection(view, candidates, centre, axis, at) {
  const offers = [];
  candidates.forEach(({ axis: other, pivot, score }, i) => {
    const far = tilt(axis, other) / DEGREE;
    const off = size(sub(nearestOn(pivot, unit(other), centre), centre));
    const isThere = off < 0.04 * view.model.diagonal;
    if (far < NEAR.candidate) offers.push({ cost: far - 3, axis: likewise(unit(other), axis), pivot: isThere ? nearestOn(pivot, unit(other), centre) : null, words: `found line ${i + 1}, score ${score.toFixed(2)}` });
  });
  for (const [own, words] of OWN) {
    const far = tilt(axis, own) / DEGREE;
    if (far < NEAR.own) offers.push({ cost: far, axis: likewise(own, axis), pivot: null, words });
  }
  const edge = edgeNear(view, at);
  if (edge && tilt(axis, edge.axis) / DEGREE < NEAR.edge) offers.push({ cost: -5, axis: likewise(edge.axis, axis), pivot: null, line: [edge.from, edge.to], words: "along an edge" });
  return offers.sort((a, b) => a.cost - b.cost)[0] ?? null;
}

/** A line that a pivot can be snapped to, with words. */
export function snapPlace(view, candidates, centre, axis, at) {
  const offers = [];
  candidates.forEach(({ axis: other, pivot, score }, i) => {
    const way = unit(other);
    if (tilt(axis, way) / DEGREE > NEAR.side) return;
    const on = nearestOn(pivot, way, centre);
    const half = scale(way, 0.3 * view.model.diagonal);
    const [a, b] = [view.onScreen(sub(on, half)), view.onScreen(add(on, half))];
    const far = a && b ? fromStretch(at, a, b) : Infinity;
    if (far < NEAR.pixels) offers.push({ cost: far - 1, axis: likewise(way, axis), pivot: on, words: `found line ${i + 1}, score ${score.toFixed(2)}` });
  });
  const edge = edgeNear(view, at);
  if (edge) {
    const isParallel = tilt(axis, edge.axis) / DEGREE < NEAR.side;
    const on = isParallel ? nearestOn(edge.from, edge.axis, centre) : nearestPoint(edge, view.rayAt(at));
    const words = isParallel ? "on an edge" : "through a point of an edge";
    offers.push({ cost: edge.far, axis: isParallel ? likewise(edge.axis, axis) : null, pivot: on, line: [edge.from, edge.to], words });
  }
  return offers.sort((a, b) => a.cost - b.cost)[0] ?? null;
}

/** The point of an edge nearest to a ray. */
function nearestPoint({ from, to, axis }, ray) {
  const between = sub(from, ray.from);
  const b = dot(axis, ray.way);
  const far = (b * dot(ray.way, between) - dot(axis, between)) / Math.max(1 - b * b, 1e-6);
  return add(from, scale(axis, Math.min(Math.max(far, 0), size(sub(to, from)))));
}
