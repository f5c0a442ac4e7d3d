// Opening files: what is shown is always of one file, whatever is opened, refused or broken off meanwhile.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, beforeEach, test } from 'node:test';
import * as hdf5 from 'h5wasm/node';
import { andDraw, createVisits, frames, inColours, pixels, sampleFolder, shown, startBrowser, startServer } from './browser.mjs';

let samples, server, browser, visits, page;
const file = (name) => join(samples.folder, name);

const python = process.env.PYTHON ?? '/usr/bin/python3';
/** A copy of a sample with changes. */
const variant = (name, changes) =>
  execFileSync(python, [join(import.meta.dirname, 'change_h5py.py'), file('still_result.h5'), file(name)], { input: JSON.stringify(changes) });

before(async () => {
  samples = sampleFolder();
  await hdf5.ready;
  variant('one.h5', { body: 'body_1', scale: 1 });
  variant('two.h5', { body: 'body_2', scale: 2 });
  variant('three.h5', { body: 'body_3', scale: 3 });
  variant('without_field.h5', { body: 'body_5', narrow: 'solutions/fem_p2/displacement' });
  // Not the first of the list, which a page opens whose address names none.
  variant('with_link.h5', { link: ['mesh/points', '/dev/urandom'] });
  variant('without_place.h5', { nan: ['mesh/points', 7, 1] });
  server = await startServer(samples.folder);
  browser = await startBrowser();
  visits = createVisits(browser, server.address, 'body[data-state=ready] #stage[data-drawn]');
});
after(async () => {
  await browser?.close();
  await server?.stop();
  samples?.remove();
});
beforeEach(async () => {
  await visits.open(`#one.h5?${inColours}`); // quicker to draw than tissue and glass
  page = visits.page;
});

const settled = async () => {
  await page.waitForSelector('body[data-state=ready]');
  await frames(page);
};
const title = () => page.locator('#title').textContent();
const message = () => page.locator('#message').textContent();
const node = 20;

/** What the file says at the node [mm]. */
function expectedAt(name, model) {
  const opened = new hdf5.File(file(name), 'r');
  const u = opened.get(`solutions/${model}/displacement`).value;
  opened.close();
  return 1000 * Math.hypot(...u.slice(3 * node, 3 * node + 3));
}

/** Title, list, table of the node and legend are those of one file. */
async function isWholly(name) {
  await settled();
  // The same number as before is no change to a browser.
  const choose = (input, value) => ((input.value = value), input.dispatchEvent(new Event('change')));
  await andDraw(page, () => page.locator('#node_number').evaluate(choose, String(node)));
  await settled();
  assert.equal((await title()).split(':')[0], `body_${{ 'one.h5': 1, 'two.h5': 2, 'three.h5': 3 }[name]}`);
  for (const model of ['fem_p2', 'springs']) {
    const [, moved] = await page.locator(`#node tr[data-model="${model}"] td`).allTextContents();
    const expected = expectedAt(name, model);
    assert.ok(Math.abs(shown(moved) - expected) < 0.006 * expected, `${model}: ${moved}, not ${expected} of ${name}`);
  }
}
const isShownFile = async () => `${{ body_1: 'one', body_2: 'two', body_3: 'three' }[(await title()).split(':')[0]]}.h5`;

test('a file that is refused while another is being opened leaves what was open', async () => {
  let letGo;
  const held = new Promise((done) => (letGo = done)); // a small file would be open before the next is chosen
  await page.route('**/files/two.h5', async (route) => (await held, route.continue()));
  await page.selectOption('#files', 'two.h5');
  await page.setInputFiles('#chosen', { name: 'notes.txt', mimeType: '', buffer: Buffer.from('this is text') });
  await page.waitForFunction(() => document.querySelector('#message').textContent.startsWith('notes.txt'));
  letGo();
  await page.waitForTimeout(300);
  await isWholly('one.h5');
  assert.equal(await page.locator('#files').inputValue(), 'one.h5');
});

test('a file whose reference has a bad field is refused and not drawn afterwards', async () => {
  const drawn = await page.locator('#stage').getAttribute('data-drawn');
  await page.selectOption('#files', 'without_field.h5');
  await page.waitForFunction(() => document.querySelector('#message').textContent.startsWith('without_field.h5'));
  await settled();
  assert.match(await message(), /^without_field\.h5: \/solutions\/fem_p2\/displacement /);
  assert.equal(await page.locator('#stage').getAttribute('data-drawn'), drawn);
  assert.equal(await page.locator('#files').inputValue(), 'one.h5');
  await isWholly('one.h5');
});

test('a file with a link out of it is refused', async () => {
  await page.setInputFiles('#chosen', file('with_link.h5'));
  await page.waitForFunction(() => document.querySelector('#message').textContent.startsWith('with_link.h5'));
  assert.match(await message(), /^with_link\.h5: \/mesh\/points is a link to another place/);
  await isWholly('one.h5');
});

