// The named parts of the surface in colours, against what h5py reads from the same file.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, beforeEach, test } from 'node:test';
import { andDraw, distinct, frames, pixelsOf } from './browser.mjs';
import { startSamples } from './samples_page.mjs';

const path = 'mesh/boundary_patch';
let all, names;
before(async () => {
  all = await startSamples();
  names = all.h5py({ path, attribute: 'names' });
});
after(() => all?.stop());
beforeEach(async () => {
  await all.open();
  await andDraw(all.page, () => all.page.locator('#exaggeration').fill('0'));
  await andDraw(all.page, () => all.page.uncheck('[name=conditions]'));
  await andDraw(all.page, () => all.page.check('#controls [value=patches]'));
});

const entries = () => all.page.locator('#legend .patches li').evaluateAll((lines) => lines.map((line) => ({
  text: line.textContent, colour: getComputedStyle(line.firstChild).backgroundColor.match(/\d+/g).map(Number) })));
const isOf = (colour) => (pixel) => pixel.every((x, i) => Math.abs(x - colour[i]) < 4);
const spoken = (name) => name.replaceAll('_', ' ');

test('the legend has the names and areas of the file, each with a colour of its own', async () => {
  const points = all.h5py({ path: 'mesh/points', row: null });
  const triangles = all.h5py({ path: 'mesh/boundary_triangles', row: null });
  const patch = all.h5py({ path, row: null });
  const area = ([a, b, c]) => {
    const [u, v] = [b, c].map((corner) => points[corner].map((x, i) => x - points[a][i]));
    return Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2;
  };
  const of = [...names].sort();
  const areas = of.map((name) => triangles.filter((_, t) => names[patch[t]] === name).reduce((sum, t) => sum + area(t), 0));
  const shown = await entries();
  assert.ok(of.length > 1);
  assert.deepEqual(shown.map((entry) => entry.text), of.map((name, i) => `${spoken(name)}, ${(1e4 * areas[i]).toFixed(0)} cm²`));
  assert.equal(new Set(shown.map((entry) => String(entry.colour))).size, of.length);
  assert.match(await all.page.locator('#legend').textContent(), new RegExp(`confidence of ${Number(all.h5py({ path, attribute: 'confidence' })).toFixed(2)}`));
});

test('each side of the box has the colour that the legend gives to its name', async () => {
  const of = Object.fromEntries((await entries()).map(({ text, colour }) => [text.split(',')[0], colour]));
  const view = async () => {
    await frames(all.page);
    const pixels = await all.side();
    return Object.fromEntries(Object.entries(of).map(([name, colour]) => [name, pixels.filter(isOf(colour)).length]));
  };
  const front = await view();
  assert.ok(front['y min'] > 2000, JSON.stringify(front));
  for (const hidden of ['y max', 'z min']) assert.equal(front[hidden], 0);
  await all.page.locator('#stage canvas').focus();
  for (let i = 0; i < 10; i++) await all.page.keyboard.press('ArrowUp');
  const above = await view();
  assert.ok(above['z max'] > 2000, JSON.stringify(above));
  assert.equal(above['y max'], 0);
});

test('what is inside has no patch', async () => {
  await andDraw(all.page, () => all.page.selectOption('#cut_axis', 'z'));
  await all.page.locator('#stage canvas').focus();
  for (let i = 0; i < 10; i++) await all.page.keyboard.press('ArrowUp');
  await frames(all.page);
  const pixels = await all.side();
  const top = (await entries()).find((entry) => entry.text.startsWith('z max')).colour;
  assert.equal(pixels.filter(isOf(top)).length, 0, 'the top is cut away');
  assert.ok(pixels.filter(isOf([150, 150, 150])).length > 1000, 'the face is grey');
});

test('a file without a confidence shows its patches all the same', async () => {
  all.variant('sample_result.h5', 'named.h5', { unname: [path, 'confidence'] });
  await all.open({}, '#named.h5?colours=patches');
  assert.equal((await entries()).length, names.length);
  assert.ok(!(await all.page.locator('#legend').textContent()).includes('confidence'));
  assert.ok(await all.page.isChecked('#controls [value=patches]'), 'as the link says');
});

test('the saved picture has the names', async () => {
  const saved = all.page.waitForEvent('download');
  await all.page.click('#save_picture');
  const png = readFileSync(await (await saved).path());
  const colours = distinct(await pixelsOf(all.page, png, 120)); // the legend
  for (const { text, colour } of await entries()) assert.ok(colours.has(String(colour)), text);
});
