// The panel at the side: what is seen, what is told of a body, and what holds in the world.

import { Graph } from './graph.js';

/** An element of the page. @template {HTMLElement} T @param {string} id @param {new () => T} kind @returns {T} */
export function element(id, kind) {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`the page has no ${id}`);
  return found;
}

/** A number for people: three digits that count. @param {number | null | undefined} x */
export function short(x) {
  if (x === null || x === undefined || !Number.isFinite(x)) return '–';
  if (x === 0) return '0';
  const size = Math.abs(x);
  if (size >= 1e6 || size < 1e-3) return x.toExponential(2).replace('e', ' e');
  return size >= 1000 ? Math.round(x).toLocaleString('en').replaceAll(',', ' ') : String(Number(x.toPrecision(3)));
}

/** @param {number[] | null | undefined} v */
const vector = (v) => (v ? v.map((x) => short(Math.abs(x) < 5e-4 ? 0 : x)).join(', ') : '–');

export class Panel {
  /** @param {(command: object) => void} say @param {{see: () => void, camera: (name: string) => void, theme: () => void, share: () => void, fit: () => void}} actions */
  constructor(say, actions) {
    this.say = say;
    this.actions = actions;
    this.graph = new Graph(element('graph', HTMLCanvasElement), element('stages', HTMLElement));
    this.color = element('color', HTMLSelectElement);
    this.camera = element('camera', HTMLSelectElement);
    this.shadows = element('shadows', HTMLInputElement);
    this.dark = element('dark', HTMLInputElement);
    this.live = false;
    /** @type {any} */
    this.status = null;
    /** The row of the body that is told of, or none. @type {number | null} */
    this.picked = null;
    this.follows = false;
    this.usual = 1;
    this.color.onchange = this.shadows.onchange = actions.see;
    this.dark.onchange = actions.theme;
    this.camera.onchange = () => actions.camera(this.camera.value);
    element('fit', HTMLElement).onclick = actions.fit;
    element('share', HTMLElement).onclick = actions.share;
    element('drop-pick', HTMLElement).onclick = () => this.pick(null);
    element('follow', HTMLElement).onclick = () => this.follow(!this.follows);
    element('menu', HTMLElement).onclick = () => this.toggle();
    element('reset', HTMLElement).onclick = () => say({ do: 'reset' });
    element('save', HTMLElement).onclick = () => say({ do: 'save' });
    const gravity = element('gravity', HTMLInputElement);
    gravity.oninput = () => {
      const [x, y] = this.status?.settings?.gravity ?? [0, 0];
      say({ do: 'set', gravity: [x, y, Number(gravity.value)] });
    };
    element('solver', HTMLSelectElement).onchange = (event) => say({ do: 'set', solver: /** @type {HTMLSelectElement} */ (event.target).value });
    element('substeps', HTMLInputElement).onchange = (event) => {
      const count = Math.round(Number(/** @type {HTMLInputElement} */ (event.target).value));
      if (count > 0) say({ do: 'set', substeps: count });
    };
  }

  /** @param {any} hello */
  greet(hello) {
    this.live = hello.live;
    element('title', HTMLElement).textContent = hello.title;
    document.title = `${hello.title} · Rockfall`;
    document.body.classList.toggle('recorded', !hello.live);
    element('cost-title', HTMLElement).textContent = hello.live ? 'Time of a step' : 'State';
    const old = this.color.value;
    options(this.color, hello.colors);
    if (hello.colors.includes(old)) this.color.value = old;
    options(this.camera, ['', ...hello.cameras.map((/** @type {any} */ camera) => camera.name)], 'free');
    options(element('solver', HTMLSelectElement), hello.solvers);
    const marks = element('overlays', HTMLFieldSetElement);
    if (marks.querySelectorAll('input').length !== hello.overlays.length) {
      marks.replaceChildren(
        marks.querySelector('legend') ?? '',
        ...hello.overlays.map((/** @type {string} */ name) => {
          const label = document.createElement('label'), box = document.createElement('input');
          Object.assign(box, { type: 'checkbox', name, onchange: this.actions.see });
          label.append(box, ` ${name}`);
          return label;
        }),
      );
    }
    this.graph.name(hello.stages);
  }

  /** What this viewer wants to see. */
  get wish() {
    const boxes = [...document.querySelectorAll('#overlays input')];
    const overlays = boxes.filter((box) => box instanceof HTMLInputElement && box.checked).map((box) => box.getAttribute('name'));
    return { do: 'show', color: this.color.value || 'body', overlays, pick: this.picked };
  }

  /** @param {number | null} row */
  pick(row) {
    this.picked = row;
    if (row === null) {
      this.follow(false);
      element('body', HTMLElement).hidden = true;
    }
    this.actions.see();
  }

