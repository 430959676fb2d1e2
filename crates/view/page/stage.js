// The bodies as the graphics card has them: those that share a mesh stand side by side, so that one call draws all of them.

import * as wire from './wire.js';

/** A place of no body. */
const NOWHERE = 0xffffffff;

/** From so many balls on, coarser ones. */
const MANY_BALLS = 3000;

/** @typedef {{kind: number, closed: boolean, vertices: WebGLVertexArrayObject, count: number, first: number, bodies: number}} Group */

export class Stage {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    /** @type {wire.Table} */
    this.table = { meshes: [], mesh: new Uint32Array(), scale: new Float32Array(), bits: new Uint32Array(), count: 0 };
    /** @type {Group[]} */
    this.groups = [];
    /** Place of each row, and row of each place. */
    this.slots = new Uint32Array();
    this.rows = new Uint32Array();
    this.now = new Uint32Array();
    this.was = new Uint32Array();
    this.colors = new Uint8Array();
    this.step = 1;
    this.frame = 0;
    this.time = 0;
    this.buffers = { now: gl.createBuffer(), was: gl.createBuffer(), scale: gl.createBuffer(), color: gl.createBuffer() };
    /** @type {(WebGLBuffer | null)[]} */
    this.garbage = [];
    this.changed = { records: false, colors: false };
    /** Whether bodies glide from the moment before to the newest one. */
    this.glides = false;
    /** @type {Float32Array} */
    this.lines = new Float32Array();
    this.lineCount = 0;
    this.linesChanged = false;
  }

  /** Takes in a binary message. @param {DataView} data */
  read(data) {
    const kind = data.getUint8(0);
    if (kind === 1) this.moment(data);
    else if (kind === 2) {
      wire.colors(data, (row, count, values, at) => {
        for (let k = 0; k < count; k++, at += 3) {
          const slot = this.slots[row + k];
          if (slot !== NOWHERE) this.colors.set(values.subarray(at, at + 3), 4 * slot);
        }
      });
      this.changed.colors = true;
    } else if (kind === 3) {
      wire.meshes(data, this.table.meshes);
    } else if (kind === 4) {
      // Rows mean other bodies now: what is known of the old ones is nothing to them.
      if (wire.bodies(data, this.table)) this.slots = new Uint32Array();
      this.arrange();
    } else if (kind === 5) {
      this.lineCount = data.getUint32(4, true);
      this.lines = new Float32Array(data.buffer, 8, 7 * this.lineCount);
      this.linesChanged = true;
    }
  }

  /** @param {DataView} data */
  moment(data) {
    if (this.glides) this.was.set(this.now);
    wire.moment(
      data,
      (head) => {
        if (head.anew || head.step !== this.step) {
          for (let k = 0; k < this.now.length; k += 3) this.now[k] = wire.ABSENT;
          this.was.set(this.now);
        }
        [this.step, this.frame, this.time] = [head.step, head.frame, head.time];
      },
      (row, count, words, at) => {
        const { slots, now } = this;
        for (let k = row; k < row + count; k++, at += 3) {
          const slot = slots[k];
          if (slot === NOWHERE) continue;
          now[3 * slot] = words[at];
          now[3 * slot + 1] = words[at + 1];
          now[3 * slot + 2] = words[at + 2];
        }
      },
    );
    if (!this.glides) this.was.set(this.now);
    this.changed.records = true;
  }

  /** Puts bodies of one mesh side by side. */
  arrange() {
    const { gl, table } = this;
    const { meshes, mesh, bits, count } = table;
    const sizes = new Uint32Array(meshes.length + 1);
    for (let row = 0; row < count; row++) if (!(bits[row] & 2)) sizes[mesh[row] + 1]++;
    for (let k = 1; k < sizes.length; k++) sizes[k] += sizes[k - 1];
    const firsts = sizes.slice(), shown = sizes[meshes.length];
    // In no order: what is behind is drawn as often before what is in front as after it, and most of what will be hidden is not painted at all. In the order of rows the lowest layer would come first.
    const order = shuffled(count);
    const slots = new Uint32Array(count).fill(NOWHERE), rows = new Uint32Array(shown);
    const now = new Uint32Array(3 * shown), colors = new Uint8Array(4 * shown).fill(150), scale = new Float32Array(3 * shown);
    for (const row of order) {
      if (bits[row] & 2) continue;
      const slot = firsts[mesh[row]]++, old = row < this.slots.length ? this.slots[row] : NOWHERE;
      slots[row] = slot;
      rows[slot] = row;
      now[3 * slot] = wire.ABSENT;
      if (old !== NOWHERE) {
        now.set(this.now.subarray(3 * old, 3 * old + 3), 3 * slot);
        colors.set(this.colors.subarray(4 * old, 4 * old + 4), 4 * slot);
      }
      scale.set(table.scale.subarray(3 * row, 3 * row + 3), 3 * slot);
    }
    Object.assign(this, { slots, rows, now, was: now.slice(), colors });
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.scale);
    gl.bufferData(gl.ARRAY_BUFFER, scale, gl.STATIC_DRAW);
    for (const group of this.groups) gl.deleteVertexArray(group.vertices);
    this.garbage.forEach((buffer) => gl.deleteBuffer(buffer));
    this.garbage = [];
    this.groups = [];
    for (let k = 0; k < meshes.length; k++) {
      const bodies = sizes[k + 1] - sizes[k];
      if (bodies > 0) this.groups.push(this.group(meshes[k], sizes[k], bodies));
    }
    gl.bindVertexArray(null);
    this.changed = { records: true, colors: true };
  }

  /** @param {wire.Mesh} mesh @param {number} first @param {number} bodies @returns {Group} */
  group(mesh, first, bodies) {
    const { gl } = this;
    const shape = mesh.kind === wire.BALL ? ball(bodies > MANY_BALLS ? 2 : 3) : mesh;
    const vertices = gl.createVertexArray();
    gl.bindVertexArray(vertices);
    /** @param {number} place @param {WebGLBuffer | null} buffer @param {number} width @param {number} divisor @param {number} kind @param {number} offset @param {boolean} [share] */
    const attribute = (place, buffer, width, divisor, kind, offset, share = false) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(place);
      if (kind === gl.UNSIGNED_INT) gl.vertexAttribIPointer(place, width, kind, 0, offset);
      else gl.vertexAttribPointer(place, width, kind, share, 0, offset);
      gl.vertexAttribDivisor(place, divisor);
    };
    /** @param {number} target @param {AllowSharedBufferSource} content */
    const store = (target, content) => {
      const buffer = gl.createBuffer();
      this.garbage.push(buffer);
      gl.bindBuffer(target, buffer);
      gl.bufferData(target, content, gl.STATIC_DRAW);
      return buffer;
    };
    attribute(0, store(gl.ARRAY_BUFFER, shape.positions), 3, 0, gl.FLOAT, 0);
    if (shape.normals) attribute(1, store(gl.ARRAY_BUFFER, shape.normals), 3, 0, gl.FLOAT, 0);
    store(gl.ELEMENT_ARRAY_BUFFER, shape.triangles);
    attribute(2, this.buffers.now, 3, 1, gl.UNSIGNED_INT, 12 * first);
    attribute(3, this.buffers.was, 3, 1, gl.UNSIGNED_INT, 12 * first);
    attribute(4, this.buffers.scale, 3, 1, gl.FLOAT, 12 * first);
    attribute(5, this.buffers.color, 4, 1, gl.UNSIGNED_BYTE, 4 * first, true);
    // What can move has an inside, which nobody sees unless the mesh that is shown has holes.
    const closed = this.rows.subarray(first, first + bodies).every((row) => (this.table.bits[row] & 5) === 1);
    return { kind: mesh.kind, closed, vertices, count: shape.triangles.length, first, bodies };
  }

  /** Brings what has changed to the graphics card. */
  upload() {
    const { gl, buffers } = this;
    /** @param {WebGLBuffer | null} buffer @param {AllowSharedBufferSource} content */
    const store = (buffer, content) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, content, gl.DYNAMIC_DRAW);
    };
    if (this.changed.records) {
      store(buffers.now, this.now);
      store(buffers.was, this.was);
    }
    if (this.changed.colors) store(buffers.color, this.colors);
    this.changed = { records: false, colors: false };
  }

  /** Where the body in a row is, metres from the origin; none where it is not there. @param {number} row @returns {[number, number, number] | null} */
  place(row) {
    const slot = row < this.slots.length ? this.slots[row] : NOWHERE;
    if (slot === NOWHERE || (this.now[3 * slot] & wire.ABSENT) === wire.ABSENT) return null;
    /** @param {number} axis */
    const at = (axis) => ((this.now[3 * slot + axis] & 0xfffff) - 0x80000) * this.step;
    return [at(0), at(1), at(2)];
  }

  /** A box around the bodies that move and are there: its middle and half its diagonal, metres. Without the few that have gone farthest. */
  extent() {
    const { table } = this;
    /** @type {number[][]} */
    const axes = [[], [], []];
    let size = 0;
    const every = Math.max(1, Math.floor(table.count / 4000));
    for (const moving of [true, false]) {
      for (let row = 0; row < table.count; row += moving ? every : 1) {
        const kind = table.meshes[table.mesh[row]]?.kind;
        if (((table.bits[row] & 1) === 1) !== moving || kind === wire.PLANE) continue;
        const at = this.place(row);
        if (!at) continue;
        at.forEach((x, axis) => axes[axis].push(x));
        const [x, y, z] = table.scale.subarray(3 * row, 3 * row + 3);
        size = Math.max(size, table.meshes[table.mesh[row]].radius * Math.max(x, y, z));
      }
      if (axes[0].length > 0) break;
    }
    if (axes[0].length === 0) return { middle: /** @type {[number, number, number]} */ ([0, 0, 0]), radius: 5 };
    const out = Math.floor(axes[0].length / 200);
    const [low, high] = [0, 1].map((end) =>
      axes.map((all) => all.sort((a, b) => a - b)[end === 0 ? out : all.length - 1 - out]),
    );
    const middle = /** @type {[number, number, number]} */ (low.map((x, k) => (x + high[k]) / 2));
    return { middle, radius: 0.5 * Math.hypot(...low.map((x, k) => high[k] - x)) + size };
  }
}

