// A simulation on the page: all that one can look at, and touch.
import assert from 'node:assert/strict';
import { ask, done, drive, onScreen, open, picture, shoot, until, url, value } from './browser.mjs';

await drive(async () => {
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
  // Of what has been, places alone are kept; that is said.
  await value(page, () => rockfall.panel.toggle(true));
  await page.locator('#back').click();
  await until(page, () => /As at frame\d+.*Mass2 600 kg.*Velocitynot keptSpeednot kept/.test(document.querySelector('#told').textContent));
  await page.locator('#body').scrollIntoViewIfNeeded();
  await shoot(page, 'past');
  await page.locator('#newest').click();
  await until(page, () => !document.querySelector('#told').textContent.includes('not kept'));
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
});
