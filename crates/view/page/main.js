// The page: puts its parts together.

import { Camera } from './camera.js';
import { Draw } from './draw.js';
import { Hands, KEYS } from './hands.js';
import * as link from './link.js';
import { add, scale, sub } from './matrix.js';
import { Panel, element, message } from './panel.js';
import { Stage } from './stage.js';
import { Timeline } from './timeline.js';
import { Wire } from './wire.js';
/** @typedef {import('./matrix.js').Vec3} Vec3 */

/** Milliseconds of a picture from which on fewer pixels are drawn, and up to which more are: it was done when the screen, 60 times a second, came for the next. */
const SLOW = 45, QUICK = 20;

const canvas = element('view', HTMLCanvasElement);
const draw = start();
const camera = new Camera();
const stage = new Stage(draw.gl);
/** @type {any} */
let hello = null;
/** @type {any} */
let status = null;
/** Where positions start from, in the world. @type {Vec3} */
let origin = [0, 0, 0];
let dirty = true, placed = false, fresh = true;
/** When the newest moment came, and how long after the one before it. */
let came = 0, pause = 16;
let pictures = 0, fps = 0, counted = performance.now(), last = counted;
/** When there was a picture last. */
let drawn = 0;
/** When the picture was begun that is measured, and what tells that the card is done with it. */
let began = 0;
/** @type {WebGLSync | null} */
let fence = null;

function start() {
  try {
    return new Draw(canvas);
  } catch (error) {
    message(String(error instanceof Error ? error.message : error), true);
    throw error;
  }
}

const wire = new Wire(hear, read, (there) => {
  element('lost', HTMLElement).hidden = there;
  if (!there) fresh = true;
});
/** @param {object} command */
const say = (command) => wire.say(command);
const moved = () => (dirty = true);
const see = () => {
  say(panel.wish);
  draw.shadows = panel.shadows.checked;
  draw.pick = panel.picked === null ? -1 : (stage.slots[panel.picked] ?? -1);
  dirty = true;
};
const panel = new Panel(say, { see, camera: place, theme, share, fit });
const timeline = new Timeline(say);
const hands = new Hands(canvas, draw, camera, stage, {
  say, moved, key, toy,
  pick: (row) => panel.pick(row),
  live: () => panel.live,
  origin: () => origin,
});

/** Words of the server. @param {any} said */
function hear(said) {
  if (said.is === 'hello') greet(said);
  else if (said.is === 'status') {
    status = said;
    timeline.show(said);
    panel.show(said, fps);
    // What is slower than the eye glides from frame to frame.
    stage.glides = said.playing && said.speed * said.rate < 45;
  } else if (said.is === 'legend') panel.explain(said);
  else if (said.is === 'picked') panel.tell(said);
  else if (said.is === 'unknown') message(`${said.what}: ${said.why}`, true);
  else if (said.is === 'error') message(said.text, true);
  else if (said.is === 'note') message(said.text);
}

/** @param {any} said */
function greet(said) {
  const again = hello !== null;
  hello = said;
  origin = said.origin;
  panel.greet(said);
  // Whoever comes by a link sees what it shows; who comes back stays where he was.
  if (!again) {
    const view = link.read(location.hash);
    const first = said.cameras[0];
    if (view) go(view);
    else if (first) place(first.name);
    panel.camera.value = view ? '' : (first?.name ?? '');
    placed = Boolean(view ?? first);
  }
  say(panel.wish);
}

/** @param {DataView} data */
function read(data) {
  stage.read(data);
  if (data.getUint8(0) === 1) {
    const now = performance.now();
    pause = Math.min(400, Math.max(4, now - came));
    came = now;
    if (panel.follows && panel.picked !== null) {
      const at = stage.place(panel.picked);
      if (at) camera.target = at;
    }
    if (fresh) {
      fresh = false;
      draw.extent = stage.extent();
      const usual = Number((0.06 * draw.extent.radius).toPrecision(1));
      for (const id of ['ball', 'box']) {
        const input = element(id, HTMLInputElement);
        if (!input.value) input.value = String(usual);
      }
      if (!placed) fit();
      placed = true;
    }
  }
  draw.pick = panel.picked === null ? -1 : (stage.slots[panel.picked] ?? -1);
  dirty = true;
}

