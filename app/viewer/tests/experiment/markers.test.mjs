// The page of an experiment, against what h5py reads from the same file.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { after, before, beforeEach, test } from 'node:test';
import { builtTests, fragment, frames, shown } from '../browser.mjs';
import { names, startBlock } from './invented_block.mjs';

let all, page;
before(async () => {
  all = await startBlock((folder, change) => {
    execFileSync(join(builtTests, 'write_sample_result'), [folder]);
    change('jelly.h5', 'without_places.h5', { delete: 'experiment/body/displacement' });
    change('jelly.h5', 'without_noise.h5', { set: ['experiment/states/noise', null, 0] });
    change('jelly.h5', 'short.h5', { shorten: ['experiment/states/displacement', 1] });
    change('jelly.h5', 'off_node.h5', { set: ['experiment/body/boundary_triangles', 0, 100000] });
    change('jelly.h5', 'other_state.h5', { set: ['experiment/runs/state', 0, 7] });
    change('jelly.h5', 'no_place.h5', { nan: ['experiment/markers/position', 3, 1] });
    change('jelly.h5', 'unnamed.h5', { unname: ['experiment/markers', 'drives'] });
    change('jelly.h5', 'newer.h5', { attribute: ['/', 'schema_version', 99] });
  });
});
after(() => all?.stop());
beforeEach(async () => {
  await all.open();
  page = all.page;
});

const known = new Map(); // what h5py said, because asking takes a process
function ask(question) {
  const key = JSON.stringify(question);
  if (!known.has(key)) known.set(key, all.h5py(question));
  return known.get(key);
}
const dataset = (path) => ask({ path: `experiment/${path}`, row: null });
const namesOf = (group, name) => ask({ path: `experiment/${group}`, attribute: name });
const length = (vector) => Math.hypot(...vector);
const minus = (a, b) => a.map((x, i) => x - b[i]);
const choose = async (state) => (await page.check(`#experiment-states [value="${state}"]`), frames(page));
const message = () => page.locator('#message').textContent();
const canvas = () => page.locator('#experiment-stage canvas');

/** What is known of a model in a state. */
function runOf(model, tetrahedra, state) {
  const [models, meshes, states] = [namesOf('runs', 'models'), dataset('runs/tetrahedra'), dataset('runs/state')];
  const r = models.findIndex((name, i) => name === model && meshes[i] === tetrahedra && states[i] === state);
  assert.ok(r >= 0, `${model} ${tetrahedra} ${state}`);
  return { error: dataset('runs/error')[r], worst: dataset('runs/worst_error')[r], computed: dataset('runs/displacement')[r] };
}
const near = (text, metres, what) => assert.ok(Math.abs(shown(text) - 1000 * metres) <= 0.006 * 1000 * Math.abs(metres), `${what}: ${text}, not ${1000 * metres}`);

test('an experiment of the list is shown, and what it has not is hidden', async () => {
  assert.equal(await page.locator('#files').inputValue(), 'jelly.h5');
  assert.equal(await page.locator('#experiment-title').textContent(), 'jelly');
  assert.equal(await page.locator('#experiment-subtitle').textContent(), 'A jelly between two plates');
  for (const id of ['mode', 'compare', 'live', 'welcome', 'message']) assert.equal(await page.locator(`#${id}`).isVisible(), false, id);
  assert.match(await page.locator('#experiment-about').textContent(), /13 markers, of which 5 are compared.*our kitchen/);
});

test('the table has the errors of every model in the state, and what they are beside', async () => {
  for (const state of [0, 1]) {
    await choose(state);
    const rows = await page.locator('#experiment-table tbody tr[data-model]').evaluateAll((lines) => lines.map((line) => ({
      model: line.dataset.model, tetrahedra: Number(line.dataset.tetrahedra), cells: [...line.cells].map((cell) => cell.textContent) })));
    const pairs = new Set(namesOf('runs', 'models').map((name, r) => `${name} ${dataset('runs/tetrahedra')[r]}`));
    assert.deepEqual(new Set(rows.map(({ model, tetrahedra }) => `${model} ${tetrahedra}`)), pairs);
    for (const { model, tetrahedra, cells } of rows) {
      const run = runOf(model, tetrahedra, state);
      near(cells[2], run.error, `${model} error`);
      near(cells[3], run.worst, `${model} worst`);
    }
    assert.equal(rows.filter(({ cells }) => cells[6] === 'reference').length, 1);
    const beside = Object.fromEntries(await page.locator('#experiment-table tr.beside').evaluateAll((lines) => lines.map((line) => [line.cells[0].textContent, line.cells[2].textContent])));
    for (const [words, name] of [['Noise of the measurement', 'noise'], ['Uncertainty of the reference', 'reference_uncertainty'], ['Straight line between driven places', 'straight_line'],
      ['Rigid motion that fits best', 'rigid_motion'], ['No motion', 'no_motion']]) near(beside[words], dataset(`states/${name}`)[state], words);
  }
});

