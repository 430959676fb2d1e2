// What the scripts share that drive the page in a real browser: node SCRIPT PLAYWRIGHT CHROMIUM URL [FOLDER FOR SCREENSHOTS]. Lines on standard output ask the test that started the script for something,
// which it answers by a line.
import { createRequire } from 'node:module';
import { createInterface } from 'node:readline';
import assert from 'node:assert/strict';

const [playwright, executablePath, address, shots] = process.argv.slice(2);
export const url = address;
const { chromium } = createRequire(import.meta.url)(playwright);
const answers = createInterface({ input: process.stdin })[Symbol.asyncIterator]();
export const ask = async (what) => {
  console.log(what);
  return (await answers.next()).value;
};
const began = Date.now();
export const done = (what) => console.error(`${((Date.now() - began) / 1000).toFixed(1)} s  ${what}`);

const browser = await chromium.launch({
  executablePath,
  args: ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-gpu-compositing', '--no-sandbox'],
});
const troubles = [];
export const open = async (address = url, options = {}) => {
  const context = await browser.newContext({ viewport: { width: 800, height: 420 }, permissions: ['clipboard-read', 'clipboard-write'], ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(30000);
  page.on('pageerror', (error) => troubles.push(String(error)));
  page.on('console', (line) => line.type() === 'error' && !line.text().includes('WebSocket') && troubles.push(line.text()));
  await page.goto(address);
  await page.waitForFunction(() => globalThis.rockfall?.stage.rows.length > 0 && rockfall.status(), undefined, { polling: 60 });
  return page;
};
export const shoot = async (page, name) => shots && (await page.screenshot({ path: `${shots}/${name}.png` }));
export const value = (page, script, argument) => page.evaluate(script, argument);
export const until = (page, script, argument) => page.waitForFunction(script, argument, { polling: 60 });
/** The picture as it is, its colours in steps of 16 counted; and the share of pixels that differ from a former one. */
export const picture = (page) =>
  value(page, () => {
    // As many pixels each time, however slow the machine is.
    rockfall.draw.ratio = 0.5;
    rockfall.picture();
    const bytes = rockfall.draw.pixels();
    const before = globalThis.before;
    globalThis.before = bytes;
    const colors = new Set();
    let differ = 0;
    for (let k = 0; k < bytes.length; k += 4) {
      colors.add(((bytes[k] >> 4) << 8) | ((bytes[k + 1] >> 4) << 4) | (bytes[k + 2] >> 4));
      if (before?.length === bytes.length && Math.abs(bytes[k] - before[k]) + Math.abs(bytes[k + 1] - before[k + 1]) > 12) differ++;
    }
    return { colors: colors.size, differ: (4 * differ) / bytes.length };
  });
/** Where the body in a row is on the screen. */
export const onScreen = (page, row) =>
  value(
    page,
    (row) => {
      const { stage, camera, draw } = rockfall;
      const at = stage.place(row), eye = camera.eye, [r, u, f] = camera.axes;
      const way = at.map((x, k) => x - eye[k]);
      const dot = (a) => a[0] * way[0] + a[1] * way[1] + a[2] * way[2];
      const box = draw.canvas.getBoundingClientRect();
      return [
        box.left + (0.5 - 0.5 * camera.shift + (0.5 * dot(r)) / (dot(f) * camera.half * draw.aspect)) * box.width,
        box.top + (0.5 - (0.5 * dot(u)) / (dot(f) * camera.half)) * box.height,
      ];
    },
    row,
  );

/** Does the work, says how things stood where it fails, and ends the browser. @param {() => Promise<void>} work */
export const drive = async (work) => {
  try {
    await work();
    assert.deepEqual(troubles, []);
  } catch (error) {
    const state = () => ({ status: rockfall.status(), said: document.querySelector('#messages').textContent, held: rockfall.hands.held, tool: rockfall.hands.tool, pictures: rockfall.draw.calls });
    for (const page of browser.contexts().flatMap((context) => context.pages())) {
      console.error(JSON.stringify(await page.evaluate(state).catch(String)));
    }
    throw error;
  } finally {
    await browser.close();
  }
  process.exit(0);
};
