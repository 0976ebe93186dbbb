// What stands packed in the page: see `pack.rs` for the order of its bytes.

/** The bytes behind base64 and deflate. */
export async function inflated(text) {
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** A surface: positions, colours of its points (or one of all), three corners a face. */
export function unpack(bytes, packed) {
  const { vertices: n, faces, low, size } = packed;
  let at = packed.at;
  const positions = new Float32Array(3 * n);
  for (let axis = 0; axis < 3; axis++) {
    let value = 0;
    for (let i = 0; i < n; i++) {
      const z = bytes[at + i] | (bytes[at + n + i] << 8);
      value = (value + ((z >> 1) ^ -(z & 1))) & 0xffff;
      positions[3 * i + axis] = low[axis] + (size[axis] * value) / 65535;
    }
    at += 2 * n;
  }
  const colours = new Uint8Array(3 * n);
  for (let channel = 0; channel < 3; channel++) {
    let value = packed.colour ? packed.colour[channel] : 0;
    for (let i = 0; i < n; i++) {
      if (!packed.colour) value = (value + bytes[at + i]) & 0xff;
      colours[3 * i + channel] = value;
    }
    at += packed.colour ? 0 : n;
  }
  const indices = new Uint32Array(3 * faces);
  let known = 0;
  for (let i = 0; i < indices.length; i++) {
    let back = 0;
    let shift = 0;
    let byte;
    do {
      byte = bytes[at++];
      back |= (byte & 0x7f) << shift;
      shift += 7;
    } while (byte & 0x80);
    indices[i] = known - back;
    known = Math.max(known, known - back + 1);
  }
  return { positions, colours, indices };
}
