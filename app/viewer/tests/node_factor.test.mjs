// What a prescribed displacement is multiplied by at each node: read where it is there, and refused where it is no factor.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, beforeEach, test } from 'node:test';
import { andDraw, shown } from './browser.mjs';
import { startSamples } from './samples_page.mjs';

let all;
const variant = (name, changes) => all.variant('still_result.h5', name, changes);

before(async () => (all = await startSamples()));
after(() => all?.stop());
beforeEach(() => all.open());

const choose = (node) => andDraw(all.page, () => all.page.fill('#node_number', String(node)).then(() => all.page.keyboard.press('Enter')));
const dataset = (path) => all.h5py({ path, row: null });
const said = () => all.page.locator('#node .prescribed').textContent();
/** z of what is prescribed where the place moves [mm]. */
const movedBy = async () => shown((await said()).match(/moved by \(free, free, ([^)]*)\) mm \(z max\)/)[1]);

test('a node says the prescribed displacement times its factor', async () => {
  const factor = dataset('load_case/node_factor'), values = dataset('load_case/value'), kinds = dataset('load_case/condition');
  const facet = values.findIndex(([, , z], t) => z > 0 && kinds[t] === 1);
  const [usual] = dataset('mesh/boundary_triangles')[facet];
  const other = factor.findIndex((x) => x !== 1);
  assert.ok(other >= 0 && factor[usual] === 1);
  for (const node of [usual, other]) {
    await choose(node);
    assert.ok(Math.abs((await movedBy()) - 1000 * factor[node] * values[facet][2]) < 1e-9, await said());
  }
});

test('the longest arrow is as long as the factors of its corners make it', async () => {
  variant('quarter.h5', { set: ['load_case/node_factor', null, 0.25] });
  await all.open({}, '#quarter.h5');
  assert.match((await all.page.locator('#conditions li').allTextContents()).join(), /Moved: z max; longest arrow 0\.250 mm/);
});

test('a file without factors opens, and means what it says', async () => {
  variant('older.h5', { delete: 'load_case/node_factor' });
  await all.open({}, '#older.h5');
  await choose(dataset('load_case/node_factor').findIndex((x) => x !== 1));
  assert.equal(await movedBy(), 1);
});

test('factors that are none are refused with a sentence', async () => {
  const faults = [
    ['negative.h5', { set: ['load_case/node_factor', 5, -0.1] }, /node_factor holds what is not a number from 0; make the file again/],
    ['no_number.h5', { nan: ['load_case/node_factor', 5] }, /node_factor holds what is not a number from 0; make the file again/],
    ['short.h5', { shorten: ['load_case/node_factor', 1] }, /node_factor does not have \d+ rows; make the file again/],
  ];
  for (const [name, changes, sentence] of faults) {
    variant(name, changes);
    await all.page.setInputFiles('#chosen', join(all.folder, name));
    await all.page.waitForFunction((start) => document.querySelector('#message').textContent.startsWith(start), name);
    assert.match(await all.page.locator('#message').textContent(), sentence);
  }
});
