// Small surfaces of unit size that marks are made of.
import { TAU, emptyBox, grow } from "./maths.js";
import { shaded } from "./surface.js";

/** Rings of [radius, z] about z, from below to above. */
function lathe(rings, sides = 24) {
  const positions = [];
  const indices = [];
  for (const [radius, z] of rings) {
    for (let i = 0; i < sides; i++) {
      const a = (TAU * i) / sides;
      positions.push(radius * Math.cos(a), radius * Math.sin(a), z);
    }
  }
  for (let r = 0; r + 1 < rings.length; r++) {
    for (let i = 0; i < sides; i++) {
      const [a, b] = [r * sides + i, r * sides + ((i + 1) % sides)];
      indices.push(a, b, b + sides, a, b + sides, a + sides);
    }
  }
  const white = new Uint8Array(positions.length).fill(255);
  return shaded({ positions: new Float32Array(positions), colours: white, indices: new Uint32Array(indices) });
}

/** A bar along z from 0 to 1. */
export const bar = () => lathe([[0, 0], [1, 0], [1, 1], [0, 1]], 16);

/** A cone along z, its tip at 1. */
export const cone = () => lathe([[0, 0], [1, 0], [0, 1]], 24);

/** A ball of radius 1. */
export function sphere() {
  const ring = (i) => [Math.sin((Math.PI * i) / 16), -Math.cos((Math.PI * i) / 16)];
  return lathe(Array.from({ length: 17 }, (_, i) => ring(i)), 32);
}

/** A box from −1 to 1. */
export function cube() {
  const positions = [];
  for (let i = 0; i < 8; i++) positions.push(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  const indices = [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5];
  const white = new Uint8Array(24).fill(255);
  return shaded({ positions: new Float32Array(positions), colours: white, indices: new Uint32Array(indices) });
}

/** Triangles as they are, each with its own normal; corners are three numbers each. */
export function flat(triangles) {
  const count = triangles.length / 3;
  const positions = new Float32Array(triangles);
  const normals = new Int8Array(4 * count);
  const colours = new Uint8Array(4 * count).fill(255);
  const box = emptyBox();
  for (let c = 0; c < count; c++) {
    normals[4 * c + 2] = 127;
    grow(box, positions.subarray(3 * c, 3 * c + 3));
  }
  return { positions, normals, colours, count, box };
}