test('noise that nobody knows is not 0', async () => {
  await all.open({}, '#without_noise.h5');
  assert.doesNotMatch(await all.page.locator('#experiment-table tbody').textContent(), /Noise/);
  assert.match(await all.page.locator('#experiment-table').textContent(), /noise of the measurement is not known/);
});

test('a marker has its numbers in every model', async () => {
  await choose(0);
  const k = names.indexOf('right');
  await page.locator('#experiment-marker').focus();
  await page.selectOption('#experiment-marker', 'right');
  const measured = dataset('states/displacement')[0][k];
  const lines = await page.locator('#experiment-card tr[data-model]').evaluateAll((rows) => rows.map((row) => ({
    model: row.dataset.model, tetrahedra: Number(row.dataset.tetrahedra), cells: [...row.cells].map((cell) => cell.textContent) })));
  assert.ok(lines.length >= 4);
  for (const { model, tetrahedra, cells } of lines) {
    const computed = runOf(model, tetrahedra, 0).computed[k];
    near(cells[1], length(computed), `${model} moved`);
    near(cells[2], length(minus(computed, measured)), `${model} off`);
  }
  assert.equal(await page.evaluate(() => document.activeElement?.id), 'experiment-marker', 'the list keeps the keyboard');
  await canvas().focus();
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('#experiment-marker').inputValue(), '');
});

test('a marker that was not seen is a sentence, and not drawn', async () => {
  await choose(1);
  await page.selectOption('#experiment-marker', 'lost');
  assert.match(await page.locator('#experiment-card').textContent(), /In much it was not seen/);
  assert.ok((await page.locator('#experiment-card tr[data-model] td:last-child').allTextContents()).every((text) => text === '–'));
});

const countOf = async (colour) => (await all.placesOf(colour)).length;

test('measured, driving and computed markers are seen in the colours of the legend, light and dark', async () => {
  for (const colorScheme of ['light', 'dark']) {
    await all.open({ colorScheme });
    page = all.page;
    await page.locator('#experiment-differences').fill('6');
    await frames(page);
    for (const colour of ['measured', 'driving', 'computed']) assert.ok(await countOf(colour) > 60, `${colour} ${colorScheme}: ${await countOf(colour)}`);
    await page.uncheck('#experiment-controls [name=driving]');
    await frames(page);
    assert.equal(await countOf('driving'), 0);
  }
});

test('lines to the computed places grow with the slider', async () => {
  const draw = async (step) => {
    await page.locator('#experiment-differences').fill(String(step));
    await frames(page);
    return countOf('computed');
  };
  const small = await draw(0);
  assert.equal(await page.locator('#experiment-factor').textContent(), 'as they are');
  const large = await draw(9);
  assert.match(await page.locator('#experiment-legend').textContent(), /differences 12 times as large/);
  assert.ok(large > 2 * small, `${small}, then ${large}`);
});

test('a click takes the marker under it, and beside all markers none', async () => {
  const { x, y, height } = await canvas().boundingBox();
  await choose(0);
  await page.selectOption('#experiment-slice', 'x');
  await page.uncheck('#experiment-controls [name=driving]');
  await page.locator('#experiment-differences').fill('0');
  await frames(page);
  const places = await all.placesOf('measured');
  assert.ok(places.length > 60, String(places.length));
  const found = new Set();
  for (const [across, down] of places.filter((_, i) => i % 12 === 0)) {
    await page.mouse.click(x + across, y + down);
    found.add(await page.locator('#experiment-marker option:checked').textContent());
  }
  // 'back' may be hidden by the others.
  assert.ok(found.has('front') && found.has('middle'), [...found].join());
  for (const name of found) assert.ok(['front', 'middle', 'back'].includes(name), name);
  await page.mouse.click(x + 12, y + height - 140);
  assert.equal(await page.locator('#experiment-marker').inputValue(), '');
});

test('a link opens the same view again', async () => {
  await choose(0);
  await page.locator('#experiment-table [data-model=lloyd] button').click();
  await page.locator('#experiment-differences').fill('5');
  await page.selectOption('#experiment-slice', 'y');
  await page.selectOption('#experiment-marker', 'middle');
  await canvas().focus();
  for (const key of ['ArrowLeft', 'ArrowUp', '+']) await page.keyboard.press(key);
  const link = await fragment(page);
  const said = async () => [await all.page.locator('#experiment-states :checked').inputValue(), await all.page.locator('#experiment-model').inputValue(),
    await all.page.locator('#experiment-factor').textContent(), await all.page.locator('#experiment-slice').inputValue(), await all.page.locator('#experiment-marker').inputValue()];
  const before = await said();
  await all.open({}, link);
  assert.deepEqual(await said(), before);
  assert.equal(await fragment(all.page), link);
});

test('the table as CSV has the numbers of the file, with all digits', async () => {
  const saved = page.waitForEvent('download');
  await page.click('#experiment-save-table');
  const [head, ...lines] = readFileSync(await (await saved).path(), 'utf8').trim().split('\n').map((line) => line.split(','));
  const of = (state, model, tetrahedra) => Object.fromEntries(lines.find((line) => line[0] === state && line[1] === model && (!tetrahedra || line[2] === String(tetrahedra))).map((value, i) => [head[i], value]));
  const mesh = Math.min(...dataset('runs/tetrahedra'));
  const run = runOf('lloyd', mesh, 1);
  assert.equal(Number(of('much', 'lloyd', mesh).error_m), run.error);
  assert.equal(Number(of('much', 'lloyd', mesh).worst_error_m), run.worst);
  assert.equal(Number(of('little', 'No motion').error_m), dataset('states/no_motion')[0]);
});