/** The numbers below `count` in an order that looks like none, the same each time. @param {number} count */
function shuffled(count) {
  const order = Uint32Array.from({ length: count }, (_, k) => k);
  for (let k = count - 1, seed = 1; k > 0; k--) {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    const other = Math.floor((seed / 2 ** 32) * (k + 1));
    [order[k], order[other]] = [order[other], order[k]];
  }
  return order;
}

/** A ball of triangles: an icosahedron whose faces are cut in so many parts each way. @param {number} parts */
function ball(parts) {
  const g = (1 + Math.sqrt(5)) / 2;
  const corners = [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g], [0, -1, -g], [0, 1, -g], [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]];
  const faces = '0 11 5 0 5 1 0 1 7 0 7 10 0 10 11 1 5 9 5 11 4 11 10 2 10 7 6 7 1 8 3 9 4 3 4 2 3 2 6 3 6 8 3 8 9 4 9 5 2 4 11 6 2 10 8 6 7 9 8 1'.split(' ').map(Number);
  /** @type {number[]} */
  const positions = [], triangles = [];
  for (let f = 0; f < 60; f += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => corners[faces[f + k]]);
    const first = positions.length / 3;
    /** @param {number} i @param {number} j */
    const index = (i, j) => first + (j * (2 * parts + 3 - j)) / 2 + i;
    for (let j = 0; j <= parts; j++) {
      for (let i = 0; i <= parts - j; i++) {
        const at = [0, 1, 2].map((k) => a[k] + ((b[k] - a[k]) * i + (c[k] - a[k]) * j) / parts);
        positions.push(...at.map((x) => x / Math.hypot(...at)));
        if (i + j < parts) triangles.push(index(i, j), index(i + 1, j), index(i, j + 1));
        if (i + j < parts - 1) triangles.push(index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
      }
    }
  }
  const corner = new Float32Array(positions);
  return { positions: corner, normals: corner, triangles: new Uint32Array(triangles) };
}