test('ten times a random order of openings, refusals and choices ends with one file wholly', async () => {
  let seed = 20260117;
  const random = (count) => (seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0, Math.floor((seed / 2 ** 32) * count));
  const damaged = readFileSync(file('one.h5')).subarray(0, 3000);
  const actions = [
    () => page.selectOption('#files', ['one.h5', 'two.h5', 'three.h5'][random(3)]),
    () => page.selectOption('#files', ['without_field.h5', 'without_place.h5'][random(2)]),
    () => page.setInputFiles('#chosen', file(['two.h5', 'three.h5'][random(2)])),
    () => page.setInputFiles('#chosen', { name: 'cut.h5', mimeType: '', buffer: damaged }),
    () => page.locator('#controls [name=quantity]').nth(random(3)).check(),
    () => page.selectOption('#right', ['springs', 'fem_p2'][random(2)]),
    () => page.fill('#node_number', String(random(30))).then(() => page.keyboard.press('Enter')),
    () => page.evaluate(() => document.querySelector('#cancel').click()),
  ];
  for (let round = 0; round < 10; round++) {
    for (let step = 0; step < 7; step++) {
      await actions[random(actions.length)]();
      await page.waitForTimeout(random(3) * 40);
    }
    await settled();
    await isWholly(await isShownFile());
  }
});

test('a place that is no number is a sentence that names it', async () => {
  await page.selectOption('#files', 'without_place.h5');
  await page.waitForFunction(() => document.querySelector('#message').textContent.startsWith('without_place.h5'));
  assert.match(await message(), /^without_place\.h5: \/mesh\/points has a place that is no number, of node 7; /);
  await isWholly('one.h5');
});

test('opening says so, keeps the old picture with its title, and can be broken off', async () => {
  let letGo;
  const held = new Promise((done) => (letGo = done));
  await page.route('**/files/two.h5', async (route) => (await held, route.continue()));
  await page.selectOption('#files', 'two.h5');
  await page.waitForSelector('#loading:not([hidden])');
  assert.equal(await page.locator('#loading_name').textContent(), 'Opening two.h5…');
  assert.equal((await title()).split(':')[0], 'body_1');
  await page.click('#cancel');
  assert.equal(await page.locator('#loading').isVisible(), false);
  assert.equal(await page.locator('#files').inputValue(), 'one.h5');
  letGo();
  await page.waitForTimeout(300);
  assert.equal(await page.locator('#message').isVisible(), false);
  await isWholly('one.h5');
  await andDraw(page, () => page.selectOption('#files', 'two.h5'));
  await isWholly('two.h5');
});

test('a model that cannot be read is a sentence, and the controls say what is drawn', async () => {
  await page.selectOption('#files', 'sample_result.h5');
  await page.waitForFunction(() => document.querySelector('#title').textContent.startsWith('box'));
  await settled();
  await andDraw(page, () => page.selectOption('#right', 'unfinished'));
  assert.equal(await page.locator('#right').inputValue(), 'unfinished');
});

test('an address that cannot be read opens the page', async () => {
  for (const hash of ['#%', '#%E0%A4%A', '#?node=x&camera=1,2&cut=q', '#one.h5?left=nobody&right=springs&times=-1&time=none']) {
    await page.goto('about:blank');
    await page.goto(server.address + hash);
    await page.waitForSelector('#stage[data-drawn]');
    await settled();
    assert.equal(await page.locator('#message').isVisible(), false, hash);
  }
  await page.goto('about:blank');
  await page.goto(`${server.address}#gone.h5`);
  await page.waitForSelector('#stage[data-drawn]');
  await settled();
  assert.match(await message(), /^gone\.h5 is not in the list; .* is shown\./);
});

test('a picture that the graphics card drops says so, and comes back', async () => {
  await page.evaluate(() => {
    window.context = document.querySelector('#stage canvas').getContext('webgl2').getExtension('WEBGL_lose_context');
    window.context.loseContext();
  });
  await page.waitForSelector('#stage .lost:not([hidden])');
  assert.match(await page.locator('#stage .lost').textContent(), /dropped the picture/);
  await page.evaluate(() => window.context.restoreContext());
  await page.waitForSelector('#stage .lost', { state: 'hidden' });
  await frames(page);
  const { x, y, width, height } = await page.locator('#stage canvas').boundingBox();
  const colours = await pixels(page, { x: x + width / 4 - 20, y: y + (height + 68) / 2 - 20, width: 40, height: 40 });
  const [stage] = await pixels(page, { x: x + width / 4, y: y + height - 8, width: 1, height: 1 });
  assert.ok(colours.some((colour) => String(colour) !== String(stage)), 'the body is there again');
});
