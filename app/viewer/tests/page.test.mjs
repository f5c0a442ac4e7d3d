// The page as its readers use it, against what h5py reads from the same file.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, beforeEach, test } from 'node:test';
import { andDraw, builtPage, createVisits, frames, inColours, pixels, sampleFolder, shown, startBrowser, startServer } from './browser.mjs';

let samples, server, browser, visits, page;

before(async () => {
  samples = sampleFolder();
  server = await startServer(samples.folder);
  browser = await startBrowser();
  visits = createVisits(browser, server.address, 'body[data-state=ready] #stage[data-drawn]');
});
after(async () => {
  await browser?.close();
  await server?.stop();
  samples?.remove();
});

async function openPage(options = {}, view = inColours) {
  await visits.open(`#sample_result.h5?${view}`, options);
  page = visits.page;
}
beforeEach(() => openPage());

const length = (vector) => Math.hypot(...vector);
const python = process.env.PYTHON ?? '/usr/bin/python3';
const h5py = (question) =>
  JSON.parse(execFileSync(python, [join(import.meta.dirname, 'ask_h5py.py'), join(samples.folder, 'sample_result.h5')], { input: JSON.stringify(question) }));
const row = (path, index) => h5py({ path, row: index });
const attribute = (path, name) => Number(h5py({ path, attribute: name }));
const about = (actual, expected) => assert.ok(Math.abs(actual - expected) <= 0.006 * Math.abs(expected), `${actual}, not ${expected}`);
const cells = (model, place) => page.locator(`${place} tr[data-model="${model}"] td`).allTextContents();
const message = () => page.locator('#message').textContent();
const canvasBox = () => page.locator('#stage canvas').boundingBox();
/** A small piece of the middle of each side. */
async function middles() {
  const { x, y, width, height } = await canvasBox();
  const part = { width: 120, height: 120, y: y + (height + 68 - 54) / 2 - 60 }; // between what stands above and below
  return Promise.all([0.25, 0.75].map((place) => pixels(page, { ...part, x: x + place * width - 60 })));
}

test('the list has what the page can show, at any depth', async () => {
  const names = await page.locator('#files option').evaluateAll((options) => options.map((o) => o.value));
  assert.deepEqual(names, ['path_result.h5', 'sample_experiment.h5', 'sample_result.h5', 'small_result.h5', 'still_result.h5', 'with_jaws_result.h5']);
});

test('the table shows the numbers of the file', async () => {
  const [, , error, stiffness, largest, energy] = await cells('springs', '#comparison');
  about(shown(error), 100 * attribute('comparisons/springs', 'relative_l2'));
  about(shown(stiffness.replace(' !', '')), 100 * attribute('comparisons/springs', 'stiffness_at_tool'));
  assert.match(stiffness, / !$/, 'fingers feel it');
  about(shown(largest), 1000 * attribute('comparisons/springs', 'max_error'));
  about(shown(energy), 100 * attribute('comparisons/springs', 'energy_error'));
});

test('both sides have the colours of one legend, which ends just above the largest displacement', async () => {
  const u = (model) => h5py({ path: `solutions/${model}/displacement`, row: null }).flat();
  const largest = (values) => Math.max(...Array.from({ length: values.length / 3 }, (_, i) => length(values.slice(3 * i, 3 * i + 3))));
  const end = Number(await page.locator('#legend .numbers').getAttribute('data-end-mm'));
  const expected = 1000 * Math.max(largest(u('fem_p2')), largest(u('springs')));
  assert.ok(end >= expected && end < 1.4 * expected, `${end} mm for ${expected} mm`);
});

test('a click marks a node and shows what each model says there', async () => {
  const { x, y, width, height } = await canvasBox();
  await andDraw(page, () => page.mouse.click(x + width / 4, y + (height + 68) / 2));
  const node = Number(await page.locator('#node_number').inputValue());
  const place = row('mesh/points', node).map((metres) => 1000 * metres);
  const text = await page.locator('#node .hint').first().textContent();
  text.match(/\((.*)\)/)[1].split(', ').forEach((number, i) => assert.ok(Math.abs(shown(number) - place[i]) < 0.5));
  assert.ok(place[1] < 1, 'seen from the front, the front was clicked');
  for (const model of ['fem_p2', 'springs']) {
    const [, moved, error] = await cells(model, '#node');
    about(shown(moved), 1000 * length(row(`solutions/${model}/displacement`, node)));
    if (model === 'springs') about(shown(error), 1000 * length(row(`comparisons/${model}/error`, node)));
  }
});

test('the time slider shows the frames of the motion', async () => {
  await andDraw(page, () => page.locator('#node_number').fill('3').then(() => page.keyboard.press('Enter')));
  await andDraw(page, () => page.check('input[value=motion]'));
  await andDraw(page, () => page.locator('#frame').fill('7'));
  assert.equal(await page.locator('#now').textContent(), '0.140 s');
  const numNodes = h5py({ path: 'mesh/points', row: null }).length;
  const [, moved, error] = await cells('springs', '#node');
  about(shown(moved), 1000 * length(row('solutions/springs/history/frames', 7 * numNodes + 3)));
  about(shown(error), 1000 * length(row('comparisons/springs/error_frames', 7 * numNodes + 3)));
  assert.deepEqual(await page.locator('#motion .key span').allTextContents(), ['fem_p2', 'springs']);
});

