// Mouse, fingers and keys.

import { add, dot, scale, sub } from './matrix.js';
/** @typedef {import('./matrix.js').Vec3} Vec3 */
/** @typedef {import('./draw.js').Draw} Draw */
/** @typedef {import('./camera.js').Camera} Camera */
/** @typedef {'look' | 'grab' | 'throw' | 'pile'} Tool */

/** Pixels that a click may slip. */
const SLIP = 5;

/** What keys do, for people. */
export const KEYS = [
  ['space', 'play or pause'], [', .', 'one frame back, further'], ['Home End', 'to the first, the newest frame'], ['- +', 'slower, faster'], ['L', 'loop'],
  ['W A S D Q E', 'fly; with Shift faster'], ['arrows', 'look around'], ['F', 'all in the picture'], ['1 2 3 4', 'look, drag, throw, drop'],
  ['C', 'other colours'], ['O', 'contacts over the picture'], ['T', 'light or dark'], ['P', 'panel'], ['V', 'copy a link to this view and time'],
  ['K', 'save as a scene'], ['Shift R', 'reset'], ['Esc', 'let go'], ['mouse', 'left: the tool; right: move; wheel: nearer, farther; click: what is this?; Shift and left: drag a body'],
  ['fingers', 'one: the tool; two: move, nearer, farther'],
];

export class Hands {
  /**
   * @param {HTMLCanvasElement} canvas @param {Draw} draw @param {Camera} camera @param {import('./stage.js').Stage} stage
   * @param {{say: (command: object) => void, pick: (row: number | null) => void, moved: () => void, key: (key: string, shift: boolean) => boolean, live: () => boolean, origin: () => Vec3, toy: (kind: 'throw' | 'pile', point: Vec3, way: Vec3) => void}} act
   */
  constructor(canvas, draw, camera, stage, act) {
    Object.assign(this, { canvas, draw, camera, stage, act });
    this.canvas = canvas;
    this.draw = draw;
    this.camera = camera;
    this.stage = stage;
    this.act = act;
    /** @type {Tool} */
    this.tool = 'look';
    /** @type {Map<number, {x: number, y: number}>} */
    this.fingers = new Map();
    /** What is being done with the pointer that came first. @type {null | {button: number, way: number, x: number, y: number}} */
    this.stroke = null;
    /** What is held: a point of it when it was taken, from the eye in depth; and where it is pulled to. @type {null | {row: number, depth: number, to: Vec3, sent: Vec3 | null, local: Vec3}} */
    this.held = null;
    /** @type {Set<string>} */
    this.keys = new Set();
    canvas.addEventListener('pointerdown', (event) => this.down(event));
    canvas.addEventListener('pointermove', (event) => this.move(event));
    for (const end of /** @type {const} */ (['pointerup', 'pointercancel'])) canvas.addEventListener(end, (event) => this.up(event));
    canvas.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    addEventListener('keydown', (event) => this.press(event));
    addEventListener('keyup', (event) => this.keys.delete(event.code));
    addEventListener('blur', () => {
      this.keys.clear();
      this.release();
    });
  }