/** @param {link.View} view */
function go(view) {
  camera.look(sub(view.eye, origin), sub(view.target, origin), view.fov);
  if (view.frame !== null) say({ do: 'seek', frame: view.frame });
  dirty = true;
}

/** To a camera of the scene. @param {string} name */
function place(name) {
  const found = hello?.cameras.find((/** @type {any} */ one) => one.name === name);
  if (!found) return;
  camera.look(sub(found.eye, origin), sub(found.target, origin), found.fov);
  // What is narrow sees less: as wide as in a picture of 16 to 9.
  if (free() < 16 / 9) camera.distance *= Math.min(2.2, 16 / 9 / free());
  dirty = true;
}

/** Width by height of the part of the picture that nothing covers. */
function free() {
  return draw.aspect * (1 - panel.covers);
}

function fit() {
  draw.extent = stage.extent();
  camera.fit(draw.extent.middle, draw.extent.radius, free());
  panel.camera.value = '';
  dirty = true;
}

async function share() {
  const { fov } = camera;
  const hash = link.write({ eye: add(camera.eye, origin), target: add(camera.target, origin), fov, frame: status?.frame ?? null });
  history.replaceState(null, '', hash);
  try {
    await navigator.clipboard.writeText(location.href);
    message('A link to this view and time is in the clipboard.');
  } catch {
    message('The address of the page is now a link to this view and time.');
  }
}

/** @param {'throw' | 'pile'} kind @param {Vec3} point @param {Vec3} way */
function toy(kind, point, way) {
  const number = (/** @type {string} */ id) => Number(element(id, HTMLInputElement).value);
  if (kind === 'throw') {
    const radius = number('ball') / 2;
    say({ do: 'throw', from: add(add(point, scale(way, 2 * radius)), origin), velocity: scale(way, number('fast')), radius });
  } else say({ do: 'pile', over: add(point, origin), size: number('box'), count: Math.round(number('many')) });
}

/** @param {import('./hands.js').Tool} tool */
function choose(tool) {
  hands.tool = tool;
  document.body.dataset.tool = tool;
  for (const button of document.querySelectorAll('#tools button')) {
    button.setAttribute('aria-pressed', String(button.getAttribute('data-tool') === tool));
  }
}

/** Light or dark, as the box has it. */
function theme() {
  document.documentElement.dataset.theme = panel.dark.checked ? 'dark' : 'light';
  draw.dark = panel.dark.checked;
  try {
    localStorage.setItem('dark', String(panel.dark.checked));
  } catch {
    // A browser that keeps nothing has its own choice.
  }
  panel.graph.draw();
  dirty = true;
}

function help() {
  const box = element('keys', HTMLElement);
  box.replaceChildren(
    ...KEYS.map(([keys, what]) => {
      const row = document.createElement('p'), key = document.createElement('kbd');
      key.textContent = keys;
      row.append(key, ` ${what}`);
      return row;
    }),
  );
  element('help', HTMLDialogElement).showModal();
}

/** Whether a key means anything. @param {string} key @param {boolean} shift */
function key(key, shift) {
  const tools = /** @type {const} */ (['look', 'grab', 'throw', 'pile']);
  /** @type {Record<string, () => void>} */
  const actions = {
    ' ': () => timeline.toggle(), ',': () => say({ do: 'step', by: -1 }), '.': () => say({ do: 'step', by: 1 }),
    Home: () => timeline.start(), End: () => timeline.end(), '-': () => timeline.change(-1), '+': () => timeline.change(1), '=': () => timeline.change(1),
    l: () => timeline.loop(), f: fit, p: () => panel.toggle(), v: share, k: () => say({ do: 'save' }), '?': help,
    c: () => {
      panel.color.selectedIndex = (panel.color.selectedIndex + 1) % panel.color.options.length;
      see();
    },
    o: () => {
      const box = document.querySelector('#overlays input[name=contacts]');
      if (box instanceof HTMLInputElement) box.checked = !box.checked;
      see();
    },
    t: () => {
      panel.dark.checked = !panel.dark.checked;
      theme();
    },
    Escape: () => {
      hands.release();
      panel.pick(null);
    },
  };
  if (shift && key === 'R') say({ do: 'reset' });
  else if (tools[Number(key) - 1] && panel.live) choose(tools[Number(key) - 1]);
  else if (actions[key.length === 1 ? key.toLowerCase() : key]) actions[key.length === 1 ? key.toLowerCase() : key]();
  else return false;
  return true;
}