test('a liver looks like one at first, in glass, with a sentence on what is shown', async () => {
  await openPage({}, '');
  for (const value of ['tissue', 'translucent']) assert.ok(await page.locator(`#controls [value=${value}]`).isChecked(), value);
  assert.match(await page.locator('#legend').textContent(), /^liver/);
  const said = await page.locator('#verdict').textContent();
  const [, off, felt] = said.match(/^springs is (\S+) % off in position and (\S+) % too (?:stiff|soft) under the tool, which a hand feels \(above 7 %\); judged by hyperelastic finite elements, fem_p2\.$/) ?? [said];
  assert.ok(Math.abs(off - 100 * attribute('comparisons/springs', 'relative_l2')) < 0.06 * off, said);
  assert.ok(Math.abs(felt - Math.abs(100 * attribute('comparisons/springs', 'stiffness_at_tool'))) < 0.06 * felt, said);
  const [left] = await middles();
  const red = left.filter(([r, g, b]) => r > 1.15 * g && r > 1.15 * b).length;
  assert.ok(red > 0.5 * left.length, `${red} of ${left.length} pixels are red`);
});

test('colours of a quantity are those of the legend, exactly', async () => {
  await openPage({}, '');
  await andDraw(page, () => page.uncheck('[name=conditions]'));
  await andDraw(page, () => page.selectOption('#right', 'unfinished'));
  await andDraw(page, () => page.check('input[value=error]'));
  const [left, right] = await middles();
  assert.equal(await page.locator('#controls [value=flat]').isChecked(), true);
  // Errors are measured from the reference, and nobody has compared the other one.
  assert.match(await page.locator('#stage .first p').textContent(), /from which errors are measured/);
  assert.ok(left.every((colour) => String(colour) === '150,150,150'), String(left[0]));
  assert.ok(right.every((colour) => String(colour) === '150,150,150'), String(right[0]));
});

test('keys turn both sides together', async () => {
  await andDraw(page, () => page.selectOption('#right', 'fem_p2'));
  await andDraw(page, () => page.check('input[value=solid]'));
  const [left, right] = await middles();
  assert.deepEqual(left, right);
  await page.locator('#stage canvas').focus();
  for (let i = 0; i < 4; i++) await page.keyboard.press('ArrowLeft');
  await frames(page);
  const [turnedLeft, turnedRight] = await middles();
  assert.deepEqual(turnedLeft, turnedRight);
  assert.notDeepEqual(turnedLeft, left);
});

test('a model that diverged says so and does not spoil the legend', async () => {
  await andDraw(page, () => page.selectOption('#right', 'blown_up'));
  assert.match(await page.locator('#stage .second p').textContent(), /diverged: a node left the room/);
  assert.ok(Number(await page.locator('#legend .numbers').getAttribute('data-end-mm')) < 10);
  assert.match(await page.locator('#legend').textContent(), /≥/);
});

test('a file that cannot be shown is a sentence, and what was open stays', async () => {
  const whole = readFileSync(join(samples.folder, 'sample_result.h5'));
  const faults = [
    ['notes.txt', Buffer.from('this is text'), /^notes\.txt: It is not an HDF5 file\./],
    ['empty.h5', Buffer.alloc(0), /^empty\.h5: It is empty\./],
    ['half.h5', whole.subarray(0, whole.length / 2), /^half\.h5: It is cut off or damaged\./],
    ['other.h5', readFileSync(join(samples.folder, 'sample_stability.h5')), /^other\.h5: .*time steps \(livermark stability\)/],
  ];
  for (const [name, buffer, sentence] of faults) {
    await page.setInputFiles('#chosen', { name, mimeType: '', buffer });
    await page.waitForFunction((start) => document.querySelector('#message').textContent.startsWith(start), name);
    assert.match(await message(), sentence);
  }
  assert.match(await page.locator('#title').textContent(), /^box/);
  await andDraw(page, () => page.check('input[value=error]'));
  await andDraw(page, () => page.setInputFiles('#chosen', join(samples.folder, 'small_result.h5')));
  assert.equal(await page.locator('#message').isVisible(), false);
});

test('damaged bytes are a sentence or other numbers, never a page that hangs', async () => {
  const whole = readFileSync(join(samples.folder, 'small_result.h5'));
  for (let i = 1; i <= 12; i++) {
    const buffer = Buffer.from(whole);
    buffer[Math.floor((i * whole.length) / 13)] ^= 0xff;
    await page.locator('#stage').evaluate((stage) => delete stage.dataset.drawn);
    await page.evaluate(() => (document.querySelector('#message').hidden = true));
    await page.setInputFiles('#chosen', { name: 'damaged.h5', mimeType: '', buffer });
    await page.waitForFunction(() => document.querySelector('#stage').dataset.drawn || !document.querySelector('#message').hidden);
  }
});

test('a narrow window has the sides one below the other and scrolls downwards only', async () => {
  await page.setViewportSize({ width: 360, height: 740 });
  await page.waitForSelector('#stage[data-arrangement=below]');
  assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 360);
});

test('a dense screen is drawn with all its pixels', async () => {
  await openPage({ deviceScaleFactor: 2 });
  const { drawn, laidOut } = await page.locator('#stage canvas').evaluate((c) => ({ drawn: c.width, laidOut: c.clientWidth }));
  assert.equal(drawn, 2 * laidOut);
});

test('the page opens files without a server', async () => {
  await page.goto(`file://${builtPage}`);
  assert.equal(await page.locator('#welcome').isVisible(), true);
  await andDraw(page, () => page.setInputFiles('#chosen', join(samples.folder, 'sample_result.h5')));
  assert.match(await page.locator('#title').textContent(), /^box/);
});