  /** A point of the picture, from -1 to 1 each. @param {{clientX: number, clientY: number}} event @returns {[number, number]} */
  point(event) {
    const box = this.canvas.getBoundingClientRect();
    return [(2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height];
  }

  /** @param {PointerEvent} event */
  down(event) {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (this.fingers.size > 1) {
      this.release();
      if (this.stroke) this.stroke.way = Infinity;
      return;
    }
    this.stroke = { button: event.button, way: 0, x: event.clientX, y: event.clientY };
    if (event.button === 0 && (this.tool === 'grab' || event.shiftKey) && this.act.live()) this.grab(event);
  }

  /** @param {PointerEvent} event */
  grab(event) {
    const [x, y] = this.point(event);
    const found = this.draw.at(this.stage, this.camera, x, y);
    if (!found || !(this.stage.table.bits[found.row] & 1)) return;
    const place = this.stage.place(found.row);
    this.held = { row: found.row, depth: found.depth, to: found.point, sent: found.point, local: place ? sub(found.point, place) : [0, 0, 0] };
    this.act.say({ do: 'grab', row: found.row, at: add(found.point, this.act.origin()) });
  }

  release() {
    if (this.held) this.act.say({ do: 'release' });
    this.held = null;
    this.act.moved();
  }

  /** @param {PointerEvent} event */
  move(event) {
    const finger = this.fingers.get(event.pointerId);
    if (!finger || !this.stroke) return;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const [dx, dy] = [event.clientX - finger.x, event.clientY - finger.y];
    if (this.fingers.size === 2) {
      const other = [...this.fingers].find(([id]) => id !== event.pointerId)?.[1] ?? finger;
      const before = Math.hypot(finger.x - other.x, finger.y - other.y), after = Math.hypot(event.clientX - other.x, event.clientY - other.y);
      const [x, y] = this.point({ clientX: (event.clientX + other.x) / 2, clientY: (event.clientY + other.y) / 2 });
      this.camera.zoom(before / Math.max(after, 1), (x + this.camera.shift) * (width / height), y);
      this.camera.move(-dx / 2 / height, dy / 2 / height);
    } else {
      this.stroke.way = Math.max(this.stroke.way, Math.hypot(event.clientX - this.stroke.x, event.clientY - this.stroke.y));
      if (this.held) this.pull(event);
      else if (this.stroke.way > SLIP) {
        if (this.stroke.button === 0 && !event.ctrlKey) this.camera.orbit((dx / height) * 3.5, (dy / height) * 3.5);
        else this.camera.move(-dx / height, dy / height);
      } else return;
    }
    Object.assign(finger, { x: event.clientX, y: event.clientY });
    this.act.moved();
  }

  /** What is held follows the pointer at the depth that it has. @param {{clientX: number, clientY: number}} event */
  pull(event) {
    if (!this.held) return;
    const [x, y] = this.point(event);
    const way = this.camera.way(x, y, this.draw.aspect);
    this.held.to = add(this.camera.eye, scale(way, this.held.depth / dot(way, this.camera.axes[2])));
  }

  /** @param {PointerEvent} event */
  up(event) {
    const was = this.fingers.size;
    this.fingers.delete(event.pointerId);
    const { stroke } = this;
    if (was > 1 || !stroke) return;
    this.stroke = null;
    const held = this.held;
    this.release();
    if (event.type === 'pointerup' && stroke.button === 0 && stroke.way <= SLIP) this.click(event, held?.row ?? null);
  }

  /** @param {PointerEvent} event @param {number | null} held */
  click(event, held) {
    const [x, y] = this.point(event);
    const found = this.draw.at(this.stage, this.camera, x, y);
    const way = this.camera.way(x, y, this.draw.aspect);
    if (this.tool === 'throw' && this.act.live()) this.act.toy('throw', this.camera.eye, way);
    else if (this.tool === 'pile' && this.act.live()) {
      if (found) this.act.toy('pile', found.point, way);
    } else this.act.pick(held ?? found?.row ?? null);
  }

  /** @param {WheelEvent} event */
  wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 30 : 1;
    const factor = Math.exp(Math.max(-60, Math.min(60, event.deltaY * lines)) * 0.004);
    const [x, y] = this.point(event);
    if (this.held) {
      this.held.depth /= factor;
      this.pull(event);
    } else this.camera.zoom(factor, (x + this.camera.shift) * this.draw.aspect, y);
    this.act.moved();
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    const target = event.target instanceof Element ? event.target : null;
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector('dialog[open]')) return;
    const typing = target?.matches('input, select, textarea, summary') ?? false;
    if (typing && event.key !== 'Escape') return;
    // A button that has the focus is pressed by these two.
    if (target?.matches('button') && (event.key === ' ' || event.key === 'Enter')) return;
    if (FLY.has(event.code) && !(event.shiftKey && event.code === 'KeyR')) {
      this.keys.add(event.code);
      if (event.shiftKey) this.keys.add('ShiftLeft');
      event.preventDefault();
      this.act.moved();
    } else if (event.code.startsWith('Shift')) this.keys.add('ShiftLeft');
    else if (this.act.key(event.key, event.shiftKey)) event.preventDefault();
  }

  /** Whether a key or a hand keeps things in motion. */
  get busy() {
    return this.held !== null || [...this.keys].some((code) => FLY.has(code));
  }

  /** Moves on for so many seconds. @param {number} seconds */
  go(seconds) {
    const fast = this.keys.has('ShiftLeft') ? 4 : 1;
    /** @param {string} plus @param {string} minus */
    const axis = (plus, minus) => (this.keys.has(plus) ? 1 : 0) - (this.keys.has(minus) ? 1 : 0);
    const [right, up, forward] = [axis('KeyD', 'KeyA'), axis('KeyE', 'KeyQ'), axis('KeyW', 'KeyS')];
    const by = 0.8 * seconds * fast;
    if (right || up || forward) this.camera.move(right * by, up * by, forward * by);
    const [turn, tilt] = [axis('ArrowRight', 'ArrowLeft'), axis('ArrowUp', 'ArrowDown')];
    if (turn || tilt) this.camera.orbit(-turn * 1.5 * seconds, tilt * 1.5 * seconds);
    const { held } = this;
    if (held && held.to !== held.sent) {
      held.sent = held.to;
      this.act.say({ do: 'pull', to: add(held.to, this.act.origin()) });
    }
  }

  /** Ends of the line from what is held to where it is pulled to. @returns {number[]} */
  get string() {
    if (!this.held) return [];
    const place = this.stage.place(this.held.row);
    return place ? [...add(place, this.held.local), ...this.held.to] : [];
  }
}

const FLY = new Set(['KeyW', 'KeyA', 'KeyS', 'KeyD', 'KeyQ', 'KeyE', 'ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown']);
