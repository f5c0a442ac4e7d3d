// What the live page draws and says: colours that follow, an arrow with a scale, values at a node, springs beside finite elements.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { frames, pixels } from '../browser.mjs';
import { startLivePage } from './live_page.mjs';

let site, server, live;

before(async () => {
  site = await startLivePage();
  ({ server, live } = site);
});
after(() => site?.stop());

const legendEnd = async () => Number(await live.page.locator('#live-legend .numbers').getAttribute('data-end'));
const canvasBox = () => live.page.locator('#live-stage canvas').boundingBox();
const picture = async () => {
  await frames(live.page);
  return pixels(live.page, await canvasBox());
};
const background = [243, 241, 237];
const isNear = (a, b, by = 6) => a.every((x, i) => Math.abs(x - b[i]) <= by);
/** That of the arrow; the axis that points to the left is of another red. */
const red = (colour) => isNear(colour, [0xd6, 0x28, 0x1f], 16);

test('Live opens with a liver that looks like one and a probe beside it, and what one reads and sets is in sight', async () => {
  for (const viewport of [{ width: 1440, height: 900 }, { width: 400, height: 800 }]) {
    await live.open({ viewport });
    await live.page.check('#mode [value=live]', { force: true });
    await live.moving();
    await live.rests();
    assert.equal(await live.page.locator('[name=live-skin]:checked').getAttribute('value'), 'translucent');
    assert.equal(await live.page.locator('[name=live-shown]:checked').getAttribute('value'), 'tissue');
    assert.match(await live.page.locator('#live-legend').textContent(), /^liver6 lesions, \S+ mL$/);
    const body = (await picture()).filter((colour) => !isNear(colour, background, 14));
    const tissue = ([r, g, b]) => r > g + 25 && r > b + 25;
    const shades = new Set(body.filter(tissue).map(([r]) => r >> 2));
    assert.ok(shades.size > 5, `${shades.size} shades`);
    const steel = body.filter(([r, g, b]) => Math.max(r, g, b) - Math.min(r, g, b) < 45 && g > 70);
    assert.ok(steel.length > 200, `${steel.length} pixels of the probe`);
    const bottom = async (id) => ((box) => box.y + box.height)(await live.page.locator(id).boundingBox());
    const inSight = viewport.width > 1000 ? ['#live-force', '#live-cut', '#live-colours [name=live-shown]:checked', '#live-legend', '#live-skin'] : ['#live-force'];
    for (const id of inSight) assert.ok((await bottom(id)) <= viewport.height, `${id} at ${viewport.width}`);
    assert.ok((await bottom('#live-stage')) <= viewport.height, `the stage at ${viewport.width}`);
    assert.ok((await live.page.evaluate(() => document.documentElement.scrollWidth)) <= viewport.width);
  }
});

test('exact colours: a body at rest has the first colour of the legend and no other', async () => {
  await live.goLive({});
  await live.rests();
  const { width, height } = await canvasBox();
  const aboveAxes = Math.round(width) * (Math.round(height) - 54);
  const body = (await picture()).slice(0, aboveAxes).filter((colour) => !isNear(colour, background, 14));
  const first = body.filter((colour) => isNear(colour, [0x44, 0x01, 0x54]));
  assert.ok(first.length > 5000);
  // What is left are letters, and edges against the background.
  assert.ok(first.length > 0.9 * body.length, `${first.length} of ${body.length}`);
  await live.page.check('#live-translucent', { force: true });
  const glass = (await picture()).filter((colour) => isNear(colour, [0x44, 0x01, 0x54]));
  assert.ok(glass.length < 0.5 * first.length);
});

test('the colours follow what is there now, down again too, and stay where they are put by hand', async () => {
  await live.goLive();
  await live.set('alpha', '60');
  await live.page.locator('#live-depth').fill('20');
  await live.poke();
  await live.page.waitForFunction(() => Number(document.querySelector('#live-legend .numbers').dataset.end) >= 8);
  await live.page.locator('#live-depth').fill('2');
  await live.page.waitForFunction(() => Number(document.querySelector('#live-legend .numbers').dataset.end) <= 4);
  // By hand.
  await live.page.locator('#live-legend-end').fill('27');
  await live.page.locator('#live-legend-end').press('Tab');
  assert.equal(await live.page.locator('#live-legend-follows').isChecked(), false);
  assert.equal(await legendEnd(), 27);
  await live.page.locator('#live-depth').fill('4');
  await live.rests();
  assert.equal(await legendEnd(), 27);
  await live.page.locator('#live-legend-end').fill('0.2');
  await live.page.locator('#live-legend-end').press('Tab');
  assert.match(await live.page.locator('#live-legend .numbers span').last().textContent(), /^≥ 0\.2$/);
  await live.page.check('#live-legend-follows');
  assert.ok((await legendEnd()) > 0.2);
});

