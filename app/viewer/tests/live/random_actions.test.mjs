// What 500 random actions do to Live, in each engine: nothing fails, no motion is lost, cuts and tool are in the link, and all of it can be taken back.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { fragment } from '../browser.mjs';
import { startLivePage } from './live_page.mjs';
import { actAtRandom } from './random_actions.mjs';

const numActions = Number(process.env.ACTIONS ?? 500), seed = Number(process.env.SEED ?? 1);
let site, live;

before(async () => {
  site = await startLivePage();
  ({ live } = site);
});
after(() => site?.stop());

const isIdle = async () => {
  await live.page.waitForFunction(() => ['moving', 'fault'].includes(document.querySelector('#live').dataset.state));
  assert.notEqual(await live.page.locator('#live').getAttribute('data-state'), 'fault', await live.page.locator('#message').textContent());
};

for (const engine of ['wasm', 'native'])
  test(`${numActions} random actions with ${engine} springs lose nothing`, async (t) => {
    await live.goLive({});
    const { page } = live;
    if (engine === 'native') await live.take('native');
    const faults = [], said = new Map();
    page.on('pageerror', (error) => faults.push(String(error)));
    page.on('console', (message) => message.type() === 'error' && faults.push(message.text()));
    const counts = await actAtRandom(live, numActions, seed, async (action) => {
      await isIdle();
      assert.deepEqual(faults, [], action);
      for (const name of ['force', 'indentation', 'volume', 'time', 'restarts']) assert.ok(Number.isFinite(await live.value(name)), `${name} after ${action}`);
      assert.equal(await live.value('restarts'), 0, `a motion was lost after ${action}`);
      for (const id of ['message', 'live-note', 'live-fem-words']) {
        const sentence = (await page.locator(`#${id}`).textContent()).trim();
        assert.doesNotMatch(sentence, /NaN|undefined|null|Infinity|Error:|\[object/, action);
        if (sentence) said.set(sentence.replaceAll(/[\d.]+/g, 'N'), action);
      }
    });
    t.diagnostic(`${Object.entries(counts).map(([name, count]) => `${name} ${count}`).join(', ')}`);
    t.diagnostic(`said: ${[...said].map(([sentence, action]) => `${action}: ${sentence}`).join(' | ')}`);
    // The same link has the same cuts.
    await page.setViewportSize({ width: 1200, height: 850 });
    const cuts = async () => [new URLSearchParams((await fragment(page)).split('?')[1]).getAll('live_done'), await live.text('blade-taken')];
    const done = await cuts();
    await page.reload();
    await isIdle();
    await page.waitForFunction((count) => new URLSearchParams(location.hash.split('?')[1]).getAll('live_done').length === count && document.querySelector('#live-note').textContent !== 'Cutting…', done[0].length);
    if (done[0].length > 0) await page.waitForSelector('#live-blade-readings:not([hidden])', { state: 'attached' });
    assert.deepEqual(await cuts(), done);
    // And all of it can be taken back.
    if (await page.locator('#live-let-go').isEnabled()) await page.locator('#live-let-go').evaluate((button) => button.click());
    await page.click('#live-reset');
    await live.rests();
    assert.equal(await live.value('indentation'), 0);
    assert.equal(await live.value('force'), 0);
    assert.doesNotMatch(await fragment(page), /live_done|live_tool/);
    assert.deepEqual(faults, []);
  });
