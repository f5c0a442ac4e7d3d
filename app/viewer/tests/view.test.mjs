// A view that is kept: as a link, a picture, a table; and how the page looks in the dark and on a phone.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, beforeEach, test } from 'node:test';
import { andDraw, distinct, fragment, frames, pixels, pixelsOf } from './browser.mjs';
import { startSamples } from './samples_page.mjs';

let all;
before(async () => (all = await startSamples()));
after(() => all?.stop());
beforeEach(() => all.open());

test('a link opens the same view again', async () => {
  const { page } = all;
  await andDraw(page, () => page.check('input[value=motion]'));
  await andDraw(page, () => page.locator('#frame').fill('7'));
  await andDraw(page, () => page.check('#controls [value=error]'));
  await andDraw(page, () => page.check('#controls [value=solid]'));
  await andDraw(page, () => page.locator('#exaggeration').fill('3'));
  await andDraw(page, () => page.selectOption('#cut_axis', 'x'));
  await andDraw(page, () => page.fill('#node_number', '3').then(() => page.keyboard.press('Enter')));
  await page.locator('#stage canvas').focus();
  for (const key of ['ArrowLeft', 'ArrowLeft', 'ArrowUp', '+']) await page.keyboard.press(key);
  await frames(page);
  const link = await fragment(page);
  const seen = (await Promise.all([0, 1].map((place) => all.side(place)))).flat();
  const said = async () => [await all.page.locator('#now').textContent(), await all.page.locator('#factor').textContent(),
    await all.page.locator('#cut_at').textContent(), await all.page.locator('#node_number').inputValue(), await all.page.locator('#right').inputValue()];
  const before = await said();
  await all.open({}, link);
  assert.deepEqual(await said(), before);
  assert.equal(await fragment(all.page), link);
  const again = (await Promise.all([0, 1].map((place) => all.side(place)))).flat();
  // The camera is kept to a micrometre.
  const different = seen.filter((colour, i) => colour.some((x, k) => Math.abs(x - again[i][k]) > 24)).length;
  assert.ok(different < 0.004 * seen.length, `${different} of ${seen.length} pixels differ`);
});

test('the picture has twice the pixels of the screen', async () => {
  const saved = all.page.waitForEvent('download');
  await all.page.click('#save_picture');
  const download = await saved;
  assert.equal(download.suggestedFilename(), 'box_pull_and_hang.png');
  const png = readFileSync(await download.path());
  assert.equal(png.subarray(1, 4).toString(), 'PNG');
  const { width, height } = await all.page.locator('#stage canvas').boundingBox();
  assert.equal(png.readUInt32BE(16), 2 * Math.round(width));
  assert.ok(png.readUInt32BE(20) > 2 * height, 'title and legend are in it');
  const colours = distinct(await pixelsOf(all.page, png)).size;
  assert.ok(colours > 100, 'the body is in it');
});

test('the table as CSV has the numbers of the file, with all digits', async () => {
  const saved = all.page.waitForEvent('download');
  await all.page.click('#save_table');
  const [head, ...lines] = readFileSync(await (await saved).path(), 'utf8').trim().split('\n').map((line) => line.split(','));
  const springs = Object.fromEntries(lines.find(([model]) => model === 'springs').map((value, i) => [head[i], value]));
  for (const [column, name] of [['relative_l2', 'relative_l2'], ['stiffness_at_tool', 'stiffness_at_tool'], ['max_error_m', 'max_error'], ['energy_error', 'energy_error']])
    assert.equal(Number(springs[column]), Number(all.h5py({ path: 'comparisons/springs', attribute: name })));
});

test('marking a node moves nothing below the picture', async () => {
  const { page } = all;
  const before = await page.locator('#compare .table').boundingBox();
  await andDraw(page, () => page.fill('#node_number', '3').then(() => page.keyboard.press('Enter')));
  assert.deepEqual(await page.locator('#compare .table').boundingBox(), before);
  const card = await page.locator('#node').boundingBox();
  assert.ok(card.y < before.y, 'and what it says is beside the picture');
});

test('on a phone all errors are read without scrolling sideways', async () => {
  await all.page.setViewportSize({ width: 400, height: 800 });
  await frames(all.page);
  const table = await all.page.locator('#comparison .scroll').evaluate((e) => [e.scrollWidth, e.clientWidth]);
  assert.ok(table[0] <= table[1], String(table));
  assert.ok((await all.page.evaluate(() => document.documentElement.scrollWidth)) <= 400);
  for (const cell of await all.page.locator('#comparison tr[data-model=springs] td:visible').all()) {
    const { x, width } = await cell.boundingBox();
    assert.ok(x >= 0 && x + width <= 400);
  }
  assert.equal(await all.page.getByRole('table').getByRole('row').count(), 1 + (await all.page.locator('#comparison tbody tr').count()));
});

test('the page is dark where the system is, until the switch says otherwise', async () => {
  await all.open({ colorScheme: 'dark' });
  const corner = async () => {
    const { x, y, height } = await all.page.locator('#stage canvas').boundingBox();
    return Math.max(...(await pixels(all.page, { x: x + 6, y: y + height / 2, width: 1, height: 1 }))[0]);
  };
  assert.ok((await corner()) < 80);
  assert.equal(await all.page.locator('#theme').getAttribute('aria-pressed'), 'true');
  await all.page.click('#theme');
  await frames(all.page);
  assert.ok((await corner()) > 180);
  await all.page.reload();
  await all.page.waitForSelector('body[data-state=ready] #stage[data-drawn]');
  await frames(all.page);
  assert.ok((await corner()) > 180, 'and it is remembered');
});
