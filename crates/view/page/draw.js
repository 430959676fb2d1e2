// Draws the stage: shadows first, then bodies, sky and what lies over them.

import * as shaders from './shaders.js';
import { PLANE } from './wire.js';
import { add, around, cross, dot, multiply, orthographic, scale, sub, turning, unit } from './matrix.js';
/** @typedef {import('./matrix.js').Vec3} Vec3 */
/** @typedef {import('./stage.js').Stage} Stage */
/** @typedef {import('./camera.js').Camera} Camera */

/** Towards the sun, as in pictures. */
const SUN = unit([-0.42, -0.62, 0.66]);

export class Draw {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    /** Whether there is no card, and the processor draws: then all of it is kept small. */
    this.software = drawsByProcessor();
    const gl = canvas.getContext('webgl2', { antialias: !this.software, alpha: false, powerPreference: 'high-performance' });
    if (!gl) throw new Error('This browser has no WebGL 2, by which the scene is drawn.');
    this.canvas = canvas;
    this.gl = gl;
    this.bodies = program(gl, shaders.BODY_VERTEX, shaders.BODY_FRAGMENT);
    this.shade = program(gl, shaders.SHADOW_VERTEX, shaders.SHADOW_FRAGMENT);
    this.finder = program(gl, shaders.PICK_VERTEX, shaders.PICK_FRAGMENT);
    this.sky = program(gl, shaders.SKY_VERTEX, shaders.SKY_FRAGMENT);
    this.line = program(gl, shaders.LINE_VERTEX, shaders.LINE_FRAGMENT);
    this.shadows = true;
    this.dark = false;
    this.pick = -1;
    /** From the record before to the newest one. */
    this.mix = 1;
    /** Pixels of the picture for one of the screen: fewer where the card is slow. */
    this.ratio = this.software ? 0.75 : Math.min(devicePixelRatio, 2);
    /** Pixels of the sun's picture, each way. */
    this.shadowSize = this.software ? 1024 : 2048;
    this.target = shadowMap(gl, this.shadowSize);
    this.found = pixel(gl);
    this.empty = gl.createVertexArray();
    this.lineBuffer = gl.createBuffer();
    this.lineVertices = lineVertices(gl, this.lineBuffer);
    this.extraBuffer = gl.createBuffer();
    this.extraVertices = lineVertices(gl, this.extraBuffer);
    this.extent = { middle: /** @type {Vec3} */ ([0, 0, 0]), radius: 5 };
    this.calls = 0;
  }

  get aspect() {
    return this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight);
  }

  /** Makes the picture as large as the page has it. */
  fit() {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight].map((x) => Math.max(1, Math.round(x * this.ratio)));
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
  }

  /** @param {Stage} stage @param {Camera} camera @param {number[]} extra ends of a line over all others, from the origin */
  draw(stage, camera, extra = []) {
    const { gl, canvas } = this;
    this.fit();
    stage.upload();
    const eye = camera.eye, lens = camera.lens(this.aspect);
    const sun = this.sunLens(camera);
    gl.enable(gl.DEPTH_TEST);
    if (this.shadows) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.target.frame);
      gl.viewport(0, 0, this.shadowSize, this.shadowSize);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.polygonOffset(1.5, 2);
      this.instances(this.shade, stage, eye, sun, (group) => group.kind !== PLANE);
      gl.disable(gl.POLYGON_OFFSET_FILL);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);

    const { uniform } = this.bodies;
    gl.useProgram(this.bodies.program);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.target.texture);
    gl.uniformMatrix4fv(uniform.u_sun, false, sun);
    gl.uniform1i(uniform.u_shadow, 0);
    gl.uniform1f(uniform.u_shadows, this.shadows ? 1 : 0);
    gl.uniform1f(uniform.u_texel, 1 / this.shadowSize);
    gl.uniform1f(uniform.u_reach, 6.5 * Math.max(camera.distance, 0.6 * this.extent.radius));
    gl.uniform1i(uniform.u_pick, this.pick);
    gl.uniform3fv(uniform.u_eye, eye);
    gl.uniform1f(uniform.u_grid, 10 ** Math.floor(Math.log10(camera.distance / 4)));
    this.light(uniform);
    this.instances(this.bodies, stage, eye, lens, () => true);

    const [r, u, f] = camera.axes;
    gl.useProgram(this.sky.program);
    gl.bindVertexArray(this.empty);
    gl.uniform3fv(this.sky.uniform.u_right, scale(r, camera.half * this.aspect));
    gl.uniform3fv(this.sky.uniform.u_up, scale(u, camera.half));
    gl.uniform3fv(this.sky.uniform.u_forward, add(f, scale(r, camera.shift * camera.half * this.aspect)));
    this.light(this.sky.uniform);
    gl.depthFunc(gl.LEQUAL);
    gl.drawArrays(gl.TRIANGLES, 0, 3);

    if (stage.linesChanged) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.lineBuffer);
      gl.bufferData(gl.ARRAY_BUFFER, stage.lines, gl.DYNAMIC_DRAW);
      stage.linesChanged = false;
    }
    if (stage.lineCount > 0) this.lines(this.lineVertices, stage.lineCount, eye, lens, 1.2);
    if (extra.length > 0) {
      const words = new Float32Array(7);
      words.set(extra);
      new Uint32Array(words.buffer)[6] = 0x0040b8ff;
      gl.bindBuffer(gl.ARRAY_BUFFER, this.extraBuffer);
      gl.bufferData(gl.ARRAY_BUFFER, words, gl.DYNAMIC_DRAW);
      this.lines(this.extraVertices, 1, eye, lens, 2);
    }
    gl.depthFunc(gl.LESS);
    gl.bindVertexArray(null);
    this.calls++;
  }

  /** @param {Record<string, WebGLUniformLocation | null>} uniform */
  light(uniform) {
    this.gl.uniform3fv(uniform.u_sun_at, SUN);
    this.gl.uniform1f(uniform.u_dark, this.dark ? 1 : 0);
  }

  /** @param {{program: WebGLProgram, uniform: Record<string, WebGLUniformLocation | null>}} program @param {Stage} stage @param {Vec3} eye @param {Float32Array} lens @param {(group: import('./stage.js').Group) => boolean} wanted */
  instances(program, stage, eye, lens, wanted) {
    const { gl } = this;
    const { uniform } = program;
    const cell = eye.map((x) => Math.round(x / stage.step));
    gl.useProgram(program.program);
    gl.uniform3iv(uniform.u_cell, cell.map((x) => x + 0x80000));
    gl.uniform3fv(uniform.u_rest, cell.map((x, k) => x * stage.step - eye[k]));
    gl.uniform1f(uniform.u_step, stage.step);
    gl.uniform1f(uniform.u_mix, this.mix);
    gl.uniformMatrix4fv(uniform.u_lens, false, lens);
    for (const group of stage.groups) {
      if (!wanted(group)) continue;
      gl.uniform1i(uniform.u_kind, group.kind);
      gl.uniform1i(uniform.u_first, group.first);
      if (group.closed) gl.enable(gl.CULL_FACE);
      else gl.disable(gl.CULL_FACE);
      gl.bindVertexArray(group.vertices);
      gl.drawElementsInstanced(gl.TRIANGLES, group.count, gl.UNSIGNED_INT, 0, group.bodies);
    }
    gl.disable(gl.CULL_FACE);
  }

  /** @param {WebGLVertexArrayObject | null} vertices @param {number} count @param {Vec3} eye @param {Float32Array} lens @param {number} width */
  lines(vertices, count, eye, lens, width) {
    const { gl } = this;
    const { uniform } = this.line;
    gl.useProgram(this.line.program);
    gl.bindVertexArray(vertices);
    gl.uniform3fv(uniform.u_eye, eye);
    gl.uniformMatrix4fv(uniform.u_lens, false, lens);
    gl.uniform2f(uniform.u_size, this.canvas.width, this.canvas.height);
    gl.uniform1f(uniform.u_width, width * this.ratio);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    // What is behind something shines through it faintly.
    for (const [test, strength] of [[gl.GREATER, 0.28], [gl.LEQUAL, 0.95]]) {
      gl.depthFunc(test);
      gl.uniform1f(uniform.u_strength, strength);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    }
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }

  /** From the eye to the picture of the sun, which moves by whole pixels so that edges stand still. @param {Camera} camera */
  sunLens(camera) {
    const wide = Math.min(1.05 * this.extent.radius, 1.6 * camera.distance);
    const half = 2 ** (Math.ceil(4 * Math.log2(Math.max(wide, 1e-3))) / 4);
    const middle = wide < this.extent.radius ? camera.target : this.extent.middle;
    const right = unit(cross(scale(SUN, -1), [0, 0, 1])), up = cross(right, scale(SUN, -1));
    const texel = (2 * half) / this.shadowSize;
    /** @param {Vec3} axis */
    const rest = (axis) => Math.round(dot(middle, axis) / texel) * texel - dot(middle, axis);
    const at = add(middle, add(scale(right, rest(right)), scale(up, rest(up))));
    const depth = 4 * half + this.extent.radius;
    const shift = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, ...sub(camera.eye, at), 1]);
    return multiply(orthographic(half, -depth, depth), multiply(turning(scale(SUN, -1), [0, 0, 1]), shift));
  }

  /** What is at a point of the picture, from -1 to 1 each: its place in the stage, and where, metres from the origin. @param {Stage} stage @param {Camera} camera @param {number} x @param {number} y */
  at(stage, camera, x, y) {
    const { gl, canvas } = this;
    this.fit();
    stage.upload();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.found);
    gl.viewport(0, 0, 1, 1);
    gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    this.instances(this.finder, stage, camera.eye, around(camera.lens(this.aspect), x, y, canvas.width, canvas.height), () => true);
    const words = new Uint32Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, words);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.bindVertexArray(null);
    if (words[0] === 0) return null;
    const depth = new Float32Array(words.buffer)[1];
    const way = camera.way(x, y, this.aspect);
    const distance = depth / dot(way, camera.axes[2]);
    const slot = words[0] - 1;
    return { slot, row: stage.rows[slot], depth, point: add(camera.eye, scale(way, distance)) };
  }

  /** All pixels of the picture, from its lower left corner: red, green, blue and one more. For tests; to be called after drawing, before the page goes on. */
  pixels() {
    const { gl, canvas } = this;
    const bytes = new Uint8Array(4 * canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
  }
}

