// Matrices of four columns, as WebGL has them: element (row, column) is m[4 column + row]. Vectors are arrays of three numbers.

/** @typedef {[number, number, number]} Vec3 */
/** @typedef {Float32Array} Mat4 */

/** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
/** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
/** @param {Vec3} a @param {number} s @returns {Vec3} */
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
/** @param {Vec3} a @param {Vec3} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @param {Vec3} a */
export const length = (a) => Math.hypot(a[0], a[1], a[2]);
/** @param {Vec3} a @returns {Vec3} */
export const unit = (a) => scale(a, 1 / (length(a) || 1));

/** a b @param {Mat4} a @param {Mat4} b @returns {Mat4} */
export function multiply(a, b) {
  const out = new Float32Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * k + row] * b[4 * column + k];
      out[4 * column + row] = sum;
    }
  }
  return out;
}

/** From the world, seen from the eye at its origin, to right, up and backwards. @param {Vec3} forward @param {Vec3} up @returns {Mat4} */
export function turning(forward, up) {
  const f = unit(forward);
  const r = unit(cross(f, up));
  const u = cross(r, f);
  return new Float32Array([r[0], u[0], -f[0], 0, r[1], u[1], -f[1], 0, r[2], u[2], -f[2], 0, 0, 0, 0, 1]);
}

/** A lens: vertical field of view in radians, and how far it sees. @param {number} fov @param {number} aspect @param {number} near @param {number} far @returns {Mat4} */
export function perspective(fov, aspect, near, far) {
  const f = 1 / Math.tan(fov / 2);
  const m = new Float32Array(16);
  m[0] = f / aspect;
  m[5] = f;
  m[10] = (far + near) / (near - far);
  m[11] = -1;
  m[14] = (2 * far * near) / (near - far);
  return m;
}

/** A box around the origin: half its width and height, and depths. @param {number} half @param {number} near @param {number} far @returns {Mat4} */
export function orthographic(half, near, far) {
  const m = new Float32Array(16);
  m[0] = m[5] = 1 / half;
  m[10] = 2 / (near - far);
  m[14] = (far + near) / (near - far);
  m[15] = 1;
  return m;
}

/** The part of a picture around the point (x, y), from -1 to 1, that is a pixel of one so wide and high. @param {Mat4} lens @param {number} x @param {number} y @param {number} width @param {number} height @returns {Mat4} */
export function around(lens, x, y, width, height) {
  const zoom = new Float32Array(16);
  zoom[0] = width;
  zoom[5] = height;
  zoom[10] = zoom[15] = 1;
  zoom[12] = -x * width;
  zoom[13] = -y * height;
  return multiply(zoom, lens);
}
