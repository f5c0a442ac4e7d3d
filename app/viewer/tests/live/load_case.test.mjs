// The ball of the live page and that of a load case which goes as deep: the liver pushes back with the same force. tumours.test.mjs takes the other one.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startTouch } from './touch_of_run.mjs';

let touch;
before(async () => (touch = await startTouch('liver_healthy')));
after(() => touch?.stop());

test('liver_healthy at rest under a finger has the force of livermark run', (t) => touch.agreesWithRun(t));

test('a contact that is smaller than an edge is said in a sentence, and what finite elements say of the stiffness', async () => {
  const { live } = touch;
  const page = await touch.movedByServer();
  await live.set('alpha', '40');
  const heard = []; // of the server of finite elements
  page.on('websocket', (socket) => socket.url().includes('/live/fem') && socket.on('framereceived', ({ payload }) => heard.push(String(payload))));
  await page.check('#live-fem');
  await page.check('#live-stays');
  await page.click('#live-touch');
  await live.above('indentation', 0.002);
  assert.equal(await live.isShown('coarse'), false, 'a finger is larger than an edge');
  await live.isJudged();
  const [springs, elements, off] = [await live.value('fem-springs'), await live.value('fem-elements'), await live.value('fem-off')];
  assert.ok(Math.abs(off - (elements / springs - 1)) < 1e-12);
  assert.ok(Math.abs(off) < 0.25, `stiffness off by ${off}`);
  const verdict = async (judge, by) => assert.match(await live.text('fem-words'),
    new RegExp(`^The springs are (as stiff as ${judge} FEM here|\\d+ % too ${by < 0 ? 'soft' : 'stiff'} here beside ${judge} FEM); a hand feels 7 %\\.$`));
  await verdict('hyperelastic', off);
  // The page says how far they are, and another touch does not wait for them.
  await page.locator('#live-depth').fill('2');
  await page.waitForFunction(() => /^Hyperelastic elements .* after \d+ s and \d+ iterations of Newton/.test(document.querySelector('#live-fem-progress').textContent));
  assert.equal(await live.text('fem-words'), 'At rest: hyperelastic FEM is being asked.');
  assert.deepEqual(await Promise.all(['off', 'error'].map((name) => live.text(`fem-${name}`))), ['–', '–'], 'nothing is compared with linear elements');
  await page.locator('#live-depth').fill('1');
  await live.isJudged();
  assert.equal(heard.filter((text) => text.startsWith('interrupted=')).length, 1);
  assert.equal(await live.text('fem-progress'), '');
  await verdict('hyperelastic', await live.value('fem-off'));
  await page.locator('#live-radius').fill('5');
  await page.waitForSelector('#live-coarse:not([hidden])');
  assert.match(await live.text('coarse'), /^The tool is smaller than an edge: its radius is 5 mm, the edges there are [\d.]+ mm long/);
  await page.click('#live-let-go');
  await live.below('force', 1e-12);
  assert.equal(await live.isShown('coarse'), false);
});