  /** @param {boolean} on */
  follow(on) {
    this.follows = on && this.picked !== null;
    element('follow', HTMLElement).setAttribute('aria-pressed', String(this.follows));
  }

  toggle(open = !document.body.classList.contains('panel-open')) {
    document.body.classList.toggle('panel-open', open);
    element('menu', HTMLElement).setAttribute('aria-expanded', String(open));
    this.graph.draw();
  }

  /** Share of the page that the panel covers on the right. */
  get covers() {
    const beside = document.body.classList.contains('panel-open') && innerWidth > 760;
    return beside ? (element('panel', HTMLElement).offsetWidth + 24) / innerWidth : 0;
  }

  /** Everything that is known of a body. @param {any} told */
  tell(told) {
    if (told.row !== this.picked) return;
    element('body', HTMLElement).hidden = false;
    element('who', HTMLElement).textContent = told.gone ? 'not there' : (told.name ?? (told.id ? `no. ${told.id}` : ''));
    /** @type {[string, string][]} */
    const lines = [];
    /** @param {string} name @param {string | null | undefined | false} value */
    const line = (name, value) => value && lines.push([name, value]);
    /** What is kept of the present alone. @param {any} known @param {string} value */
    const kept = (known, value) => (told.past !== undefined && known === null ? 'not kept' : value);
    if (told.why) line('', told.why);
    if (told.past !== undefined) line('As at frame', `${told.past}; the newest tells all`);
    if (told.id && !told.why) {
      line('Number', told.id);
      line('Shape', `${told.shape ?? '–'}, ${vector(told.size)} m`);
      line('Material', told.material);
      line('Moved by', { dynamic: 'forces', kinematic: 'its velocity', static: 'nobody' }[/** @type {'dynamic' | 'kinematic' | 'static'} */ (told.kind)]);
      line('Mass', told.mass && `${short(told.mass)} kg`);
      line('Position', `${vector(told.position)} m`);
      line('Rotation', vector(told.rotation));
      line('Velocity', kept(told.velocity, `${vector(told.velocity)} m/s`));
      line('Speed', kept(told.velocity, `${short(Math.hypot(...(told.velocity ?? [])))} m/s`));
      line('Spin', kept(told.spin, `${vector(told.spin)} rad/s`));
      line('State', told.asleep === null ? null : told.asleep ? 'asleep' : 'awake');
      line('Pressed by', kept(told.force, told.force === null ? '' : `${short(told.force)} N`));
      if (told.contacts_unknown) line('Contacts', told.contacts_unknown);
      else line('Contacts', kept(told.contact_count, String(told.contact_count)));
    }
    const list = element('told', HTMLElement);
    const entries = lines.flatMap(([name, value]) => [make('dt', name), make('dd', value)]);
    for (const contact of told.contacts ?? []) {
      const depth = contact.distance < 0 ? `${short(-1000 * contact.distance)} mm deep` : `${short(1000 * contact.distance)} mm apart`;
      entries.push(make('dt', `with ${contact.name ?? `no. ${contact.with}`}`), make('dd', `${short(contact.force)} N, ${depth}`));
    }
    list.replaceChildren(...entries);
  }

  /** @param {any} legend */
  explain(legend) {
    const box = element('legend', HTMLElement);
    box.hidden = !legend.ramp && !legend.names;
    if (legend.ramp) {
      const bar = make('div', '');
      bar.className = 'ramp';
      bar.style.background = `linear-gradient(to right, ${legend.ramp.map((/** @type {number[]} */ c) => `rgb(${c})`).join(',')})`;
      const [low, high] = legend.span;
      const numbers = make('div', '');
      numbers.className = 'numbers';
      numbers.append(...[0, 0.25, 0.5, 0.75, 1].map((share) => make('span', short(low + share * (high - low)))));
      box.replaceChildren(make('b', `${legend.title}, ${legend.unit}`), bar, numbers);
    } else if (legend.names) {
      const rows = legend.names.slice(0, 12).map((/** @type {any} */ entry) => {
        const row = make('div', ''), swatch = make('i', '');
        swatch.style.background = `rgb(${entry.color})`;
        row.append(swatch, entry.name);
        return row;
      });
      if (legend.names.length > 12) rows.push(make('div', `and ${legend.names.length - 12} more`));
      box.replaceChildren(make('b', legend.title), ...rows);
    }
  }