test('the arrow of the force is seen from where the camera is at first, and a scale says how long it is', async () => {
  await live.goLive();
  await live.set('alpha', '60');
  await live.page.locator('#live-node').focus();
  await live.page.keyboard.press('Enter');
  await live.above('indentation', 0.002);
  await live.rests();
  const { width } = await canvasBox();
  const all = await picture();
  const key = await live.page.locator('#live-arrow-key').boundingBox();
  const { x, y } = await canvasBox();
  const isKey = (i) => i % Math.round(width) >= key.x - x - 4 && Math.floor(i / Math.round(width)) >= key.y - y - 4;
  const places = all.flatMap((colour, i) => (red(colour) && !isKey(i) ? [[i % Math.round(width), Math.floor(i / Math.round(width))]] : []));
  const extent = (axis) => Math.max(...places.map((p) => p[axis])) - Math.min(...places.map((p) => p[axis]));
  const drawn = Math.hypot(extent(0), extent(1));
  assert.ok(drawn > 40, `the arrow is ${drawn} pixels long`);
  const [newtons, pixelsOfKey] = await live.page.locator('#live-arrow-key').evaluate((e) => [Number(e.dataset.newtons), Number(e.dataset.pixels)]);
  assert.equal(await live.text('arrow-key'), `${newtons} N`);
  assert.ok(Math.abs(key.width - pixelsOfKey) < 60 && pixelsOfKey > 20);
  // Turned out of the plane of the screen it is shorter than the scale says, never longer, but for its head and the perspective.
  const whole = ((await live.value('force')) * pixelsOfKey) / newtons;
  assert.ok(drawn < 1.3 * whole + 25 && drawn > 0.3 * whole, `${drawn} pixels of ${whole}`);
  // Nearer, all of it is longer.
  await live.page.locator('#live-stage canvas').focus();
  for (let i = 0; i < 3; i++) await live.page.keyboard.press('+');
  await frames(live.page);
  const perNewton = await live.page.locator('#live-arrow-key').evaluate((e) => Number(e.dataset.pixels) / Number(e.dataset.newtons));
  assert.ok(perNewton > 1.15 * (pixelsOfKey / newtons));
});

test('a click says what springs and FEM are at a node, and how far they are apart there', async () => {
  await live.goLive();
  await live.set('alpha', '60');
  await live.page.check('#live-fem');
  await live.poke();
  await live.isJudged();
  const [springs, elements, off, strain] = await Promise.all(['springs', 'elements', 'off', 'strain'].map((name) => live.value(`at-${name}`)));
  assert.ok(springs > 0.001 && elements > 0.0005 && strain > 0.001);
  assert.ok(off >= Math.abs(springs - elements) && off <= springs + elements);
  assert.match(await live.text('at-name'), /^Node \d+, at rest at \([−\d., ]+\) mm$/);
  // Beside the body it says nothing.
  const { x, y } = await canvasBox();
  await live.page.mouse.click(x + 20, y + 130);
  assert.equal(await live.isShown('at-node'), false);
});

test('the map of the difference to FEM has its own colours, and is there only with FEM', async () => {
  await live.goLive();
  await live.set('alpha', '60');
  assert.equal(await live.page.locator('[name=live-shown][value=difference]').isDisabled(), true);
  await live.page.check('#live-fem');
  await live.poke();
  await live.isJudged();
  const displacement = await picture();
  const largest = await legendEnd();
  await live.page.check('[name=live-shown][value=difference]');
  assert.match(await live.page.locator('#live-legend .what').textContent(), /beside FEM \[mm\]/);
  // At this node the map says at least as much as its reading.
  assert.ok((await legendEnd()) >= 1000 * (await live.value('at-off')) * 0.999 && (await legendEnd()) < largest);
  const difference = await picture();
  assert.ok(difference.filter((colour, i) => !isNear(colour, displacement[i], 20)).length > 5000);
  await live.page.uncheck('#live-fem');
  assert.match(await live.page.locator('#live-legend .what').textContent(), /^Displacement \[mm\]/);
});

test('the strain is a field of its own, in per cent', async () => {
  await live.goLive();
  await live.set('alpha', '60');
  await live.poke();
  await live.rests();
  await live.page.check('[name=live-shown][value=strain]');
  assert.match(await live.page.locator('#live-legend .what').textContent(), /strain \[%\]/);
  assert.ok((await legendEnd()) >= 100 * (await live.value('at-strain')) * 0.999);
});

/** A server of finite elements that says what it is told to. */
const pretend = (answer) =>
  live.page.routeWebSocket(/\/live\/fem/, (socket) => socket.onMessage((message) => (typeof message === 'string' ? socket.send('chosen=fem_p2') : answer(socket))));

test('what FEM waits for is said where its picture waits', async () => {
  await live.goLive({});
  await pretend((socket) => socket.send(new URLSearchParams({ progress: 'The factor is being computed: 40 %.' }).toString()));
  await live.page.check('#live-fem');
  await live.poke();
  await live.page.waitForFunction(() => document.querySelector('#live-fem-progress').textContent !== '');
  assert.equal(await live.text('fem-progress'), 'The factor is being computed: 40 %.');
  await live.page.uncheck('#live-fem');
  assert.equal(await live.text('fem-progress'), '');
});

test('a socket that the server closes says why', async () => {
  await live.goLive({});
  await pretend((socket) => socket.close({ code: 1013, reason: 'Too many pages have a session already; close one of them.' }));
  await live.page.check('#live-fem');
  await live.poke();
  await live.page.waitForSelector('#message:not([hidden])');
  assert.match(await live.page.locator('#message').textContent(), /Too many pages have a session already/);
  assert.equal(await live.page.isChecked('#live-fem'), false);
});
