// Time: the row of buttons at the lower edge.

import { element } from './panel.js';

export class Timeline {
  /** @param {(command: object) => void} say */
  constructor(say) {
    this.say = say;
    this.slider = element('time', HTMLInputElement);
    this.speed = element('speed', HTMLSelectElement);
    this.held = false;
    /** @type {any} */
    this.status = null;
    const button = (/** @type {string} */ id, /** @type {() => void} */ act) => (element(id, HTMLButtonElement).onclick = act);
    button('play', () => this.toggle());
    button('back', () => say({ do: 'step', by: -1 }));
    button('forth', () => say({ do: 'step', by: 1 }));
    button('newest', () => this.end());
    button('loop', () => this.loop());
    this.speed.onchange = () => say({ do: 'speed', of: Number(this.speed.value) });
    this.slider.oninput = () => {
      this.held = true;
      say({ do: 'seek', frame: Number(this.slider.value) });
    };
    this.slider.onchange = () => (this.held = false);
  }

  toggle() {
    this.say({ do: 'play', on: !this.status?.playing });
  }

  loop() {
    this.say({ do: 'loop', on: !this.status?.loop });
  }

  end() {
    this.say({ do: 'seek', frame: this.status?.last ?? 0 });
  }

  start() {
    this.say({ do: 'seek', frame: this.status?.first ?? 0 });
  }

  /** Slower (-1) or faster. @param {number} by */
  change(by) {
    const k = this.speed.selectedIndex + by;
    if (k < 0 || k >= this.speed.options.length) return;
    this.speed.selectedIndex = k;
    this.speed.dispatchEvent(new Event('change'));
  }

  /** @param {any} status */
  show(status) {
    this.status = status;
    const { slider } = this;
    const end = Math.max(status.planned, status.last, 1);
    slider.min = String(status.first);
    slider.max = String(end);
    if (!this.held) slider.value = String(status.frame);
    const known = (100 * (status.last - status.first)) / Math.max(1, end - status.first);
    element('known', HTMLElement).style.width = `${known}%`;
    slider.setAttribute('aria-valuetext', `frame ${status.frame} of ${end}`);
    element('clock', HTMLOutputElement).textContent = `${(status.time ?? 0).toFixed(2)} s · ${status.frame} / ${end}`;
    document.body.classList.toggle('playing', status.playing);
    element('loop', HTMLElement).setAttribute('aria-pressed', String(status.loop));
    element('newest', HTMLElement).hidden = !(status.grows && status.frame < status.last);
    const speeds = [...this.speed.options].map((option) => Number(option.value));
    const k = speeds.indexOf(status.speed);
    if (k >= 0 && document.activeElement !== this.speed) this.speed.selectedIndex = k;
  }
}
