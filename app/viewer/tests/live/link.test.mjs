// What is kept of the live page: its view as a link, its picture as PNG.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { fragment, frames } from '../browser.mjs';
import { startLivePage } from './live_page.mjs';

let site, server, live;
const file = encodeURIComponent('liver_tumours/palpation.h5');

before(async () => {
  site = await startLivePage();
  ({ server, live } = site);
});
after(() => site?.stop());

const fieldOf = (name) => live.page.locator(`#live-${name}`).inputValue();
const said = async () => ({
  numbers: await Promise.all(['law', 'young', 'nu', 'alpha', 'beta', 'legend-end', 'cut', 'cut-place'].map(fieldOf)),
  boxes: await Promise.all(['keeps-volume', 'fem', 'legend-follows'].map((name) => live.page.isChecked(`#live-${name}`))),
  colours: await live.page.locator('#live-colours :checked[name]').getAttribute('value'),
  surface: await live.page.locator('#live-skin :checked').getAttribute('value'),
});

test('a link made in Live opens the same springs, colours, cut, camera and FEM in Live', async () => {
  await live.goLive({});
  const { page } = live;
  assert.match(await fragment(live.page), /&mode=live&law=van_gelder&/);
  await live.set('nu', '0.3');
  await live.set('young', '7.5');
  await page.uncheck('#live-keeps-volume');
  await page.check('#live-translucent', { force: true });
  await page.selectOption('#live-cut', '0');
  await page.locator('#live-cut-place').fill('40');
  await page.check('#live-fem');
  await page.check('[name=live-shown][value=strain]');
  await page.locator('#live-legend-end').fill('2');
  await page.locator('#live-legend-end').press('Tab');
  await page.locator('#live-stage canvas').focus();
  for (const key of ['ArrowLeft', 'ArrowUp', '+']) await page.keyboard.press(key);
  const [link, before] = [await fragment(live.page), await said()];
  assert.deepEqual(before.boxes, [false, true, false]);
  await live.open({}, server.address + link);
  await live.moving();
  assert.deepEqual(await said(), before);
  assert.equal(await fragment(live.page), link);
  // And one made in Compare leads there, from Live as well.
  await live.page.evaluate((hash) => (location.hash = hash), link.replace(/&mode=live.*/, ''));
  await live.page.waitForSelector('#compare', { state: 'visible' });
  assert.equal(await live.isShown('stage'), false);
});

test('cuts and a tool that stays are in the link, and survive a reload', async () => {
  await live.goLive({});
  const { page } = live;
  await live.set('alpha', '60');
  await page.check('[name=tool][value=blade]');
  await page.click('#live-blade-cut');
  await page.waitForSelector('#live-blade-readings:not([hidden])');
  const [x, y] = await live.place();
  await page.mouse.move(x - 60, y + 20);
  await page.mouse.down();
  await page.mouse.move(x + 60, y + 20, { steps: 4 });
  await page.mouse.up();
  await page.waitForSelector('#live-blade-off-row:not([hidden])');
  const area = await live.value('blade-area');
  await page.check('[name=tool][value=probe]');
  await live.poke();
  await live.rests();
  const force = await live.value('force');
  assert.match(await fragment(page), /&live_done=region,1,5,1,1,[01]&live_done=blade,[-0-9.,]+,0,[01]&live_tool=probe,12,/);
  await page.reload();
  await live.moving();
  await page.waitForSelector('#live-blade-readings:not([hidden])');
  await live.above('indentation', 0.001);
  await live.rests();
  assert.ok(Math.abs((await live.value('blade-area')) / area - 1) < 1e-3);
  assert.ok(Math.abs((await live.value('force')) / force - 1) < 1e-3, `${await live.value('force')} after ${force} N`);
  // And so they survive the other engine, in whose own time friction holds a little elsewhere.
  await live.take('native');
  await page.waitForSelector('#live-blade-readings:not([hidden])');
  await live.above('indentation', 0.001);
  await live.rests();
  assert.ok(Math.abs((await live.value('force')) / force - 1) < 1e-2, `${await live.value('force')} after ${force} N`);
  // Whole again, nothing of it is in the link.
  await page.click('#live-reset');
  await page.waitForSelector('#live-blade-readings', { state: 'hidden' });
  assert.doesNotMatch(await fragment(page), /live_done|live_tool/);
});

test('jaws and a plate that stay are in the link, and survive a reload', async () => {
  await live.goLive({});
  const { page } = live;
  await live.set('alpha', '60');
  for (const [kind, force] of [['plate', 'force'], ['grasp', 'grasp-closing']]) {
    await page.check(`[name=tool][value=${kind}]`);
    await page.check('#live-stays');
    await (kind === 'plate' ? page.click('#live-touch') : page.mouse.click(...(await live.edge())));
    await live.above(force, 0.02);
    const link = await fragment(page);
    assert.match(link, new RegExp(`&live_tool=${kind},\\d+,\\d+,`));
    await page.reload();
    await live.moving();
    await live.above(force, 0.02);
    assert.equal(await page.isChecked(`[name=tool][value=${kind}]`), true);
    assert.equal(await fragment(page), link);
  }
});

test('a live link that makes no sense opens Live as it is at first', async () => {
  await live.open({}, `${server.address}#${file}?mode=live&law=van_gelder&nu=9&young=-1&alpha=x&live_colours=toString&live_end=-3&live_cut=w,900&live_surface=&live_camera=1,2&live_done=region,99999,x&live_done=blade,1&live_tool=probe,1,1e9`);
  await live.moving();
  assert.equal(await live.page.locator('#message').isVisible(), false);
  assert.deepEqual((await said()).numbers.slice(0, 4), ['van_gelder', '5', '0.45', '10']);
  assert.deepEqual([(await said()).colours, (await said()).surface], ['tissue', 'translucent']);
});

test('the picture of Live has twice the pixels of the screen', async () => {
  await live.goLive();
  await live.poke();
  await frames(live.page);
  const [download] = await Promise.all([live.page.waitForEvent('download'), live.page.click('#live-save-picture')]);
  assert.equal(download.suggestedFilename(), 'liver_tumours_live.png');
  const png = readFileSync(await download.path());
  const { width, height } = await live.page.locator('#live-stage canvas').boundingBox();
  assert.equal(png.readUInt32BE(16), 2 * Math.round(width));
  assert.ok(png.readUInt32BE(20) > 2 * height, 'title and legend are in it');
});