  /** @param {any} status @param {number} fps */
  show(status, fps) {
    this.status = status;
    const figures = [`${(status.bodies ?? 0).toLocaleString('en').replaceAll(',', ' ')} bodies`];
    if (status.figures && status.frame === status.present) figures.push(`${status.figures.awake.toLocaleString('en').replaceAll(',', ' ')} awake`);
    if (status.playing && status.pace > 0) figures.push(`${short(status.pace)}× real time`);
    if (fps > 0) figures.push(`${fps.toFixed(0)} pictures/s`);
    if (status.far) figures.push(`${status.far} too far away to be drawn`);
    if (status.grows && !this.live) figures.push('still being written');
    element('figures', HTMLElement).textContent = figures.join(' · ');
    const state = element('state', HTMLElement);
    /** @type {[string, string][]} */
    const lines = [['Viewers', String(status.viewers)], ['Positions within', `${short(500 * (status.step ?? 0))} mm`]];
    if (status.figures) {
      const { figures: f, history } = status;
      const megabytes = (/** @type {number} */ bytes) => `${(bytes / 2 ** 20).toFixed(bytes < 2 ** 23 ? 1 : 0)} MB`;
      element('step-ms', HTMLElement).textContent = `${short(f.step_ms)} ms`;
      if (status.present > 0) this.graph.add(status.present, f.stages_ms);
      lines.unshift(
        ['Contacts', `${short(f.contacts)} in ${short(f.touching)} pairs`],
        ['Deepest', `${short(1000 * f.deepest)} mm`],
        ['Kinetic energy', `${short(f.kinetic)} J`],
        ['Kept to look back', `${megabytes(history.bytes)} of ${megabytes(history.most)}, from frame ${status.first}`],
      );
      if (f.frozen) lines.unshift(['Frozen', `${f.frozen} bodies whose state was not finite`]);
      this.settings(status);
    }
    state.replaceChildren(...lines.flatMap(([name, value]) => [make('dt', name), make('dd', value)]));
  }

  /** @param {any} status */
  settings(status) {
    const idle = (/** @type {HTMLElement} */ input) => document.activeElement !== input;
    const gravity = element('gravity', HTMLInputElement);
    const z = status.settings.gravity[2];
    if (idle(gravity)) gravity.value = String(z);
    element('gravity-out', HTMLElement).textContent = `${short(z)} m/s²`;
    const solver = element('solver', HTMLSelectElement), substeps = element('substeps', HTMLInputElement);
    if (idle(solver)) solver.value = status.settings.solver;
    if (idle(substeps)) substeps.value = String(status.settings.substeps);
    const box = element('materials', HTMLElement);
    if (box.children.length !== status.materials.length) {
      box.replaceChildren(...status.materials.map((/** @type {any} */ material, /** @type {number} */ index) => this.material(material.name, index)));
    }
    status.materials.forEach((/** @type {any} */ material, /** @type {number} */ k) => {
      for (const input of box.children[k].querySelectorAll('input')) {
        const value = material[input.name];
        if (idle(input)) input.value = String(Number(value.toPrecision(3)));
        const out = input.parentElement?.querySelector('output');
        if (out) out.textContent = short(value);
      }
    });
  }

  /** @param {string} name @param {number} index */
  material(name, index) {
    const box = make('fieldset', '');
    box.append(make('legend', name));
    for (const [key, most] of /** @type {[string, number][]} */ ([['friction', 2], ['restitution', 1]])) {
      const label = make('label', `${key[0].toUpperCase()}${key.slice(1)} `), input = document.createElement('input');
      Object.assign(input, { type: 'range', name: key, min: '0', max: String(most), step: '0.01' });
      input.setAttribute('aria-label', `${key} of ${name}`);
      input.oninput = () => this.say({ do: 'material', index, [key]: Number(input.value) });
      label.append(document.createElement('output'), input);
      box.append(label);
    }
    return box;
  }
}

/** @template {keyof HTMLElementTagNameMap} K @param {K} kind @param {string} text */
function make(kind, text) {
  const made = document.createElement(kind);
  made.textContent = text;
  return made;
}

/** @param {HTMLSelectElement} select @param {string[]} names @param {string} [empty] */
function options(select, names, empty = '') {
  select.replaceChildren(...names.map((name) => new Option(name || empty, name)));
}

/** Says something for a while. @param {string} text @param {boolean} wrong */
export function message(text, wrong = false) {
  const box = element('messages', HTMLElement);
  const last = [...box.children].find((child) => child.textContent === text);
  const line = last ?? box.appendChild(make('p', text));
  line.classList.toggle('wrong', wrong);
  clearTimeout(Number(line.getAttribute('data-timer')));
  line.setAttribute('data-timer', String(setTimeout(() => line.remove(), wrong ? 9000 : 5000)));
  while (box.children.length > 4) box.firstElementChild?.remove();
}
