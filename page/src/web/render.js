// Draws a frame: what is solid, what is sheer, and marks over both.
import { add, lookAt, middle, orthographic, scale, size, sub, times, unit } from "./maths.js";
import { context, drop, forget, program, sample, selection, target, upload } from "./gl.js";
import { BLUR, DEPTH, DUSK, GROUND, LINES, PICK, SKY, SOLID } from "./shaders.js";

const SUN = unit([-0.5, -0.62, 1.45]);
const SHADOW = 1536;
/** How strong what is hidden still shows, of marks. */
const HIDDEN = 0.28;
/** Floats a segment of a line takes. */
const SEGMENT = 8;

export class Renderer {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = context(canvas);
    this.gl = gl;
    const made = ({ vertex, fragment }) => program(gl, vertex, fragment);
    [this.solid, this.depth, this.picks, this.sky, this.dusk, this.blur, this.ground, this.lines] = [
      SOLID, DEPTH, PICK, SKY, DUSK, BLUR, GROUND, LINES,
    ].map(made);
    this.bare = gl.createVertexArray();
    this.shade = target(gl, SHADOW, SHADOW, null, true);
    gl.bindTexture(gl.TEXTURE_2D, this.shade.depth);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    // What is touched lies over what is seen, where both are in one place.
    gl.polygonOffset(-1, -4);
    this.prepareLines();
  }

  mesh(surface) {
    return upload(this.gl, surface);
  }

  /** Some faces of a mesh, by number. */
  faces(whole, list) {
    const corners = new Uint32Array(3 * list.length);
    list.forEach((f, i) => corners.set([3 * f, 3 * f + 1, 3 * f + 2], 3 * i));
    return selection(this.gl, whole, corners);
  }

  /** Other colours for all of a mesh. */
  recolour(mesh, colours) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, mesh.buffers[2]);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, colours);
  }

  forget(mesh) {
    forget(this.gl, mesh);
  }

  prepareLines() {
    const { gl } = this;
    this.strokes = { array: gl.createVertexArray(), buffer: gl.createBuffer() };
    gl.bindVertexArray(this.strokes.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.strokes.buffer);
    const places = [[0, 3, gl.FLOAT, false, 0], [1, 3, gl.FLOAT, false, 12], [2, 4, gl.UNSIGNED_BYTE, true, 24], [3, 1, gl.FLOAT, false, 28]];
    for (const [index, width, type, normalised, at] of places) {
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, width, type, normalised, 4 * SEGMENT, at);
      gl.vertexAttribDivisor(index, 1);
    }
    gl.bindVertexArray(null);
  }

  /** Takes the size of its place on the screen; true if that changed. */
  fit(ratio) {
    const width = Math.max(Math.round(this.canvas.clientWidth * ratio), 1);
    const height = Math.max(Math.round(this.canvas.clientHeight * ratio), 1);
    if (this.canvas.width === width && this.canvas.height === height && this.early) return false;
    Object.assign(this.canvas, { width, height });
    const { gl } = this;
    [this.early, this.grainy, this.smooth, this.asked].forEach((t) => drop(gl, t));
    const [w, h] = [Math.ceil(width / 2), Math.ceil(height / 2)];
    this.early = target(gl, w, h, null, true);
    this.grainy = target(gl, w, h, gl.R8, false);
    this.smooth = target(gl, w, h, gl.R8, false);
    this.asked = null;
    return true;
  }

  /** A light that sees all of a box. */
  light({ low, high }) {
    const centre = middle({ low, high });
    const half = Math.max(0.6 * size(sub(high, low)), 1e-6);
    const eye = add(centre, scale(SUN, 3 * half));
    return times(orthographic(half, 0.5 * half, 6 * half), lookAt(eye, centre, [0, 0, 1]));
  }

  draw(frame) {
    const { gl } = this;
    if (gl.isContextLost()) return;
    frame.light = this.light(frame.box);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    this.depths(this.shade, frame.solid, frame.light);
    this.depths(this.early, frame.solid, frame.camera.both);
    this.darken(frame);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.drawSky(frame);
    this.bodies(frame, frame.solid, 1);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    this.drawGround(frame);
    this.bodies(frame, frame.sheer, 0);
    gl.depthMask(true);
    for (const [test, share] of [[gl.GREATER, HIDDEN], [gl.LEQUAL, 1]]) {
      gl.depthFunc(test);
      gl.depthMask(share === 1);
      this.bodies(frame, frame.marks.filter((m) => m.alpha >= 0.5), 0, share);
      this.strokesOf(frame, frame.lines, share);
      gl.depthMask(false);
      this.bodies(frame, frame.marks.filter((m) => m.alpha < 0.5), 0, share);
    }
    // What was found is seen through everything.
    gl.disable(gl.DEPTH_TEST);
    this.bodies(frame, frame.spots, 0);
    this.strokesOf(frame, frame.rings, 1);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.depthMask(true);
    gl.bindVertexArray(null);
  }

  depths(into, items, both) {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, into.frame);
    gl.viewport(0, 0, into.width, into.height);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.depth.made);
    gl.uniformMatrix4fv(this.depth.at.both, false, both);
    for (const item of items) this.emit(this.depth, item);
  }

  emit(using, item) {
    const { gl } = this;
    gl.uniformMatrix4fv(using.at.model, false, item.matrix);
    gl.bindVertexArray(item.mesh.array);
    if (item.mesh.elements) gl.drawElements(gl.TRIANGLES, item.mesh.count, gl.UNSIGNED_INT, 0);
    else gl.drawArrays(gl.TRIANGLES, 0, item.mesh.count);
  }

  /** What of the sky is hidden, evened out. */
  darken({ camera, reach }) {
    const { gl } = this;
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(this.bare);
    const pass = (into, using, set) => {
      gl.bindFramebuffer(gl.FRAMEBUFFER, into.frame);
      gl.viewport(0, 0, into.width, into.height);
      gl.useProgram(using.made);
      sample(gl, using.at.depth, 0, this.early.depth);
      set(using.at);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    };
    pass(this.grainy, this.dusk, (at) => {
      gl.uniformMatrix4fv(at.projection, false, camera.projection);
      gl.uniform1f(at.reach, reach);
    });
    pass(this.smooth, this.blur, (at) => {
      sample(gl, at.dusk, 1, this.grainy.colour);
      gl.uniform2f(at.range, camera.near, camera.far);
    });
    gl.enable(gl.DEPTH_TEST);
  }

  drawSky({ theme }) {
    const { gl } = this;
    gl.useProgram(this.sky.made);
    gl.uniform3fv(this.sky.at.high, theme.high);
    gl.uniform3fv(this.sky.at.low, theme.low);
    gl.bindVertexArray(this.bare);
    gl.depthMask(false);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.depthMask(true);
  }

  drawGround({ ground, theme, camera, light, eye }) {
    if (!ground || eye[2] < ground.centre[2]) return;
    const { gl } = this;
    const { made, at } = this.ground;
    gl.useProgram(made);
    gl.uniformMatrix4fv(at.both, false, camera.both);
    gl.uniformMatrix4fv(at.light, false, light);
    gl.uniform3fv(at.centre, ground.centre);
    gl.uniform1f(at.radius, ground.radius);
    gl.uniform1f(at.step_size, ground.step);
    gl.uniform3fv(at.ink, theme.ink);
    gl.uniform3fv(at.chalk, theme.chalk);
    gl.uniform1f(at.strength, theme.shadow);
    gl.uniform1f(at.grid, theme.grid);
    sample(gl, at.shadow, 0, this.shade.depth);
    gl.bindVertexArray(this.bare);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }

  bodies(frame, items, soft, share = 1) {
    const { gl } = this;
    const { made, at } = this.solid;
    gl.useProgram(made);
    gl.uniformMatrix4fv(at.both, false, frame.camera.both);
    gl.uniformMatrix4fv(at.light, false, frame.light);
    gl.uniform3fv(at.eye, frame.eye);
    gl.uniform3fv(at.sun, SUN);
    gl.uniform2f(at.screen, this.canvas.width, this.canvas.height);
    gl.uniform1f(at.soft, soft);
    sample(gl, at.shadow, 0, this.shade.depth);
    sample(gl, at.dusk, 1, this.smooth.colour);
    for (const item of items) {
      if (item.ahead) gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.uniform4fv(at.tint, item.tint ?? [0, 0, 0, 0]);
      gl.uniform4fv(at.pale, item.pale ?? [0, 0, 0, 0]);
      gl.uniform1f(at.alpha, item.alpha * share);
      gl.uniform1f(at.glow, item.glow ?? 0);
      gl.uniform1f(at.plain, item.plain ? 1 : 0);
      this.emit(this.solid, item);
      gl.disable(gl.POLYGON_OFFSET_FILL);
    }
  }

  /** Lines: [from, to, [r, g, b, a], pixels]. */
  strokesOf(frame, lines, share) {
    if (!lines.length) return;
    const { gl } = this;
    const floats = new Float32Array(SEGMENT * lines.length);
    const bytes = new Uint8Array(floats.buffer);
    lines.forEach(([from, to, colour, width], i) => {
      floats.set(from, SEGMENT * i);
      floats.set(to, SEGMENT * i + 3);
      bytes.set(colour.map((c) => Math.round(255 * c)), 4 * (SEGMENT * i + 6));
      floats[SEGMENT * i + 7] = width * frame.ratio;
    });
    gl.bindVertexArray(this.strokes.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.strokes.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, floats, gl.DYNAMIC_DRAW);
    gl.useProgram(this.lines.made);
    gl.uniformMatrix4fv(this.lines.at.both, false, frame.camera.both);
    gl.uniform2f(this.lines.at.screen, this.canvas.width, this.canvas.height);
    gl.uniform1f(this.lines.at.alpha, share);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, lines.length);
  }

  /** What lies under a pixel (from the top left, of the canvas): its item and its depth, or nothing. */
  pick(items, both, [x, y]) {
    const { gl } = this;
    const { width, height } = this.canvas;
    this.asked ??= target(gl, width, height, gl.RGBA32UI, true);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.asked.frame);
    gl.viewport(0, 0, width, height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(x, height - 1 - y, 1, 1);
    gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.disable(gl.BLEND);
    gl.useProgram(this.picks.made);
    gl.uniformMatrix4fv(this.picks.at.both, false, both);
    items.forEach((item, i) => {
      gl.uniform1ui(this.picks.at.item, i + 1);
      this.emit(this.picks, item);
    });
    gl.disable(gl.SCISSOR_TEST);
    const read = new Uint32Array(4);
    gl.readPixels(x, height - 1 - y, 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, read);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    if (!read[0]) return null;
    return { item: items[read[0] - 1], depth: new Float32Array(read.buffer)[1] };
  }
}