test('the picture has what is drawn, with twice the pixels of the screen', async () => {
  const saved = page.waitForEvent('download');
  await page.click('#experiment-save-picture');
  const download = await saved;
  assert.equal(download.suggestedFilename(), 'jelly.png');
  assert.equal(readFileSync(await download.path()).readUInt32BE(16), 2 * Math.round((await canvas().boundingBox()).width));
});

test('an experiment is accessible in light and dark, on a screen and a phone, which does not scroll sideways', async () => {
  const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
  for (const colorScheme of ['light', 'dark'])
    for (const width of [1200, 400]) {
      await all.open({ colorScheme, viewport: { width, height: 800 } });
      await all.page.selectOption('#experiment-marker', 'middle');
      await all.page.evaluate(axe);
      const { violations, passes } = await all.page.evaluate(() => axe.run({ include: ['#experiment'] }));
      assert.ok(passes.length > 5, 'something was checked');
      assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes[0].html}`), [], `${colorScheme}, ${width} px`);
      const [needed, there] = await all.page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.clientWidth]);
      assert.ok(needed <= there, `${needed} of ${there} px`);
    }
});

const damaged = {
  'without_places.h5': /\/experiment\/body\/displacement is missing; make the file again with livermark experiment\./,
  'short.h5': /\/experiment\/states\/displacement does not have 2 rows; /,
  'off_node.h5': /\/experiment\/body\/boundary_triangles names a node that is not there; /,
  'other_state.h5': /\/experiment\/runs\/state has a state that is not there; /,
  'no_place.h5': /\/experiment\/markers\/position has a place that is no number, of marker 3; /,
  'unnamed.h5': /\/experiment\/markers has no drives; /,
  'newer.h5': /It is of schema 99, and this page reads schema 1; use the page of the same version\./,
};

test('a damaged experiment is refused in one sentence, and what was open stays', async () => {
  for (const [name, sentence] of Object.entries(damaged)) {
    await page.setInputFiles('#chosen', join(all.folder, name));
    await page.waitForFunction((start) => document.querySelector('#message').textContent.startsWith(start), `${name}: `);
    assert.match(await message(), sentence);
    assert.equal((await message()).match(/[.]( |$)/g).length, 1, await message());
    assert.match(await page.locator('#experiment-about').textContent(), /^jelly\.h5/);
  }
  await page.selectOption('#files', 'still_result.h5');
  await page.waitForSelector('#stage[data-drawn]');
  await all.settled();
  assert.equal(await page.locator('#message').isVisible(), false);
});

test('a cut-off experiment is refused, and other files open afterwards', async () => {
  const whole = readFileSync(join(all.folder, 'jelly.h5'));
  for (const part of [0.3, 0.9]) {
    await page.setInputFiles('#chosen', { name: 'cut.h5', mimeType: '', buffer: whole.subarray(0, Math.floor(part * whole.length)) });
    await page.waitForFunction(() => document.querySelector('#message').textContent.startsWith('cut.h5: '));
  }
  await page.setInputFiles('#chosen', { name: 'again.h5', mimeType: '', buffer: whole });
  await all.settled();
  assert.equal(await page.locator('#message').isVisible(), false);
  assert.match(await page.locator('#experiment-about').textContent(), /^again\.h5/);
});

test('a model that did not converge says why, and a ring-down is mentioned', async () => {
  await page.selectOption('#files', 'sample_experiment.h5');
  await page.waitForFunction(() => document.querySelector('#experiment-title').textContent === 'jelly' && document.querySelector('#experiment-about').textContent.startsWith('sample_experiment.h5'));
  await page.locator('#experiment-table [data-model=springs] button').click();
  assert.match(await page.locator('#experiment-model-about').textContent(), /^not converged: it wobbles\. Error 0\.200 mm/);
  assert.equal(await page.locator('#experiment-table [data-model=springs] .bad').textContent(), 'not converged');
  assert.match(await page.locator('#experiment-about').textContent(), /It also rang down/);
});

test('results and experiments take turns', async () => {
  for (const _ of ['once', 'again']) {
    await page.selectOption('#files', 'still_result.h5');
    await page.waitForSelector('#compare:not([hidden])');
    await all.settled();
    assert.equal(await page.locator('#experiment').isVisible(), false);
    assert.equal(await page.locator('#mode').isVisible(), true);
    await page.selectOption('#files', 'jelly.h5');
    await page.waitForSelector('#experiment:not([hidden])');
    await all.settled();
    for (const id of ['mode', 'compare']) assert.equal(await page.locator(`#${id}`).isVisible(), false, id);
    assert.ok(await countOf('measured') > 60);
  }
});
