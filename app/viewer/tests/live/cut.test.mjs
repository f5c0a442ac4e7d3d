// Cuts of the live page: a tumour is cut out, a blade is led across the body, numbers and colours of the wound, undo, refusals.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { frames, pixels } from '../browser.mjs';
import { bodyOf, frameOf, noReplay, playNatively, startHarness } from '../springs.mjs';
import { startLivePage } from './live_page.mjs';
import { isClosed, randomCuts, randomNumbers } from './random_cuts.mjs';

let site, shipped, browser, live;

before(async () => {
  site = await startLivePage();
  ({ shipped, browser, live } = site);
});
after(() => site?.stop());

/** As red as the wound is under any light and behind glass, and nothing else of the picture but arrows. */
const red = ([r, g, b]) => r > 80 && r > 1.7 * g && r > 1.3 * b;
const numRed = async () => {
  await frames(live.page);
  return (await pixels(live.page, await live.page.locator('#live-stage canvas').boundingBox())).filter(red).length;
};
/** How many are red in the picture of a body at rest, which stays. */
const redsAtRest = async () => {
  await live.rests();
  return numRed();
};
const cutsSeen = () => live.page.waitForSelector('#live-blade-readings:not([hidden])');
const wholeSeen = () => live.page.waitForSelector('#live-blade-readings', { state: 'hidden' });
const cutOut = async (name, margin) => {
  await live.page.check('[name=tool][value=blade]');
  await live.page.selectOption('#live-blade-region', { label: name });
  await live.page.locator('#live-blade-margin').fill(String(margin));
  await live.page.click('#live-blade-cut');
};
/** @param ends  in pixels from the middle of the right lobe */
const lead = async (from, to) => {
  const [x, y] = await live.place();
  await live.page.mouse.move(x + from[0], y + from[1]);
  await live.page.mouse.down();
  await live.page.mouse.move(x + to[0], y + to[1], { steps: 4 });
  await live.page.mouse.up();
};

for (const engine of ['wasm', 'native'])
  test(`a tumour is cut out with a margin, and the cut is undone (${engine})`, async () => {
    await live.goLive({});
    if (engine === 'native') {
      await live.take('native');
    }
    await live.page.check('#live-translucent');
    const before = await redsAtRest();
    await cutOut('tumour 1', 5);
    await cutsSeen();
    const way = await live.value('blade-way');
    assert.ok(way > 5e-6, 'it comes out by the capsule');
    assert.ok((await live.value('blade-volume')) - way > 75e-6 && (await live.value('blade-volume')) - way < 125e-6);
    assert.equal(await live.page.locator('#live-blade-closed').isVisible(), false);
    assert.ok((await live.value('blade-left')) >= 0.005 && (await live.value('blade-left')) < 0.009);
    assert.equal(await live.value('blade-pieces'), 1);
    assert.ok((await redsAtRest()) > before + 200, 'the wound is seen through the glass');
    // What is left is touched as before.
    await live.page.check('[name=tool][value=probe]');
    await live.poke();
    await live.above('force', 0.05);
    await live.page.click('#live-let-go');
    await live.page.click('#live-reset');
    await wholeSeen();
    assert.ok((await redsAtRest()) < before + 50, 'the wound is gone');
    await live.page.check('[name=tool][value=blade]');
    await live.page.uncheck('#live-blade-opens');
    await cutOut('tumour 6', 0);
    await cutsSeen();
    assert.equal(await live.value('blade-way'), 0);
    assert.match(await live.text('blade-closed'), /^A closed cavity of [0-9.]+ mL is left, [0-9.]+ mm below the capsule/);
    await live.page.check('#live-blade-opens');
    await live.page.click('#live-undo');
    await wholeSeen();
    assert.equal(await live.page.locator('#live-undo').isDisabled(), true);
  });

test('a stroke parts the body, which opens, and FEM answers about it', async () => {
  await live.goLive({});
  await live.page.check('#live-solid');
  await live.page.check('[name=tool][value=blade]');
  await lead([-60, 20], [60, 20]);
  await cutsSeen();
  assert.equal(await live.value('blade-volume'), 0);
  assert.ok((await live.value('blade-area')) > 1e-3);
  assert.ok((await live.value('blade-off')) < 0.002, 'the wound is at the stroke');
  await live.page.check('#live-fem');
  await live.page.check('[name=tool][value=pull]');
  await live.poke();
  await live.isJudged();
  const [springs, elements] = [await live.value('fem-springs'), await live.value('fem-elements')];
  assert.ok(elements > 0.3 * springs && elements < 3 * springs, `${elements} m beside ${springs} m`);
  assert.equal(await live.page.locator('#message').textContent(), '');
  await live.page.uncheck('#live-fem');
  await live.page.click('#live-reset');
  await wholeSeen();
});

