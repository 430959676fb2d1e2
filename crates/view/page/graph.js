// Milliseconds of each stage of the last steps, one above the other.

/** Steps that are shown. */
const STEPS = 120;
const COLORS = ['#6b7a8f', '#8aa0b8', '#4f86a8', '#3fa7a0', '#66b26f', '#a8bf5a', '#d8b84a', '#e29a44', '#d9663f', '#c2485a', '#a4528f', '#7d5fb0', '#5b6cc4', '#9a9a9a'];

export class Graph {
  /** @param {HTMLCanvasElement} canvas @param {HTMLElement} list */
  constructor(canvas, list) {
    this.canvas = canvas;
    this.list = list;
    /** @type {number[][]} */
    this.steps = [];
    this.last = -1;
    /** @type {HTMLElement[]} */
    this.numbers = [];
  }

  /** @param {string[]} stages */
  name(stages) {
    this.steps = [];
    this.numbers = [];
    this.list.replaceChildren(
      ...stages.map((name, k) => {
        const item = document.createElement('li'), swatch = document.createElement('i'), number = document.createElement('b');
        swatch.style.background = COLORS[k % COLORS.length];
        this.numbers.push(number);
        item.append(swatch, name, number);
        return item;
      }),
    );
  }

  /** Adds a step, unless it is there. @param {number} step @param {number[]} times milliseconds */
  add(step, times) {
    if (step === this.last) return;
    this.last = step;
    this.steps.push(times);
    if (this.steps.length > STEPS) this.steps.shift();
    this.draw();
  }

  draw() {
    const { canvas, steps } = this;
    const pen = canvas.getContext('2d');
    if (!pen || !canvas.offsetParent) return;
    const style = getComputedStyle(canvas);
    const { width, height } = canvas;
    const totals = steps.map((times) => times.reduce((a, b) => a + b, 0));
    const most = round(Math.max(1e-3, ...totals));
    pen.clearRect(0, 0, width, height);
    const wide = width / STEPS;
    steps.forEach((times, k) => {
      let y = height;
      times.forEach((time, stage) => {
        const high = (time / most) * (height - 26);
        pen.fillStyle = COLORS[stage % COLORS.length];
        y -= high;
        pen.fillRect((STEPS - steps.length + k) * wide, y, wide + 0.5, high + 0.5);
      });
    });
    pen.strokeStyle = pen.fillStyle = style.color;
    pen.globalAlpha = 0.35;
    for (const share of [0.5, 1]) {
      const y = Math.round(height - share * (height - 26)) + 0.5;
      pen.fillRect(0, y, width, 1);
    }
    pen.globalAlpha = 1;
    pen.font = `22px ${style.fontFamily}`;
    pen.fillText(`${most} ms`, 2, 20);
    const recent = steps.slice(-30);
    this.numbers.forEach((number, stage) => {
      const mean = recent.reduce((sum, times) => sum + times[stage], 0) / Math.max(1, recent.length);
      number.textContent = mean >= 10 ? mean.toFixed(0) : mean.toFixed(2);
    });
  }
}

/** A round number that is not smaller. @param {number} x */
function round(x) {
  const ten = 10 ** Math.floor(Math.log10(x));
  return Number(([1, 2, 5, 10].map((k) => k * ten).find((value) => value >= x) ?? x).toPrecision(2));
}