/** One picture, if there is anything new to see. @param {number} now */
function picture(now) {
  requestAnimationFrame(picture);
  const seconds = Math.min(0.1, (now - last) / 1000);
  last = now;
  if (hands.busy) {
    hands.go(seconds);
    dirty = true;
  }
  if (camera.shift !== panel.covers) {
    camera.shift = panel.covers;
    dirty = true;
  }
  const mix = stage.glides ? Math.min(1, (performance.now() - came) / pause) : 1;
  if (now - counted >= 1000) {
    fps = (1000 * pictures) / (now - counted);
    [pictures, counted] = [0, now];
    // Bodies wander; the sun's picture follows.
    if (status?.playing) draw.extent = stage.extent();
  }
  weigh(now);
  if (!dirty && mix === draw.mix) return;
  // A processor that draws has a simulation to run as well.
  if (draw.software && now - drawn < 40) return;
  dirty = mix < 1;
  draw.mix = mix;
  draw.draw(stage, camera, hands.string);
  pictures++;
  drawn = now;
  if (fence) return;
  began = now;
  fence = draw.gl.fenceSync(draw.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  draw.gl.flush();
}

/** Looks whether the picture that is measured is done, and how long it took. How often there is one tells nothing of it: a simulation may be slower. @param {number} now */
function weigh(now) {
  const { gl } = draw;
  if (!fence || gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) return;
  gl.deleteSync(fence);
  fence = null;
  adapt(now - began);
}

/** Fewer pixels where pictures are slow, more where they are quick. @param {number} took milliseconds */
function adapt(took) {
  if (took > 3000) return;
  slow = 0.85 * slow + 0.15 * took;
  const most = Math.min(devicePixelRatio, 2);
  if (slow > SLOW && draw.ratio > 0.55 * most) {
    draw.ratio = Math.max(0.5 * most, draw.ratio * 0.7);
    slow = (SLOW + QUICK) / 2;
    dirty = true;
  } else if (slow < QUICK && draw.ratio < most) {
    draw.ratio = Math.min(most, draw.ratio * 1.1);
    slow = (SLOW + QUICK) / 2;
  }
}
let slow = 20;

for (const button of document.querySelectorAll('#tools button')) {
  if (button instanceof HTMLElement) button.onclick = () => choose(/** @type {import('./hands.js').Tool} */ (button.dataset.tool));
}
addEventListener('resize', moved);
addEventListener('hashchange', () => {
  const view = link.read(location.hash);
  if (view) go(view);
});
canvas.addEventListener('webglcontextlost', (event) => {
  event.preventDefault();
  message('The graphics card was lost; the page loads anew.', true);
  setTimeout(() => location.reload(), 1500);
});
let dark = matchMedia('(prefers-color-scheme: dark)').matches;
try {
  dark = (localStorage.getItem('dark') ?? String(dark)) === 'true';
} catch {
  // As the browser has it.
}
panel.dark.checked = dark;
document.body.classList.toggle('software', draw.software);
theme();
panel.toggle(innerWidth > 1000);
requestAnimationFrame(picture);

/** For the browser's console, and for tests: what the page knows, and a picture at once. */
Object.assign(globalThis, {
  rockfall: {
    stage, camera, wire, draw, hands, panel,
    status: () => status,
    hello: () => hello,
    picture: () => draw.draw(stage, camera, hands.string),
  },
});
