// Where one looks from: an eye that goes around a point, moves with it, and can be carried away.

import { add, cross, length, scale, sub, turning, perspective, multiply, unit } from './matrix.js';
/** @typedef {import('./matrix.js').Vec3} Vec3 */

const STEEPEST = 0.495 * Math.PI;

export class Camera {
  constructor() {
    /** Metres from the origin of the scene. @type {Vec3} */
    this.target = [0, 0, 0];
    this.distance = 10;
    /** Of the way from the target to the eye: about z from x, and above the ground; radians. */
    this.azimuth = -1;
    this.elevation = 0.37;
    /** Vertical, degrees. */
    this.fov = 35;
    /** How far left of the middle the target is, in halves of the picture's width: the panel covers the right. */
    this.shift = 0;
  }

  /** From the target to the eye, unit. @returns {Vec3} */
  get back() {
    const level = Math.cos(this.elevation);
    return [level * Math.cos(this.azimuth), level * Math.sin(this.azimuth), Math.sin(this.elevation)];
  }

  /** @returns {Vec3} */
  get eye() {
    return add(this.target, scale(this.back, this.distance));
  }

  /** Right, up and forward, unit. @returns {[Vec3, Vec3, Vec3]} */
  get axes() {
    const forward = scale(this.back, -1);
    const right = unit(cross(forward, [0, 0, 1]));
    return [right, cross(right, forward), forward];
  }

  /** Half of the picture's height at unit distance. */
  get half() {
    return Math.tan((this.fov * Math.PI) / 360);
  }

  /** @param {Vec3} eye @param {Vec3} target @param {number} [fov] */
  look(eye, target, fov = this.fov) {
    const way = sub(eye, target);
    const distance = length(way);
    if (!(distance > 0) || ![...eye, ...target, fov].every(Number.isFinite)) return;
    this.target = target;
    this.distance = distance;
    this.azimuth = Math.atan2(way[1], way[0]);
    this.elevation = Math.max(-STEEPEST, Math.min(STEEPEST, Math.asin(way[2] / distance)));
    this.fov = Math.max(1, Math.min(150, fov));
  }

  /** Around the target, radians. @param {number} right @param {number} up */
  orbit(right, up) {
    this.azimuth -= right;
    this.elevation = Math.max(-STEEPEST, Math.min(STEEPEST, this.elevation + up));
  }

  /** With the target, in shares of the picture's height at it. @param {number} right @param {number} up @param {number} forward */
  move(right, up, forward = 0) {
    const size = 2 * this.half * this.distance;
    const [r, u, f] = this.axes;
    this.target = add(this.target, add(add(scale(r, right * size), scale(u, up * size)), scale(f, forward * size)));
  }

  /** Nearer (below 1) or farther, so that what is at a point of the picture stays there. @param {number} factor @param {number} x @param {number} y in shares of half its height from the middle */
  zoom(factor, x = 0, y = 0) {
    const far = Math.max(1e-3, Math.min(1e6, this.distance * factor));
    this.move(((1 - far / this.distance) * x) / 2, ((1 - far / this.distance) * y) / 2);
    this.distance = far;
  }

  /** So that a ball is in the picture. @param {Vec3} middle @param {number} radius @param {number} aspect */
  fit(middle, radius, aspect) {
    this.target = middle;
    const half = Math.atan(this.half * Math.min(1, aspect));
    this.distance = (0.92 * radius) / Math.sin(half);
  }

  /** From the eye to the picture. @param {number} aspect */
  lens(aspect) {
    const near = Math.max(0.004 * this.distance, 1e-3);
    const pinhole = perspective((this.fov * Math.PI) / 180, aspect, near, 8000 * near + 50 * this.distance);
    pinhole[8] = this.shift;
    return multiply(pinhole, turning(scale(this.back, -1), [0, 0, 1]));
  }

  /** Unit way from the eye through a point of the picture, from -1 to 1 each. @param {number} x @param {number} y @param {number} aspect @returns {Vec3} */
  way(x, y, aspect) {
    const [r, u, f] = this.axes;
    return unit(add(f, add(scale(r, (x + this.shift) * this.half * aspect), scale(u, y * this.half))));
  }
}
