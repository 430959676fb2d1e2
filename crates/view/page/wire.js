// What goes over the WebSocket; `wire.rs` describes it. This file reads messages and keeps the connection.

/**
 * @typedef {{kind: number, positions: Float32Array, normals: Float32Array | null, triangles: Uint32Array, radius: number}} Mesh
 * @typedef {{meshes: Mesh[], mesh: Uint32Array, scale: Float32Array, bits: Uint32Array, count: number}} Table
 * @typedef {{frame: number, time: number, step: number, anew: boolean}} Head
 */

/** How a mesh is drawn. */
export const FLAT = 0, BALL = 1, PLANE = 2, SMOOTH = 3;

/** Bits 0 to 19 of a record's first word where the body is not there. */
export const ABSENT = 0xfffff;

/** Calls `each` with the first row and the number of rows of each run. @param {Uint8Array} bytes @param {(row: number, count: number) => void} each */
function runs(bytes, each) {
  let at = 0;
  const number = () => {
    for (let value = 0, shift = 0; ; shift += 7) {
      const byte = bytes[at++];
      value |= (byte & 0x7f) << shift;
      if (byte < 0x80) return value;
    }
  };
  for (let row = 0; at < bytes.length; ) {
    row += number();
    const count = number();
    each(row, count);
    row += count;
  }
}

/**
 * A moment: calls `each` with the first row of a run, the number of rows, the words of all records, and the place in them of the run's first.
 * @param {DataView} data
 * @param {(head: Head) => void} begin
 * @param {(row: number, count: number, words: Uint32Array, at: number) => void} each
 */
export function moment(data, begin, each) {
  const bytes = data.getUint32(28, true);
  begin({ anew: data.getUint8(1) === 1, frame: data.getUint32(8, true), step: data.getFloat32(12, true), time: data.getFloat64(16, true) });
  const first = 32 + 4 * Math.ceil(bytes / 4);
  const words = new Uint32Array(data.buffer, first, 3 * data.getUint32(24, true));
  let at = 0;
  runs(new Uint8Array(data.buffer, 32, bytes), (row, count) => {
    each(row, count, words, at);
    at += 3 * count;
  });
}

/** Colours: calls `each` with rows, as above; three bytes for each. @param {DataView} data @param {(row: number, count: number, colors: Uint8Array, at: number) => void} each */
export function colors(data, each) {
  const bytes = data.getUint32(8, true);
  const values = new Uint8Array(data.buffer, 12 + 4 * Math.ceil(bytes / 4));
  let at = 0;
  runs(new Uint8Array(data.buffer, 12, bytes), (row, count) => {
    each(row, count, values, at);
    at += 3 * count;
  });
}

/** Meshes, put behind those that are known. @param {DataView} data @param {Mesh[]} known */
export function meshes(data, known) {
  known.length = data.getUint32(4, true);
  let at = 12;
  for (let left = data.getUint32(8, true); left > 0; left--) {
    const [kind, corners, count] = [0, 4, 8].map((k) => data.getUint32(at + k, true));
    const radius = data.getFloat32(at + 12, true);
    at += 16;
    /** @param {number} n */
    const floats = (n) => new Float32Array(data.buffer, (at += 4 * n) - 4 * n, n);
    const positions = floats(3 * corners);
    const normals = kind === SMOOTH ? floats(3 * corners) : null;
    const triangles = new Uint32Array(data.buffer, at, 3 * count);
    at += 12 * count;
    known.push({ kind, positions, normals, triangles, radius });
  }
}

/** Rows, put behind those that are known; whether those are to be forgotten. @param {DataView} data @param {Table} table */
export function bodies(data, table) {
  const first = data.getUint32(4, true), count = data.getUint32(8, true);
  const anew = data.getUint32(12, true) === 1;
  if (anew) table.meshes.length = 0;
  const all = first + count;
  const mesh = new Uint32Array(all), scale = new Float32Array(3 * all), bits = new Uint32Array(all);
  mesh.set(table.mesh.subarray(0, first));
  scale.set(table.scale.subarray(0, 3 * first));
  bits.set(table.bits.subarray(0, first));
  for (let k = 0; k < count; k++) {
    const at = 16 + 20 * k;
    mesh[first + k] = data.getUint32(at, true);
    for (let axis = 0; axis < 3; axis++) scale[3 * (first + k) + axis] = data.getFloat32(at + 4 + 4 * axis, true);
    bits[first + k] = data.getUint32(at + 16, true);
  }
  Object.assign(table, { mesh, scale, bits, count: all });
  return anew;
}

/** Milliseconds after which a connection over which nothing comes is taken for dead. */
const SILENCE = 6000;

/** Keeps a connection: what comes goes to `hear` and `read`, and when it breaks, another one is made. */
export class Wire {
  /**
   * @param {(message: any) => void} hear words
   * @param {(data: DataView) => void} read numbers
   * @param {(there: boolean) => void} change whether the connection is there
   */
  constructor(hear, read, change) {
    Object.assign(this, { hear, read, change });
    /** @type {WebSocket | null} */
    this.socket = null;
    this.heard = 0;
    this.wait = 250;
    this.bytes = 0;
    this.hear = hear;
    this.read = read;
    this.change = change;
    setInterval(() => {
      if (this.socket && performance.now() - this.heard > SILENCE) this.lose(this.socket);
    }, 1000);
    this.connect();
  }

  connect() {
    const token = new URLSearchParams(location.search).get('token');
    const url = new URL('live', location.href);
    url.protocol = url.protocol.replace('http', 'ws');
    url.hash = '';
    url.search = token === null ? '' : `?token=${encodeURIComponent(token)}`;
    const socket = new WebSocket(url);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    this.heard = performance.now();
    socket.onopen = () => {
      this.wait = 250;
      this.change(true);
    };
    socket.onmessage = (event) => {
      if (this.socket !== socket) return;
      this.heard = performance.now();
      if (typeof event.data === 'string') {
        this.hear(JSON.parse(event.data));
        return;
      }
      this.bytes += event.data.byteLength;
      const data = new DataView(event.data);
      this.read(data);
      // Read, and so the next may come.
      if (data.getUint8(0) === 1) socket.send(event.data.slice(4, 8));
    };
    socket.onclose = () => this.lose(socket);
  }

  /** @param {WebSocket} socket */
  lose(socket) {
    if (this.socket !== socket) return;
    this.socket = null;
    socket.close();
    this.change(false);
    setTimeout(() => this.connect(), this.wait);
    this.wait = Math.min(2 * this.wait, 4000);
  }

  /** Sends a command, if anybody is there to hear it. @param {object} command */
  say(command) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(command));
  }
}
