// A run on the page: one that is complete, and one that is still being written.
import assert from 'node:assert/strict';
import { ask, done, drive, open, picture, shoot, until, url, value } from './browser.mjs';

/** Shows a frame, still. */
const seek = async (page, frame) => {
  await page.locator('#time').fill(String(frame));
  await until(page, (frame) => rockfall.stage.frame === frame && rockfall.status().frame === frame, frame);
};

await drive(async () => {
  const page = await open();
  // The processor draws here, and has other things to do.
  await page.locator('#shadows').evaluate((box) => box.click());
  assert.deepEqual(await value(page, () => [rockfall.hello().live, rockfall.status().last, rockfall.status().grows]), [false, 90, false]);
  // It plays to its end, and stands there.
  await until(page, () => rockfall.stage.frame === 90 && !rockfall.status().playing);
  assert.ok((await picture(page)).colors > 40, 'it is drawn');
  done('plays to the end');

  // Each frame has its picture, whenever one comes to it.
  await seek(page, 2);
  assert.ok((await picture(page)).differ > 0.01, 'the second frame is not the last one');
  await value(page, () => (globalThis.second = globalThis.before));
  const place = await value(page, () => rockfall.stage.place(60));
  await seek(page, 45);
  assert.ok((await picture(page)).differ > 0.01, 'what has fallen is somewhere else');
  await shoot(page, 'run');
  await seek(page, 2);
  await picture(page);
  assert.ok(await value(page, () => globalThis.before.every((byte, k) => byte === globalThis.second[k])), 'the same frame is the same picture');
  await page.locator('#forth').click();
  await until(page, () => rockfall.stage.frame === 3);
  assert.ok((await value(page, () => rockfall.stage.place(60)))[2] < place[2], 'it falls');
  await page.locator('#back').click();
  await until(page, () => rockfall.stage.frame === 2);
  assert.deepEqual(await value(page, () => rockfall.stage.place(60)), place);
  await page.locator('#view').press('End');
  await until(page, () => rockfall.stage.frame === 90);
  await page.locator('#view').press('Home');
  await until(page, () => rockfall.stage.frame === 0);
  await page.locator('#back').click();
  await page.locator('#forth').click();
  await until(page, () => rockfall.stage.frame === 1);
  done('scrubs, steps forth and back, to both ends');

  // Round and round.
  await seek(page, 80);
  await page.locator('#loop').click();
  await until(page, () => rockfall.status().loop);
  await page.locator('#play').click();
  await until(page, () => rockfall.stage.frame < 60);
  await until(page, () => rockfall.stage.frame > 60);
  await until(page, () => rockfall.stage.frame < 60);
  await page.locator('#loop').click();
  await until(page, () => !rockfall.status().loop && rockfall.stage.frame === 90 && !rockfall.status().playing);
  // At the end, to play is to begin again.
  await page.locator('#play').click();
  await until(page, () => rockfall.status().playing && rockfall.stage.frame < 80);
  await page.locator('#play').click();
  await until(page, () => !rockfall.status().playing);
  done('loops, and begins again');

  // All is known of all frames that the run has kept, and nothing can be touched.
  await seek(page, 30);
  await value(page, () => rockfall.panel.pick(60));
  await until(page, () => document.querySelector('#told').textContent.includes('m/s'));
  assert.ok(!(await value(page, () => document.querySelector('#told').textContent)).includes('not kept'));
  await value(page, () => rockfall.panel.toggle(true));
  await page.locator('#color').selectOption('speed');
  await until(page, () => document.querySelector('#legend').textContent.includes('speed, m/s'));
  await page.locator('#color').selectOption('force');
  await until(page, () => document.querySelector('#messages').textContent.includes('contact force: the run does not know forces'));
  assert.ok(!(await page.locator('#tools [data-tool=grab]').isVisible()), 'a run has no hands');
  await value(page, () => rockfall.wire.say({ do: 'throw', from: [0, 0, 9], velocity: [0, 0, 0], radius: 0.5 }));
  await until(page, () => document.querySelector('#messages').textContent.includes('a run is only to be looked at'));
  await shoot(page, 'run-panel');
  await page.locator('#color').selectOption('body');
  await value(page, () => rockfall.panel.toggle(false));
  done('tells of a body; nobody touches it');

  // A link leads to its time and its camera.
  await page.mouse.move(360, 100);
  await page.mouse.down();
  await page.mouse.move(430, 130, { steps: 4 });
  await page.mouse.up();
  await seek(page, 17);
  await page.locator('#view').press('v');
  await until(page, () => location.hash.includes('frame=17'));
  const link = page.url(), seen = await value(page, () => [...rockfall.camera.eye, ...rockfall.camera.target]);
  await seek(page, 71);
  const other = await open(link);
  await until(other, () => rockfall.stage.frame === 17 && rockfall.status().frame === 17);
  const there = await value(other, () => [...rockfall.camera.eye, ...rockfall.camera.target]);
  there.forEach((x, k) => assert.ok(Math.abs(x - seen[k]) < 1e-3, `the link leads to ${there}, not ${seen}`));
  await other.close();
  await page.close();
  done('links');

  // One that is still being written is followed, until it is complete.
  const growing = await open(await ask('grow'));
  await growing.locator('#shadows').evaluate((box) => box.click());
  assert.deepEqual(await value(growing, () => [rockfall.status().last, rockfall.status().grows]), [20, true]);
  await until(growing, () => document.querySelector('#figures').textContent.includes('still being written'));
  await until(growing, () => rockfall.stage.frame === 20);
  await picture(growing);
  assert.equal(await ask('more'), '40');
  await until(growing, () => rockfall.status().last === 40 && rockfall.stage.frame === 40);
  assert.ok((await picture(growing)).differ > 0.01, 'what was written meanwhile is shown');
  // Who looks back stays there while it goes on.
  await growing.locator('#play').click();
  await until(growing, () => !rockfall.status().playing);
  await seek(growing, 10);
  assert.equal(await ask('more'), '60');
  await until(growing, () => rockfall.status().last === 60);
  assert.equal(await value(growing, () => rockfall.stage.frame), 10);
  await growing.locator('#newest').click();
  await until(growing, () => rockfall.stage.frame === 60);
  await growing.locator('#play').click();
  assert.equal(await ask('finish'), '90');
  await until(growing, () => rockfall.status().last === 90 && !rockfall.status().grows && rockfall.stage.frame === 90 && !rockfall.status().playing);
  assert.ok(!(await value(growing, () => document.querySelector('#figures').textContent)).includes('still being written'));
  done('follows what is being written');
});
