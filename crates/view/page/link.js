// The address of what one sees: eye, target, lens and frame behind the `#`.

/** @typedef {import('./matrix.js').Vec3} Vec3 */
/** @typedef {{eye: Vec3, target: Vec3, fov: number, frame: number | null}} View */

/** @param {View} view */
export function write({ eye, target, fov, frame }) {
  /** @param {number[]} numbers */
  const list = (numbers) => numbers.map((x) => Number(x.toPrecision(7))).join(',');
  const at = frame === null ? '' : `&frame=${frame}`;
  return `#eye=${list(eye)}&target=${list(target)}&fov=${list([fov])}${at}`;
}

/** What an address says; none where it says nothing that makes sense. @param {string} hash @returns {View | null} */
export function read(hash) {
  const values = new URLSearchParams(hash.slice(1));
  /** @param {string} name @param {number} count */
  const numbers = (name, count) => {
    const list = (values.get(name) ?? '').split(',').map((text) => (text.trim() === '' ? NaN : Number(text)));
    return list.length === count && list.every(Number.isFinite) ? list : null;
  };
  const eye = numbers('eye', 3), target = numbers('target', 3);
  if (!eye || !target) return null;
  const frame = numbers('frame', 1)?.[0] ?? null;
  return {
    eye: /** @type {Vec3} */ (eye),
    target: /** @type {Vec3} */ (target),
    fov: numbers('fov', 1)?.[0] ?? 35,
    frame: frame === null ? null : Math.max(0, Math.round(frame)),
  };
}
