// The grasp of the live page: two jaws close on an edge and draw along what they hold, by mouse and by keys.
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
/** On the screen, in the view that the page begins with: the edge of the left lobe. */
async function edge() {
  const canvas = live.page.locator('#live-stage canvas');
  await canvas.scrollIntoViewIfNeeded();
  const { x, y, width, height } = await canvas.boundingBox();
  return [x + width / 2 + 0.29 * Math.min(width, height), y + 0.38 * height];
}
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

    const [x, y] = await edge();
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
