// Tools of the live page that take hold of more than a point: two jaws close on an edge and draw along what they hold, by mouse and by keys;
// a plate presses with a face.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startLivePage } from './live_page.mjs';

let site, live;

before(async () => {
  site = await startLivePage();
  ({ live } = site);
});
after(() => site?.stop());

const grasp = (name) => live.value(`grasp-${name}`);
const message = () => live.page.locator('#message').textContent();

for (const engine of ['wasm', 'native'])
  test(`jaws close on an edge, draw it along and let go (${engine})`, async () => {
    await live.goLive({});
    if (engine === 'native') await live.take('native');
    await live.set('alpha', '60');
    await live.page.check('[name=tool][value=grasp]');
    assert.equal(await live.isShown('felt'), false);
    assert.equal(await live.isShown('grasp-felt'), true);
    // In the middle of a lobe they find no edge, and say so.
    await live.press();
    await live.page.waitForFunction(() => document.querySelector('#message').textContent.includes('take an edge') && document.querySelector('#live-let-go').disabled);
    await live.page.mouse.up();

    const [x, y] = await live.edge();
    await live.page.mouse.move(x, y);
    await live.page.mouse.down();
    await live.above('grasp-depth', 0.0039);
    await live.above('grasp-closing', 0.05);
    assert.equal(await message(), '');
    const closing = await grasp('closing');
    assert.ok((await grasp('hand')) < closing, 'each bears the other');
    assert.match(await live.text('disc-middle'), /centres of the jaws are at \(.*\) and \(.*\) mm/);
    // They go along with the pointer.
    const there = await live.text('disc-middle');
    await live.page.mouse.move(x - 10, y, { steps: 5 });
    await live.page.waitForFunction((there) => document.querySelector('#live-disc-middle').textContent !== there, there);
    await live.above('grasp-hand', 0.02);
    const node = await live.page.locator('#live-node').inputValue();
    await live.page.mouse.up();
    await live.below('grasp-closing', 1e-12);
    await live.above('volume', 0.98);

    // The same place by keys.
    await live.page.locator('#live-node').fill(node);
    await live.page.locator('#live-stage canvas').focus();
    await live.page.keyboard.press('Enter');
    await live.above('grasp-depth', 0.0039);
    await live.page.keyboard.press('PageDown');
    await live.above('grasp-depth', 0.0049);
    await live.above('grasp-closing', 0.05);
    await live.page.keyboard.press('Escape');
    await live.below('grasp-closing', 1e-12);
    await live.page.check('[name=tool][value=probe]');
    assert.equal(await live.isShown('grasp-felt'), false);
    assert.equal(await live.isShown('felt'), true);
    const { rows } = await live.saved();
    const jaws = rows.filter((row) => row.tool === 'grasp');
    assert.ok(jaws.length > 10 && jaws.every(({ inwards_x, other_x, closing }) => [inwards_x, other_x, closing].every((text) => text !== '' && Number.isFinite(Number(text)))));
  });

async function isJudgedByFem() {
  await live.isJudged();
  assert.ok(Math.abs(await live.value('fem-off')) < 0.15, `stiffness off by ${await live.value('fem-off')}`);
  assert.match(await live.text('fem-words'), /^The springs are .* hyperelastic FEM/);
}

test('undo brings the jaws before back, and FEM judges jaws and a plate', async () => {
  await live.goLive(); // on the page of the test before, whose springs the server moves
  const { page } = live;
  const firstNode = await page.locator('#live-node').inputValue();
  await live.set('alpha', '60');
  await live.set('law', 'nodal_neo_hookean_f'); // springs that are near to elements
  await page.check('#live-stays');
  await page.check('[name=tool][value=grasp]');
  await page.locator('#live-depth').fill('1');
  const [x, y] = await live.edge();
  await page.mouse.click(x, y);
  await live.above('grasp-closing', 0.01);
  await live.rests();
  const [there, closing] = [await live.text('disc-middle'), await grasp('closing')];
  await page.mouse.click(x - 15, y);
  await page.waitForFunction((there) => document.querySelector('#live-disc-middle').textContent !== there, there);
  await page.click('#live-undo');
  await live.rests();
  assert.equal(await live.text('disc-middle'), there);
  assert.ok(Math.abs((await grasp('closing')) / closing - 1) < 1e-3);

  await page.check('#live-fem');
  await isJudgedByFem();
  assert.ok(Math.abs((await live.value('fem-force')) / (2 * closing) - 1) < 0.3, 'the sum of both jaws');

  await page.check('[name=tool][value=plate]');
  assert.match(await live.text('radius-name'), /Half a side/);
  await page.locator('#live-depth').fill('1.5');
  await page.locator('#live-node').fill(firstNode);
  await page.click('#live-touch');
  await live.above('force', 0.02);
  await isJudgedByFem();
  assert.match(await live.text('disc-middle'), /^The centre of the plate is at \(.*\) mm\.$/);
  const pressed = await live.value('force');
  const { rows } = await live.saved();
  const plates = rows.filter((row) => row.tool === 'plate');
  assert.ok(plates.length > 5 && plates.every(({ inwards_y, radius, closing }) => inwards_y !== '' && radius === '0.012' && closing === ''));
  assert.ok(Math.abs(Math.hypot(...['x', 'y', 'z'].map((axis) => Number(plates.at(-1)[`force_${axis}`]))) / pressed - 1) < 0.01);
});
