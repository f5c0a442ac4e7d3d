// A liver on its ligaments, which are springs below facets: both engines and FEM have them, and so has what a cut leaves.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { bodyOf, bodyNumbers } from '../springs.mjs';
import { startLivePage } from './live_page.mjs';

const loadCase = join(import.meta.dirname, '../../../../load_cases/supported/small_tilt.toml');
let site, shipped, live;

before(async () => {
  site = await startLivePage('liver_healthy', loadCase);
  ({ shipped, live } = site);
});
after(() => site?.stop());

const key = () => live.page.locator('#live-conditions li.supported').textContent();
/** Way of the node that is touched over the force on it [m/N], once the body rests. */
const softness = async () => {
  await live.poke();
  await live.isJudged();
  return { springs: (await live.value('indentation')) / (await live.value('force')), elements: (await live.value('fem-elements')) / (await live.value('force')) };
};

test('the key says what bears the body', async () => {
  await live.goLive({}, 'nodal_neo_hookean');
  assert.match(await key(), /^On elastic springs: .*posterior.*; 1\.00 kPa per mm$/);
});

test('springs in the page and of the server stand on it, and FEM for the same forces does', async (t) => {
  await live.goLive({}, 'nodal_neo_hookean');
  await live.page.check('#live-fem');
  const inPage = await softness();
  await live.goLive({}, 'nodal_neo_hookean');
  await live.take('native');
  await live.page.check('#live-fem');
  const natively = await softness();
  t.diagnostic(JSON.stringify({ inPage, natively }));
  assert.ok(Math.abs(inPage.springs / natively.springs - 1) < 1e-3, `${inPage.springs} and ${natively.springs} m/N`);
  for (const { springs, elements } of [inPage, natively])
    assert.ok(Math.abs(springs / elements - 1) < 0.05, `${springs} beside ${elements} m/N`);
});

test('what a cut leaves stands on what is left of it', async (t) => {
  await live.goLive({}, 'nodal_neo_hookean');
  await live.page.check('#live-fem');
  await live.page.check('[name=tool][value=blade]');
  await live.page.selectOption('#live-blade-stroke', 'blade');
  const [x, y] = await live.place();
  await live.page.mouse.move(x - 60, y + 90);
  await live.page.mouse.down();
  await live.page.mouse.move(x + 60, y + 90, { steps: 4 });
  await live.page.mouse.up();
  await live.page.waitForSelector('#live-blade-readings:not([hidden])');
  await live.page.check('[name=tool][value=probe]');
  const { springs, elements } = await softness();
  t.diagnostic(`${springs} beside ${elements} m/N`);
  assert.ok(Math.abs(springs / elements - 1) < 0.1, `${springs} beside ${elements} m/N`);
});

test('the message that opens the springs ends with it', async () => {
  const body = await bodyOf(join(shipped.folder, 'liver_healthy/small_tilt.h5'));
  const { facets, stiffness, normalOnly } = body.foundation;
  assert.ok(facets.length > 50 && stiffness.every((k) => k === 1e6) && normalOnly.every((one) => one === 0));
  assert.deepEqual(bodyNumbers(body).slice(-3 * facets.length - 1), [facets.length, ...facets, ...stiffness, ...normalOnly]);
});
