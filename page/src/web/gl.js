// The little of WebGL 2 that is asked for again and again.

/** A context, or why there is none. */
export function context(canvas) {
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: false, powerPreference: "high-performance" });
  if (!gl) throw new Error("no WebGL 2");
  return gl;
}

function compiled(gl, kind, text) {
  const shader = gl.createShader(kind);
  gl.shaderSource(shader, `#version 300 es\nprecision highp float;\nprecision highp int;\n${text}`);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
    throw new Error(`shader: ${gl.getShaderInfoLog(shader)}`);
  }
  return shader;
}

/** A program and its uniforms by name. */
export function program(gl, vertex, fragment) {
  const made = gl.createProgram();
  gl.attachShader(made, compiled(gl, gl.VERTEX_SHADER, vertex));
  gl.attachShader(made, compiled(gl, gl.FRAGMENT_SHADER, fragment));
  ["position", "normal", "colour"].forEach((name, i) => gl.bindAttribLocation(made, i, name));
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(`program: ${gl.getProgramInfoLog(made)}`);
  }
  const at = {};
  const count = gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS) ?? 0;
  for (let i = 0; i < count; i++) {
    const { name } = gl.getActiveUniform(made, i);
    at[name] = gl.getUniformLocation(made, name);
  }
  return { made, at };
}

/** Positions, normals and colours as a program reads them: numbers a point, of what type, scaled to 1. */
const layout = (gl) => [[3, gl.FLOAT, false], [4, gl.BYTE, true], [4, gl.UNSIGNED_BYTE, true]];

function attribute(gl, index, buffer) {
  const [width, type, normalised] = layout(gl)[index];
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.enableVertexAttribArray(index);
  gl.vertexAttribPointer(index, width, type, normalised, 0, 0);
}

/** A surface on the card. */
export function upload(gl, surface) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  const buffers = [surface.positions, surface.normals, surface.colours].map((data, i) => {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    attribute(gl, i, buffer);
    return buffer;
  });
  gl.bindVertexArray(null);
  return { array, buffers, count: surface.count, box: surface.box };
}

/** Some corners of a surface that is on the card, by their numbers. */
export function selection(gl, whole, corners) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  whole.buffers.forEach((buffer, i) => attribute(gl, i, buffer));
  const elements = gl.createBuffer();
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, elements);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
  gl.bindVertexArray(null);
  return { array, elements, buffers: [], count: corners.length, box: whole.box };
}

/** Lets a surface go. */
export function forget(gl, mesh) {
  if (!mesh) return;
  gl.deleteVertexArray(mesh.array);
  mesh.buffers.forEach((buffer) => gl.deleteBuffer(buffer));
  if (mesh.elements) gl.deleteBuffer(mesh.elements);
}

/** A picture to draw into, of one colour format and with a depth, either of which may be missing. */
export function target(gl, width, height, colour, depth) {
  const made = { frame: gl.createFramebuffer(), width, height, colour: null, depth: null };
  gl.bindFramebuffer(gl.FRAMEBUFFER, made.frame);
  const texture = (format, filter) => {
    const t = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, t);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, filter);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    return t;
  };
  if (colour) {
    made.colour = texture(colour, colour === gl.R8 ? gl.LINEAR : gl.NEAREST);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, made.colour, 0);
  } else {
    gl.drawBuffers([gl.NONE]);
  }
  if (depth) {
    made.depth = texture(gl.DEPTH_COMPONENT24, gl.NEAREST);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, made.depth, 0);
  }
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return made;
}

/** Lets a picture go. */
export function drop(gl, made) {
  if (!made) return;
  gl.deleteFramebuffer(made.frame);
  for (const texture of [made.colour, made.depth]) if (texture) gl.deleteTexture(texture);
}

/** Hands a picture to a program. */
export function sample(gl, at, unitNumber, texture) {
  gl.activeTexture(gl.TEXTURE0 + unitNumber);
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.uniform1i(at, unitNumber);
}