test('a blade is led across the body, and the wound has its own colour', async () => {
  await live.goLive({});
  await live.page.check('#live-solid');
  await live.page.check('[name=tool][value=blade]');
  await live.page.selectOption('#live-blade-stroke', 'blade');
  await lead([-60, 20], [60, 20]);
  await cutsSeen();
  assert.ok((await live.value('blade-volume')) > 1e-6);
  assert.ok((await redsAtRest()) > 50, 'it is seen from outside');
  const first = await live.value('blade-area');
  await lead([0, -60], [0, 70]);
  await live.page.waitForFunction((area) => Number(document.querySelector('#live-blade-area').dataset.value) > area, first);
  await live.page.click('#live-undo');
  await live.page.waitForFunction((area) => Number(document.querySelector('#live-blade-area').dataset.value) === area, first);
  await live.page.click('#live-reset');
  await wholeSeen();
});

test('a cut that cannot be is refused in a sentence, and the next one is made', async () => {
  await live.goLive({});
  await live.page.check('[name=tool][value=blade]');
  await live.page.selectOption('#live-blade-stroke', 'side');
  await lead([0, 60], [0, -60]);
  await live.page.waitForFunction(() => document.querySelector('#message').textContent.includes('constrained'));
  assert.equal(await live.page.locator('#live-undo').isDisabled(), true);
  await wholeSeen();
  await live.page.selectOption('#live-blade-stroke', 'blade');
  await lead([-60, 20], [60, 20]);
  await cutsSeen();
  assert.equal(await live.page.locator('#message').textContent(), '');
});

test('FEM answers about what a cut has left', async () => {
  await live.goLive({});
  await cutOut('tumour 6', 2);
  await cutsSeen();
  await live.page.check('[name=tool][value=probe]');
  await live.page.check('#live-fem');
  await live.poke();
  await live.isJudged();
  const [springs, elements] = [await live.value('fem-springs'), await live.value('fem-elements')];
  assert.ok(elements > 0.3 * springs && elements < 3 * springs, `${elements} m beside ${springs} m`);
  await live.page.click('#live-undo');
  await live.page.click('#live-reset');
  await wholeSeen();
});

test('twenty random cuts in a browser leave closed surfaces, are undone to the bit, and are those of the native springs', { skip: noReplay }, async (t) => {
  const body = await bodyOf(join(shipped.folder, 'liver_tumours/palpation.h5'));
  const harness = await startHarness();
  t.after(() => harness.stop());
  const laws = await harness.open(body);
  const settings = { springLaw: 'van_gelder', keepsVolume: true, youngModulus: 5000, poissonRatio: 0.45, massDamping: 10, stiffnessDamping: 0, timeStep: 0 };
  const still = { kind: 'move', tool: { kind: 'none' }, numSteps: 0 };
  const rows = [{ kind: 'choose', settings }];
  for (const request of randomCuts(body, 20, randomNumbers(5))) rows.push({ kind: 'keep' }, still, { kind: 'cut', request }, { ...still, numSteps: 5 }, { kind: 'undo' }, still);
  const answers = await harness.play(rows, { whole: true });
  let numMade = 0, numRefused = 0;
  const made = [];
  rows.forEach((row, i) => {
    if (row.kind !== 'cut') return made.push(i);
    const cut = answers[i];
    const [previous, undone] = [answers[i - 1], answers[i + 3]];
    assert.deepEqual(undone.displacement, previous.displacement, 'it is undone to the bit');
    assert.ok(answers[i + 1].displacement.every(Number.isFinite));
    if ('fault' in cut) {
      assert.match(cut.fault, /^[^.]+$/, 'one sentence');
      return numRefused++;
    }
    made.push(i);
    numMade++;
    assert.ok(isClosed(cut.triangles), 'the surface is closed');
    assert.equal(new Set(cut.gone).size, cut.gone.length);
    const isParting = row.request.tool.thickness === 0;
    assert.ok((cut.volume > 0 || isParting) && cut.wound.includes(1));
    assert.ok(!isParting || answers[i + 1].displacement.length > previous.displacement.length || cut.volume > 0, 'parted nodes move as well');
  });
  assert.ok(numMade >= 6 && numRefused >= 2, `${numMade} cuts, ${numRefused} refused`);
  // What was refused has changed nothing, so that the native springs are not asked for it.
  const native = playNatively(body, made.map((i) => rows[i]), laws);
  made.forEach((i, k) => {
    if (rows[i].kind !== 'move') return;
    assert.deepEqual(frameOf(native[k]).displacement, answers[i].displacement, `row ${i}`);
  });
});