/** @param {WebGL2RenderingContext} gl @param {string} vertex @param {string} fragment */
function program(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [kind, text] of /** @type {[number, string][]} */ ([[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]])) {
    const shader = gl.createShader(kind);
    if (!shader) throw new Error('The graphics card was lost.');
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) ?? 'a shader is wrong');
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) ?? 'shaders do not fit');
  /** @type {Record<string, WebGLUniformLocation | null>} */
  const uniform = {};
  for (let k = 0; k < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); k++) {
    const name = gl.getActiveUniform(program, k)?.name ?? '';
    uniform[name] = gl.getUniformLocation(program, name);
  }
  return { program, uniform };
}

function drawsByProcessor() {
  const gl = document.createElement('canvas').getContext('webgl2');
  const names = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = String(gl && names ? gl.getParameter(names.UNMASKED_RENDERER_WEBGL) : '');
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software/i.test(name);
}

/** @param {WebGL2RenderingContext} gl @param {number} size */
function shadowMap(gl, size) {
  const texture = gl.createTexture(), frame = gl.createFramebuffer();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, size, size);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, texture, 0);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return { texture, frame };
}

/** A picture of one pixel that holds numbers. @param {WebGL2RenderingContext} gl */
function pixel(gl) {
  const frame = gl.createFramebuffer(), texture = gl.createTexture(), depth = gl.createRenderbuffer();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32UI, 1, 1);
  gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
  gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, 1, 1);
  gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.bindTexture(gl.TEXTURE_2D, null);
  return frame;
}

/** @param {WebGL2RenderingContext} gl @param {WebGLBuffer | null} buffer */
function lineVertices(gl, buffer) {
  const vertices = gl.createVertexArray();
  gl.bindVertexArray(vertices);
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  for (const place of [0, 1, 2]) {
    gl.enableVertexAttribArray(place);
    if (place < 2) gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 28, 12 * place);
    else gl.vertexAttribPointer(place, 4, gl.UNSIGNED_BYTE, true, 28, 24);
    gl.vertexAttribDivisor(place, 1);
  }
  gl.bindVertexArray(null);
  return vertices;
}
