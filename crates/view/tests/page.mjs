// Drives the page in a real browser: node page.mjs PLAYWRIGHT CHROMIUM URL [FOLDER FOR SCREENSHOTS]. Lines on standard output ask the test that started it for something, which it answers by a line.
import { createRequire } from 'node:module';
import { createInterface } from 'node:readline';
import assert from 'node:assert/strict';

const [playwright, executablePath, url, shots] = process.argv.slice(2);
const { chromium } = createRequire(import.meta.url)(playwright);
const answers = createInterface({ input: process.stdin })[Symbol.asyncIterator]();
const ask = async (what) => {
  console.log(what);
  return (await answers.next()).value;
};
const began = Date.now();
const done = (what) => console.error(`${((Date.now() - began) / 1000).toFixed(1)} s  ${what}`);

const browser = await chromium.launch({
  executablePath,
  args: ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-gpu-compositing', '--no-sandbox'],
});
const troubles = [];
const open = async (address = url, options = {}) => {
  const context = await browser.newContext({ viewport: { width: 800, height: 420 }, permissions: ['clipboard-read', 'clipboard-write'], ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(30000);
  page.on('pageerror', (error) => troubles.push(String(error)));
  page.on('console', (line) => line.type() === 'error' && !line.text().includes('WebSocket') && troubles.push(line.text()));
  await page.goto(address);
  await page.waitForFunction(() => globalThis.rockfall?.stage.rows.length > 0 && rockfall.status(), undefined, { polling: 60 });
  return page;
};
const shoot = async (page, name) => shots && (await page.screenshot({ path: `${shots}/${name}.png` }));
const value = (page, script, argument) => page.evaluate(script, argument);
const until = (page, script, argument) => page.waitForFunction(script, argument, { polling: 60 });
/** The picture as it is, its colours in steps of 16 counted; and the share of pixels that differ from a former one. */
const picture = (page) =>
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
const onScreen = (page, row) =>
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

try {
  const page = await open();
  // It plays, and it draws.
  await until(page, () => rockfall.stage.frame > 40);
  await page.locator('#view').press('Space');
  await until(page, () => !rockfall.status().playing);
  for (const frame of [2, 40]) {
    await page.locator('#time').fill(String(frame));
    await until(page, (frame) => rockfall.stage.frame === frame, frame);
    const seen = await picture(page);
    assert.ok(seen.colors > 40, `${seen.colors} colours are no picture`);
    assert.ok(frame === 2 || seen.differ > 0.01, `${seen.differ} of the picture has moved`);
  }
  // The processor draws here, and has other things to do.
  await page.locator('#shadows').evaluate((box) => box.click());
  await until(page, () => !rockfall.draw.shadows);
  done('loads, draws and plays');

  // Time: keys, buttons, the slider.
  await page.locator('#play').click();
  await until(page, () => rockfall.status().playing && rockfall.stage.frame > 42);
  await page.locator('#play').click();
  await until(page, () => !rockfall.status().playing);
  await page.locator('#time').fill('5');
  await until(page, () => rockfall.stage.frame === 5);
  const fifth = await value(page, () => rockfall.stage.place(60));
  await page.locator('#back').click();
  await until(page, () => rockfall.stage.frame === 4);
  assert.ok((await value(page, () => rockfall.stage.place(60)))[2] > fifth[2], 'one frame back it is higher');
  await page.locator('#forth').click();
  await until(page, () => rockfall.stage.frame === 5);
  assert.deepEqual(await value(page, () => rockfall.stage.place(60)), fifth);
  await page.locator('#newest').click();
  await until(page, () => rockfall.stage.frame === rockfall.status().last);
  await page.locator('#speed').selectOption('0.25');
  await until(page, () => rockfall.status().speed === 0.25);
  await page.locator('#speed').selectOption('1');
  await page.locator('#loop').click();
  await until(page, () => rockfall.status().loop);
  await page.locator('#loop').click();
  await until(page, () => !rockfall.status().loop);
  done('scrubs, steps, slows down, loops');

  // Everything of a body; colours and overlays.
  const still = await onScreen(page, 123);
  await page.mouse.click(...still);
  await until(page, () => document.querySelector('#body').hidden === false && document.querySelector('#told').textContent.includes('2 600 kg'));
  await value(page, () => rockfall.panel.toggle(true));
  await page.locator('#color').selectOption('force');
  await until(page, () => document.querySelector('#legend').textContent.includes('contact force, N'));
  await page.locator('#overlays input[name=contacts]').check();
  await page.locator('#overlays input[name=bounds]').check();
  await until(page, () => rockfall.stage.lineCount > 100);
  assert.ok((await picture(page)).differ > 0.01, 'colours and overlays are to be seen');
  for (const name of await page.locator('#color option').allTextContents()) {
    await page.locator('#color').selectOption(name);
    await until(page, (name) => rockfall.status() && (name === 'body' || document.querySelector('#legend').hidden === false), name);
  }
  await shoot(page, 'overlays');
  await page.locator('#overlays input[name=contacts]').uncheck();
  await page.locator('#overlays input[name=bounds]').uncheck();
  await page.locator('#color').selectOption('body');
  await until(page, () => rockfall.stage.lineCount === 0);
  await value(page, () => rockfall.panel.toggle(false));
  await page.locator('#view').press('Escape');
  done('tells of a body, paints and marks');

  // A hand: the simulation shows what it does.
  await page.locator('#tools [data-tool=grab]').click();
  const [x, y] = await onScreen(page, 123);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await until(page, () => rockfall.status().held);
  // Another one may stand in front of it.
  const row = await value(page, () => rockfall.hands.held.row);
  const before = await value(page, (row) => rockfall.stage.place(row), row);
  await page.mouse.move(x - 60, y - 90, { steps: 6 });
  await until(page, ([row, z]) => rockfall.stage.place(row)[2] > z + 0.6, [row, before[2]]);
  await shoot(page, 'drag');
  await page.mouse.up();
  await until(page, () => !rockfall.status().held);
  const count = await value(page, () => rockfall.stage.rows.length);
  await page.locator('#tools [data-tool=throw]').click();
  await page.mouse.click(x, y);
  await until(page, (count) => rockfall.stage.rows.length === count + 1, count);
  await page.locator('#tools [data-tool=pile]').click();
  await page.mouse.click(x, y);
  await until(page, (count) => rockfall.stage.rows.length > count + 40, count);
  await page.locator('#tools [data-tool=look]').click();
  await value(page, () => rockfall.panel.toggle(true));
  await page.locator('#gravity').fill('6');
  await until(page, () => rockfall.status().settings.gravity[2] === 6);
  await page.locator('#materials input[name=friction]').first().fill('0.05');
  await until(page, () => rockfall.status().materials[0].friction < 0.06);
  await page.locator('#substeps').fill('8');
  await page.locator('#substeps').press('Enter');
  await until(page, () => rockfall.status().settings.substeps === 8);
  await page.locator('#save').click();
  await until(page, () => document.querySelector('#messages').textContent.includes('saved as'));
  await page.locator('#reset').click();
  await until(page, (count) => rockfall.stage.rows.length === count && rockfall.status().settings.substeps === 4, count);
  done('drags, throws, drops, changes the world, saves, resets');

  // Camera, link, keys, both themes.
  await value(page, () => rockfall.panel.toggle(false));
  const eye = await value(page, () => rockfall.camera.eye);
  await page.mouse.move(360, 100);
  await page.mouse.down();
  await page.mouse.move(430, 130, { steps: 4 });
  await page.mouse.up();
  await page.mouse.wheel(0, -300);
  await until(page, (eye) => Math.hypot(...rockfall.camera.eye.map((x, k) => x - eye[k])) > 0.5, eye);
  await until(page, () => rockfall.stage.frame > 12);
  await page.locator('#play').click();
  await until(page, () => !rockfall.status().playing);
  await page.locator('#time').fill('9');
  await until(page, () => rockfall.stage.frame === 9 && rockfall.status().frame === 9);
  await value(page, () => rockfall.panel.toggle(true));
  await page.locator('#share').click();
  await until(page, () => location.hash.includes('frame=9'));
  const link = page.url(), seen = await value(page, () => [...rockfall.camera.eye, ...rockfall.camera.target]);
  await page.locator('#view').press('?');
  await page.locator('#help').waitFor({ state: 'visible' });
  await page.keyboard.press('Escape');
  await page.locator('#help').waitFor({ state: 'hidden' });
  await value(page, () => (rockfall.panel.dark.checked = false));
  await page.locator('#view').press('t');
  await until(page, () => document.documentElement.dataset.theme === 'dark');
  await shoot(page, 'dark');
  await page.locator('#view').press('t');
  done('turns, links, lists its keys, light and dark');

  // Three at once, one of which stops listening, and one of which talks rubbish.
  const [second, third] = [await open(link), await open(url, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true })];
  await until(second, () => rockfall.stage.frame === 9);
  const there = await value(second, () => [...rockfall.camera.eye, ...rockfall.camera.target]);
  there.forEach((x, k) => assert.ok(Math.abs(x - seen[k]) < 1e-3, `the link leads to ${there}, not ${seen}`));
  const wide = await value(third, () => document.documentElement.scrollWidth);
  assert.ok(wide <= 390, `the page is ${wide} wide on a phone`);
  await until(page, () => rockfall.status().viewers === 3);
  await value(third, () => (rockfall.wire.socket.onmessage = () => {}));
  await value(second, () => rockfall.wire.socket.send('rubbish'));
  await until(second, () => document.querySelector('#messages').textContent.includes('that is no command'));
  await page.locator('#newest').click();
  await page.locator('#play').click();
  for (const one of [page, second]) {
    const now = await value(one, () => rockfall.stage.frame);
    await until(one, (now) => rockfall.stage.frame > now + 30, now);
  }
  await shoot(third, 'phone');
  // Who hears nothing for a while takes the connection for lost, and makes another one.
  await until(third, () => rockfall.stage.frame > 0 && rockfall.wire.socket?.onmessage?.toString().includes('heard'));
  await third.locator('#menu').tap();
  await shoot(third, 'phone-panel');
  await third.close();
  done('three at once');

  // The program ends, and comes back.
  assert.equal(await ask('stop'), 'stopped');
  await page.locator('#lost').waitFor({ state: 'visible' });
  assert.equal(await ask('start'), 'started');
  await page.locator('#lost').waitFor({ state: 'hidden' });
  await until(page, () => rockfall.stage.frame > 5 && rockfall.status().playing);
  assert.ok((await picture(page)).colors > 40);
  await shoot(page, 'wide');
  done('finds its way back');
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
