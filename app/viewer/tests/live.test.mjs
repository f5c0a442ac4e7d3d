// The live page as its readers use it: mouse, finger and keys on a liver with tumours. Machines that run tests are slow and
// draw in software, so nothing here asks how fast it goes.
import assert from 'node:assert/strict';
import { copyFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import * as hdf5 from 'h5wasm/node';
import { builtPage } from './browser.mjs';
import { startLivePage } from './live/live_page.mjs';
import { bodyOf, frameOf, noReplay, playNatively } from './springs.mjs';

let site, shipped, server, live;
const file = 'liver_tumours/palpation.h5';
const loose = 'liver_tumours/loose.h5'; // constrained nowhere

before(async () => {
  site = await startLivePage();
  ({ shipped, server, live } = site);
  copyFileSync(join(shipped.folder, file), join(shipped.folder, loose));
  await hdf5.ready;
  const copy = new hdf5.File(join(shipped.folder, loose), 'a');
  const condition = copy.get('load_case/condition');
  condition.write_slice([[]], new Uint8Array(condition.shape[0]));
  copy.close();
});
after(() => site?.stop());

const message = () => live.page.locator('#message').textContent();

test('pressing on the body is answered by a force, and letting go ends it', async () => {
  await live.goLive();
  await live.press();
  await live.above('indentation', 0.001);
  await live.rests();
  const shallow = await live.value('force');
  assert.ok(shallow > 0);
  for (let i = 0; i < 8; i++) await live.page.mouse.wheel(0, -100);
  await live.above('depth-shown', 0.008);
  await live.rests();
  assert.ok((await live.value('force')) > 1.2 * shallow);
  assert.ok((await live.value('volume')) < 1);
  await live.page.mouse.up();
  await live.below('force', 1e-12);
});

test('what was done is saved step by step, with the numbers of the page', async () => {
  await live.open();
  await live.page.check('#mode [value=live]', { force: true });
  await live.moving();
  await live.set('law', 'van_gelder');
  await live.poke();
  await live.set('nu', '0.3');
  await live.above('indentation', 0.001);
  const { head, rows } = await live.saved();
  assert.equal(head.join(), 'kind,num_steps,tool,target_x,target_y,target_z,radius,node,law,keeps_volume,young_modulus,poisson_ratio,mass_damping,stiffness_damping,time_step,longest_time_step,critical_time_step,step_limit,time,force_x,force_y,force_z,indentation,smallest_volume,disc_x,disc_y,disc_z,entry_x,entry_y,entry_z,depth,diameter,toughness,friction,puncture_force,tip,target_moved,inwards_x,inwards_y,inwards_z,closing,other_x,other_y,other_z,region,margin,keeps_margin,opens,thickness,takes_loose,volume,margin_left,corner_0_x,corner_0_y,corner_0_z,corner_1_x,corner_1_y,corner_1_z,corner_2_x,corner_2_y,corner_2_z,corner_3_x,corner_3_y,corner_3_z');
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
  assert.equal(force, await live.value('force'));
  for (const name of ['time', 'indentation']) assert.equal(Number(last[name]), await live.value(name));
  assert.equal(Number(last.smallest_volume), await live.value('volume'));
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
  await live.goLive();
  await live.poke();
  await live.page.check('[name=tool][value=pull]');
  await live.press();
  await live.page.mouse.move(...(await live.place()).map((at) => at - 50), { steps: 3 });
  await live.above('force', 0.01);
  await live.page.mouse.up();
  const { rows } = await live.saved();
  const laws = await live.page.locator('#live-law option').evaluateAll((options) => options.map((option) => option.value));
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
  await live.goLive();
  await live.poke();
  const before = await live.value('time');
  await live.set('nu', '0.2');
  assert.equal(await message(), '');
  await live.above('time', before);
  await live.rests();
  assert.ok((await live.value('indentation')) > 0.001);
  await live.set('step-length', '50');
  assert.match(await message(), /a time step of 0\.05 s is too long/);
  assert.equal(await live.page.locator('#live-step-length').inputValue(), '0');
  await live.set('nu', '0.3');
  assert.equal(await message(), '');
  await live.page.locator('#live-nu').fill('0.5');
  await live.page.locator('#live-nu').press('Tab');
  assert.match(await message(), /^Poisson’s ratio has to be from 0 to 0\.49/);
  assert.equal(await live.page.locator('#live-nu').inputValue(), '0.3');
  const later = await live.value('time');
  await live.page.locator('#live-depth').fill('7');
  await live.above('time', later);
});

test('a patch is pulled to where the mouse leads it', async () => {
  await live.goLive();
  await live.page.check('[name=tool][value=pull]');
  const [x, y] = await live.place();
  await live.page.mouse.move(x, y);
  await live.page.mouse.down();
  await live.rests(); // it holds the patch
  await live.page.mouse.move(x - 20, y - 60, { steps: 4 });
  await live.above('indentation', 0.003);
  await live.page.mouse.up();
  const { rows } = await live.saved();
  const pulled = rows.filter((row) => row.tool === 'pull');
  const [first, last] = [pulled[0], pulled.at(-1)];
  assert.ok(Number(last.target_z) > Number(first.target_z), 'the mouse went up');
  assert.ok(pulled.every((row) => row.node === first.node));
});

test('keys alone touch, push in, lead along and let go', async () => {
  await live.goLive();
  await live.page.locator('#live-node').focus();
  await live.page.keyboard.press('Enter');
  await live.above('indentation', 0.001);
  await live.rests();
  const shallow = await live.value('force');
  await live.page.locator('#live-stage canvas').focus();
  for (let i = 0; i < 4; i++) await live.page.keyboard.press('PageDown');
  await live.above('depth-shown', 0.008);
  await live.rests();
  assert.ok((await live.value('force')) > 1.2 * shallow);
  for (let i = 0; i < 3; i++) await live.page.keyboard.press('Shift+ArrowUp');
  await live.page.keyboard.press(' ');
  assert.match(await live.page.locator('#live-pause').textContent(), /Go on/);
  await live.sleeps();
  const time = await live.value('time');
  await live.page.keyboard.press('.');
  await live.above('time', time);
  assert.equal(await live.value('steps'), 1);
  await live.page.keyboard.press(' ');
  await live.page.keyboard.press('Escape');
  await live.below('force', 1e-12);
  await live.page.locator('#live-node').fill('99999999');
  await live.page.keyboard.press('Enter');
  assert.match(await live.page.locator('#live-note').textContent(), /There is no such node/);
});

test('one finger touches, two turn the body', async () => {
  await live.goLive({ hasTouch: true });
  const [x, y] = await live.place();
  const client = await live.page.context().newCDPSession(live.page);
  const touch = (type, ...points) => client.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  await touch('touchStart', [x, y]);
  await live.above('indentation', 0.001);
  await touch('touchStart', [x, y], [x + 90, y]);
  await live.below('force', 1e-12);
  await touch('touchMove', [x + 40, y + 10], [x + 130, y + 10]);
  await touch('touchEnd');
  await touch('touchStart', [x + 40, y]);
  await live.above('indentation', 0.001);
  await touch('touchEnd');
});

test('finite elements answer the same forces, and the springs of the server can be touched too', async () => {
  await live.goLive();
  await live.poke();
  await live.rests();
  await live.page.check('#live-fem');
  await live.isJudged();
  assert.ok((await live.value('fem-elements')) > 0.0005);
  assert.equal(await live.page.locator('#live-stage').getAttribute('data-views'), '2');
  assert.ok((await live.value('fem-error')) > 0);
  const [springs, elements, off] = [await live.value('fem-springs'), await live.value('fem-elements'), await live.value('fem-off')];
  assert.ok(Number.isFinite(springs) && Number.isFinite(elements) && Number.isFinite(off));
  await live.take('native');
  assert.equal(await live.page.locator('#live-law').inputValue(), 'van_gelder');
  await live.page.locator('#live-node').focus();
  await live.page.keyboard.press('Enter');
  await live.above('indentation', 0.001);
});

test('while the springs move they are not compared with FEM at rest, and the page says so', async () => {
  await live.goLive({});
  const numNodes = (await bodyOf(join(shipped.folder, file))).points.length / 3;
  const answer = Buffer.alloc(8 + 12 * numNodes); // that FEM gives to any load
  answer.writeDoubleLE(1e-4);
  await live.page.routeWebSocket(/\/live\/fem/, (socket) => socket.onMessage((message) => socket.send(typeof message === 'string' ? 'chosen=fem_p2' : answer)));
  await live.set('alpha', '0'); // it swings for minutes
  await live.page.check('#live-fem');
  await live.poke();
  await live.page.waitForFunction(() => document.querySelector('#live-fem-words').textContent.startsWith('Still moving'));
  const shown = () => live.page.evaluate(() => ['springs', 'off', 'error', 'state'].map((name) => document.querySelector(`#live-fem-${name}`).textContent));
  const [springs, off, error, state] = await shown();
  assert.match(springs, /^[\d.−]+ mm, still moving$/);
  assert.deepEqual([off, error], ['–', '–']);
  assert.match(state, /^still moving/);
  await live.set('alpha', '40');
  await live.isJudged();
  assert.equal(await live.value('fem-springs'), await live.value('indentation'));
  assert.match(await live.text('fem-words'), /^The springs are \d+ % too (soft|stiff) here beside hyperelastic FEM; a hand feels 7 %\.$/);
  assert.doesNotMatch((await shown()).join(), /–|moving/);
});

test('a body that is constrained nowhere stays in the comparison, with a sentence', async () => {
  await live.open({}, `${server.address}#${encodeURIComponent(loose)}`);
  // Not check(): by the time it looks, the page may have gone back.
  await live.page.click('#mode [value=live]', { force: true });
  await live.page.waitForSelector('#message:not([hidden])');
  assert.match(await message(), /does not fix any part of the surface/);
  assert.equal(await live.page.locator('#compare').isVisible(), true);
});

test('without a server a dropped file moves, and what needs the server says so', async () => {
  await live.visit(`file://${builtPage}`);
  await live.page.setInputFiles('#chosen', join(shipped.folder, file));
  await live.page.waitForSelector('#stage[data-drawn]');
  await live.page.check('#mode [value=live]', { force: true });
  await live.moving();
  await live.press();
  await live.above('force', 0.01);
  assert.equal(await live.page.locator('#live-fem').isDisabled(), true);
  assert.equal(await live.page.locator('#live-fem-hint').isVisible(), true);
  assert.equal(await live.page.locator('#live-engine option[value=native]').isDisabled(), true);
});

test('a narrow window shows everything and scrolls downwards only', async () => {
  await live.goLive({ viewport: { width: 360, height: 740 } });
  assert.ok((await live.page.evaluate(() => document.documentElement.scrollWidth)) <= 360);
  const [x, width] = await live.page.locator('#live-stage canvas').evaluate((c) => [c.getBoundingClientRect().x, c.clientWidth]);
  assert.ok(x >= 0 && width > 300);
  await live.poke();
  await live.page.check('#live-fem');
  await live.page.waitForSelector('#live-stage[data-arrangement=below]');
  assert.ok((await live.page.evaluate(() => document.documentElement.scrollWidth)) <= 360);
});

test('a dense screen is drawn with all its pixels', async () => {
  await live.goLive({ deviceScaleFactor: 3, viewport: { width: 700, height: 600 } });
  for (const canvas of ['#live-stage canvas', '#live-trace']) {
    const { drawn, laidOut } = await live.page.locator(canvas).evaluate((c) => ({ drawn: [c.width, c.height], laidOut: [c.clientWidth, c.clientHeight] }));
    assert.deepEqual(drawn, laidOut.map((pixels) => 3 * pixels));
  }
});
