// The live page as its readers use it: mouse, finger and keys on a liver with tumours. Machines that run tests are slow and
// draw in software, so nothing here asks how fast it goes.
import assert from 'node:assert/strict';
import { copyFileSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import * as hdf5 from 'h5wasm/node';
import { builtPage, shippedFolder, startBrowser, startServer } from './browser.mjs';
import { bodyOf, frameOf, noReplay, playNatively } from './springs.mjs';

let shipped, server, browser, page;
const file = 'liver_tumours/palpation.h5';
const loose = 'liver_tumours/loose.h5'; // constrained nowhere

before(async () => {
  shipped = shippedFolder('liver_tumours');
  copyFileSync(join(shipped.folder, file), join(shipped.folder, loose));
  await hdf5.ready;
  const copy = new hdf5.File(join(shipped.folder, loose), 'a');
  const condition = copy.get('load_case/condition');
  condition.write_slice([[]], new Uint8Array(condition.shape[0]));
  copy.close();
  server = await startServer(shipped.folder);
  browser = await startBrowser();
});
after(async () => {
  await browser?.close();
  await server?.stop();
  shipped?.remove();
});

const value = async (name) => Number(await page.locator(`#live-${name}`).getAttribute('data-value'));
/** Waits until a reading is above a value, or below it. */
const above = (name, least) =>
  page.waitForFunction(([id, least]) => Number(document.querySelector(id).dataset.value) > least, [`#live-${name}`, least]);
const below = (name, most) =>
  page.waitForFunction(([id, most]) => Number(document.querySelector(id).dataset.value) < most, [`#live-${name}`, most]);
const message = () => page.locator('#message').textContent();

const moving = () => page.waitForSelector('#live[data-state=moving]');

async function openPage(options = {}, address = `${server.address}#${encodeURIComponent(file)}`) {
  await page?.context().close();
  page = await (await browser.newContext({ viewport: { width: 1200, height: 850 }, ...options })).newPage();
  page.setDefaultTimeout(60000);
  await page.goto(address);
}

/** The body at rest, on a new page if there are options for one. */
async function goLive(options) {
  if (!options && (await backToRest())) return;
  await openPage(options);
  await page.waitForSelector('#stage[data-drawn]');
  await page.check('#mode [value=live]', { force: true });
  await moving();
  // Quicker to be had than the law that the page begins with.
  await set('law', 'van_gelder');
}

/** What the page of the test before has become. @return whether it can go on */
async function backToRest() {
  if (!(await page?.locator('#live[data-state=moving]').isVisible())) return false;
  if ((await page.locator('#live-pause').textContent()).includes('Go on')) await page.click('#live-pause');
  await page.uncheck('#live-stays');
  await page.check('[name=tool][value=probe]');
  await page.click('#live-reset');
  await page.waitForFunction(() => Math.abs(Number(document.querySelector('#live-volume').dataset.value) - 1) < 1e-4);
  return true;
}

/** Changes a setting, and waits until the springs have it. */
async function set(name, text) {
  const field = page.locator(`#live-${name}`);
  await page.locator('#live').evaluate((live) => (live.dataset.state = 'choosing'));
  if (name === 'law') await field.selectOption(text);
  else await field.fill(text).then(() => field.press('Tab'));
  await page.waitForFunction(() => document.querySelector('#live').dataset.state !== 'choosing');
}

/** The middle of the right lobe. */
async function place() {
  const canvas = page.locator('#live-stage canvas');
  await canvas.scrollIntoViewIfNeeded();
  const { x, y, width, height } = await canvas.boundingBox();
  return [x + width / 2 - 0.15 * Math.min(width, height), y + 0.55 * height];
}

async function press() {
  await page.mouse.move(...(await place()));
  await page.mouse.down();
}
/** Touches it with a tool that stays there. */
async function poke() {
  await page.check('#live-stays');
  await press();
  await page.mouse.up();
  await above('indentation', 0.001);
}

/** Waits until the last answer of a body that pauses is there. */
const still = () =>
  page.waitForFunction(() => new Promise((done) => {
    const time = document.querySelector('#live-time').dataset.value;
    setTimeout(() => done(time === document.querySelector('#live-time').dataset.value), 700);
  }));

/** Pauses. @return what was done, as rows of the file that is saved */
async function saved() {
  await page.click('#live-pause');
  await still();
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#live-save')]);
  const [head, ...lines] = readFileSync(await download.path(), 'utf8').trimEnd().split('\n').map((line) => line.split(','));
  return { head, rows: lines.map((line) => Object.fromEntries(line.map((text, i) => [head[i], text]))) };
}

test('pressing on the body is answered by a force, and letting go ends it', async () => {
  await goLive();
  await press();
  await above('indentation', 0.001);
  const shallow = await value('force');
  assert.ok(shallow > 0);
  for (let i = 0; i < 8; i++) await page.mouse.wheel(0, -100);
  await above('force', 1.2 * shallow);
  assert.ok((await value('depth-shown')) > 0.008);
  assert.ok((await value('volume')) < 1);
  await page.mouse.up();
  await below('force', 1e-12);
});

test('what was done is saved step by step, with the numbers of the page', async () => {
  await goLive({});
  await poke();
  await set('nu', '0.3');
  await above('indentation', 0.001);
  const { head, rows } = await saved();
  assert.equal(head.join(), 'kind,num_steps,tool,target_x,target_y,target_z,radius,node,law,keeps_volume,young_modulus,poisson_ratio,mass_damping,stiffness_damping,time_step,time,force_x,force_y,force_z,indentation,smallest_volume,disc_x,disc_y,disc_z,entry_x,entry_y,entry_z,depth,diameter,toughness,friction,puncture_force,tip,target_moved,region,margin,keeps_margin,thickness,takes_loose,volume,margin_left,corner_0_x,corner_0_y,corner_0_z,corner_1_x,corner_1_y,corner_1_z,corner_2_x,corner_2_y,corner_2_z,corner_3_x,corner_3_y,corner_3_z');
  const chosen = rows.filter((row) => row.kind === 'choose');
  assert.deepEqual(chosen.map((row) => [row.law, row.poisson_ratio]), [['nodal_neo_hookean', '0.45'], ['van_gelder', '0.45'], ['van_gelder', '0.3']]);
  assert.ok(chosen.every((row) => Number(row.time_step) > 0));
  // Steps add up to the time, through all that was chosen.
  let [time, step] = [0, 0];
  for (const row of rows) {
    if (row.kind === 'choose') step = Number(row.time_step);
    else time += Number(row.num_steps) * step;
  }
  const last = rows.at(-1);
  assert.ok(Math.abs(time - Number(last.time)) < 1e-9 * time, `${time} s, not ${last.time} s`);
  const force = Math.hypot(Number(last.force_x), Number(last.force_y), Number(last.force_z));
  assert.equal(force, await value('force'));
  for (const name of ['time', 'indentation']) assert.equal(Number(last[name]), await value(name));
  assert.equal(Number(last.smallest_volume), await value('volume'));
  assert.equal(last.tool, 'probe');
});

/** Rows of a saved file as questions to the springs. */
const asked = (row) => {
  const number = (name) => Number(row[name]);
  if (['reset', 'keep', 'undo'].includes(row.kind)) return { kind: row.kind };
  if (row.kind === 'choose') {
    const settings = {
      springLaw: row.law, keepsVolume: row.keeps_volume === '1', youngModulus: number('young_modulus'), poissonRatio: number('poisson_ratio'),
      massDamping: number('mass_damping'), stiffnessDamping: number('stiffness_damping'), timeStep: number('time_step'),
    };
    return { kind: 'choose', settings };
  }
  const target = [number('target_x'), number('target_y'), number('target_z')];
  const tool = row.tool === 'none' ? { kind: 'none' } : { kind: row.tool, target, radius: number('radius'), node: number('node') };
  return { kind: 'move', tool, numSteps: number('num_steps') };
};

const onlyThere = { skip: noReplay };
test('what was done on the page is done again natively, with the same force and indentation to the last bit', onlyThere, async () => {
  await goLive();
  await poke();
  await page.check('[name=tool][value=pull]');
  await press();
  await page.mouse.move(...(await place()).map((at) => at - 50), { steps: 3 });
  await above('force', 0.01);
  await page.mouse.up();
  const { rows } = await saved();
  const laws = await page.locator('#live-law option').evaluateAll((options) => options.map((option) => option.value));
  const answers = playNatively(await bodyOf(join(shipped.folder, file)), rows.map(asked), laws);
  const moves = rows.flatMap((row, i) => (row.kind === 'move' ? [[row, frameOf(answers[i])]] : []));
  assert.ok(moves.some(([row]) => row.tool === 'probe') && moves.some(([row]) => row.tool === 'pull'));
  for (const [row, frame] of moves) {
    const onPage = ['time', 'force_x', 'force_y', 'force_z', 'indentation', 'smallest_volume'].map((name) => Number(row[name]));
    // Text knows no negative zero.
    assert.deepEqual(onPage, [frame.time, ...frame.force, frame.indentation, frame.smallestVolume].map((x) => x + 0));
  }
});

test('settings change while it moves, and what cannot be is a sentence that changes nothing', async () => {
  await goLive();
  await poke();
  const before = await value('time');
  await set('nu', '0.2');
  assert.equal(await message(), '');
  await above('time', before);
  assert.ok((await value('indentation')) > 0);
  await set('step-length', '50');
  assert.match(await message(), /a time step of 0\.05 s is too long/);
  assert.equal(await page.locator('#live-step-length').inputValue(), '0');
  await set('nu', '0.3');
  assert.equal(await message(), '');
  await page.locator('#live-nu').fill('0.5');
  await page.locator('#live-nu').press('Tab');
  assert.match(await message(), /^Poisson’s ratio has to be from 0 to 0\.49/);
  assert.equal(await page.locator('#live-nu').inputValue(), '0.3');
  await above('time', await value('time'));
});

test('a patch is pulled to where the mouse leads it', async () => {
  await goLive();
  await page.check('[name=tool][value=pull]');
  const [x, y] = await place();
  await page.mouse.move(x, y);
  await page.mouse.down();
  await above('time', await value('time'));
  await page.mouse.move(x - 20, y - 60, { steps: 4 });
  await above('indentation', 0.003);
  await page.mouse.up();
  const { rows } = await saved();
  const pulled = rows.filter((row) => row.tool === 'pull');
  const [first, last] = [pulled[0], pulled.at(-1)];
  assert.ok(Number(last.target_z) > Number(first.target_z), 'the mouse went up');
  assert.ok(pulled.every((row) => row.node === first.node));
});

test('keys alone touch, push in, lead along and let go', async () => {
  await goLive();
  await page.locator('#live-node').focus();
  await page.keyboard.press('Enter');
  await above('indentation', 0.001);
  const shallow = await value('force');
  await page.locator('#live-stage canvas').focus();
  for (let i = 0; i < 4; i++) await page.keyboard.press('PageDown');
  await above('force', 1.2 * shallow);
  for (let i = 0; i < 3; i++) await page.keyboard.press('Shift+ArrowUp');
  await page.keyboard.press(' ');
  assert.match(await page.locator('#live-pause').textContent(), /Go on/);
  await still();
  const time = await value('time');
  await page.keyboard.press('.');
  await above('time', time);
  assert.equal(await value('steps'), 1);
  await page.keyboard.press(' ');
  await page.keyboard.press('Escape');
  await below('force', 1e-12);
  await page.locator('#live-node').fill('99999999');
  await page.keyboard.press('Enter');
  assert.match(await page.locator('#live-note').textContent(), /There is no such node/);
});

test('one finger touches, two turn the body', async () => {
  await goLive({ hasTouch: true });
  const [x, y] = await place();
  const client = await page.context().newCDPSession(page);
  const touch = (type, ...points) => client.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  await touch('touchStart', [x, y]);
  await above('indentation', 0.001);
  await touch('touchStart', [x, y], [x + 90, y]);
  await below('force', 1e-12);
  await touch('touchMove', [x + 40, y + 10], [x + 130, y + 10]);
  await touch('touchEnd');
  await touch('touchStart', [x + 40, y]);
  await above('indentation', 0.001);
  await touch('touchEnd');
});

test('finite elements answer the same forces, and the springs of the server can be touched too', async () => {
  await goLive();
  await poke();
  await page.check('#live-fem');
  await above('fem-elements', 0.0005);
  assert.equal(await page.locator('#live-stage').getAttribute('data-views'), '2');
  assert.ok((await value('fem-error')) > 0);
  const [springs, elements, off] = [await value('fem-springs'), await value('fem-elements'), await value('fem-off')];
  assert.ok(Number.isFinite(springs) && Number.isFinite(elements) && Number.isFinite(off));
  await page.selectOption('#live-engine', 'native');
  await page.waitForFunction(() => document.querySelector('#live').dataset.state === 'starting');
  await moving();
  assert.equal(await page.locator('#live-law').inputValue(), 'van_gelder');
  await page.locator('#live-node').focus();
  await page.keyboard.press('Enter');
  await above('indentation', 0.001);
});

test('a body that is constrained nowhere stays in the comparison, with a sentence', async () => {
  await openPage({}, `${server.address}#${encodeURIComponent(loose)}`);
  await page.waitForSelector('#stage[data-drawn]');
  // Not check(): by the time it looks, the page may have gone back.
  await page.click('#mode [value=live]', { force: true });
  await page.waitForSelector('#message:not([hidden])');
  assert.match(await message(), /does not fix any part of the surface/);
  assert.equal(await page.locator('#compare').isVisible(), true);
});

test('without a server a dropped file moves, and what needs the server says so', async () => {
  await openPage({}, `file://${builtPage}`);
  await page.setInputFiles('#chosen', join(shipped.folder, file));
  await page.waitForSelector('#stage[data-drawn]');
  await page.check('#mode [value=live]', { force: true });
  await moving();
  await press();
  await above('force', 0.01);
  assert.equal(await page.locator('#live-fem').isDisabled(), true);
  assert.equal(await page.locator('#live-fem-hint').isVisible(), true);
  assert.equal(await page.locator('#live-engine option[value=native]').isDisabled(), true);
});

test('a narrow window shows everything and scrolls downwards only', async () => {
  await goLive({ viewport: { width: 360, height: 740 } });
  assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 360);
  const [x, width] = await page.locator('#live-stage canvas').evaluate((c) => [c.getBoundingClientRect().x, c.clientWidth]);
  assert.ok(x >= 0 && width > 300);
  await poke();
  await page.check('#live-fem');
  await page.waitForSelector('#live-stage[data-arrangement=below]');
  assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 360);
});

test('a dense screen is drawn with all its pixels', async () => {
  await goLive({ deviceScaleFactor: 3, viewport: { width: 700, height: 600 } });
  for (const canvas of ['#live-stage canvas', '#live-trace']) {
    const { drawn, laidOut } = await page.locator(canvas).evaluate((c) => ({ drawn: [c.width, c.height], laidOut: [c.clientWidth, c.clientHeight] }));
    assert.deepEqual(drawn, laidOut.map((pixels) => 3 * pixels));
  }
});
