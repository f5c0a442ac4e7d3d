// Parts of the load in the large regime, and forces against the way of what moves, against what h5py reads from the same file.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { after, before, beforeEach, test } from 'node:test';
import { andDraw, fragment, frames, shown } from './browser.mjs';
import { startSamples } from './samples_page.mjs';

const path = '#path_result.h5';
let all, points, numNodes;
before(async () => {
  all = await startSamples();
  points = dataset('mesh/points');
  numNodes = points.length;
});
after(() => all?.stop());
beforeEach(() => all.open({}, path));

const read = new Map();
function dataset(name, file = 'path_result.h5') {
  const key = `${file} ${name}`;
  if (!read.has(key)) read.set(key, all.h5py({ path: name, row: null }, file));
  return read.get(key);
}
const near = (actual, expected, part = 0.006) => assert.ok(Math.abs(actual - expected) <= part * Math.abs(expected) + 1e-12, `${actual}, not ${expected}`);
const choose = (node) => andDraw(all.page, () => all.page.fill('#node_number', String(node)).then(() => all.page.keyboard.press('Enter')));
const setPoint = (point) => andDraw(all.page, () => all.page.locator('#point').fill(String(point)));
const cells = (model, place) => all.page.locator(`${place} tr[data-model="${model}"] td`).allTextContents();
const loaded = () => all.page.locator('#load_now').textContent();
const length = (vector) => Math.hypot(...vector);
const minus = (a, b) => a.map((x, i) => x - b[i]);

test('the node says the displacement and the error of the part of the load that is chosen', async () => {
  await choose(3);
  assert.equal(await loaded(), '100 %: 1.00 of 1.00 mm');
  for (const point of [0, 2]) {
    await setPoint(point);
    assert.equal(await loaded(), ['20 %: 0.200 of 1.00 mm', '', '60 %: 0.600 of 1.00 mm'][point]);
    const [u, r] = ['springs', 'fem_p2'].map((model) => dataset(`solutions/${model}/path/displacement`)[point * numNodes + 3]);
    const [, moved, error] = await cells('springs', '#node');
    near(shown(moved), 1000 * length(u));
    near(shown(error), 1000 * length(minus(u, r)));
    assert.equal((await cells('fem_p2', '#node'))[2], '–', 'the reference has no error');
  }
});

/** A quarter of the tetrahedra around each node. */
function nodalVolumes() {
  const volumes = new Array(numNodes).fill(0);
  for (const nodes of dataset('mesh/tetrahedra')) {
    const [a, b, c] = [1, 2, 3].map((i) => minus(points[nodes[i]], points[nodes[0]]));
    const volume = Math.abs(a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6;
    for (const node of nodes) volumes[node] += volume / 4;
  }
  return volumes;
}

test('the table has the errors of the part of the load that is chosen', async () => {
  const point = 1;
  all.variant('path_result.h5', 'bent.h5', { set: ['solutions/springs/path/displacement', point * numNodes + 3, [0.004, -0.009, 0.002]] });
  await all.open({}, '#bent.h5');
  const before = await cells('springs', '#comparison');
  await setPoint(point);
  const [u, r] = ['springs', 'fem_p2'].map((model) => dataset(`solutions/${model}/path/displacement`, 'bent.h5').slice(point * numNodes, (point + 1) * numNodes));
  const [energy, expectedEnergy] = ['springs', 'fem_p2'].map((model) => dataset(`solutions/${model}/path/strain_energy`)[point]);
  const [reaction, expectedReaction] = ['springs', 'fem_p2'].map((model) => dataset(`solutions/${model}/path/reaction`)[point].flat());
  const volumes = nodalVolumes();
  const sum = (value) => volumes.reduce((total, volume, i) => total + volume * value(i) ** 2, 0);
  const [, , error, stiffness, largest, energyError, reactionError] = await cells('springs', '#comparison');
  near(shown(error), 100 * Math.sqrt(sum((i) => length(minus(u[i], r[i]))) / sum((i) => length(r[i]))));
  const felt = dataset('comparisons/springs/tool/path')[point].reduce((worst, x) => (Math.abs(x) > Math.abs(worst) ? x : worst), 0);
  near(shown(stiffness.replace(' !', '')), 100 * felt);
  near(shown(largest), 1000 * Math.max(...u.map((_, i) => length(minus(u[i], r[i])))));
  near(shown(energyError), 100 * (energy / expectedEnergy - 1));
  near(shown(reactionError), (100 * length(minus(reaction, expectedReaction))) / length(expectedReaction));
  assert.notEqual(largest, before[4]);
  assert.match(await all.page.locator('#comparison h2').textContent(), /at 40 % of the load$/);
  await setPoint(4);
  assert.deepEqual(await cells('springs', '#comparison'), before, 'the whole load has the numbers of the comparisons');
});

test('arrows and words say what is prescribed at the part of the load', async () => {
  await setPoint(1);
  const lines = await all.page.locator('#conditions li').allTextContents();
  const [stiffness] = dataset('load_case/foundation/stiffness');
  const springs = `On elastic springs: z min, y max, x min, z max, y min; ${Math.round(1e-3 * stiffness)} Pa per mm, along the normal alone`;
  assert.deepEqual(lines.slice(1), ['Moved: z max; longest arrow 0.400 mm', 'Traction: x max; longest arrow 48.0 Pa', springs, 'Weight: 3.92 m/s² to feet']);
  const factor = dataset('load_case/node_factor');
  const node = factor.findIndex((x) => x !== 1);
  await choose(node);
  assert.match(await all.page.locator('#node .prescribed').textContent(), /moved by \(free, free, 0\.200\) mm/);
});

test('colours mean the same at all parts of the load', async () => {
  const end = () => all.page.locator('#legend .numbers').getAttribute('data-end-mm');
  const whole = await end();
  for (const point of [3, 0]) {
    await setPoint(point);
    assert.equal(await end(), whole);
  }
  const largest = Math.max(...dataset('solutions/springs/path/displacement').slice(0, numNodes).map(length));
  const said = (await all.page.locator('#legend .note').textContent()).match(/largest at 20 % of the load: \S+ mm and (\S+) mm/);
  near(shown(said[1]), 1000 * largest);
});

test('a link opens the same part of the load again', async () => {
  await setPoint(2);
  const link = await fragment(all.page);
  assert.match(link, /[?&]load=0\.6(&|$)/);
  await all.open({}, link);
  assert.equal(await loaded(), '60 %: 0.600 of 1.00 mm');
  assert.equal(await all.page.locator('#point').inputValue(), '2');
});

test('the slider is worked by keys, and says where it is', async () => {
  await all.page.focus('#point');
  await andDraw(all.page, () => all.page.keyboard.press('ArrowLeft'));
  assert.equal(await loaded(), '80 %: 0.800 of 1.00 mm');
  assert.equal(await all.page.locator('#point').getAttribute('aria-valuetext'), await loaded());
  await andDraw(all.page, () => all.page.keyboard.press('Home'));
  assert.equal(await loaded(), '20 %: 0.200 of 1.00 mm');
  assert.equal(await all.page.evaluate(() => document.activeElement.id), 'point');
});

test('a model whose path ended early says so, and shows no numbers beyond', async () => {
  all.variant('path_result.h5', 'early.h5', { shorten: ['solutions/springs/path/displacement', 3 * numNodes] });
  await all.open({}, '#early.h5');
  await setPoint(2);
  assert.match(await all.page.locator('#stage .second p').textContent(), /Its path ends at 40 % of the load/);
  assert.equal((await cells('springs', '#comparison'))[2], '–');
  await setPoint(1);
  assert.notEqual((await cells('springs', '#comparison'))[2], '–');
});

test('a path that does not ascend to the whole load is refused with a sentence', async () => {
  for (const [name, row, value] of [['back.h5', 1, 0.1], ['no_end.h5', 4, 0.9]]) {
    all.variant('path_result.h5', name, { set: ['load_case/path', row, value] });
    await all.page.setInputFiles('#chosen', join(all.folder, name));
    await all.page.waitForFunction((start) => document.querySelector('#message').textContent.startsWith(start), name);
    assert.match(await all.page.locator('#message').textContent(), /\/load_case\/path does not ascend from above 0 to 1; make the file again/);
  }
});

test('a file without a path has no slider and no forces', async () => {
  await all.open({}, '#still_result.h5');
  for (const id of ['#load', '#forces']) assert.equal(await all.page.locator(id).isVisible(), false);
});

/** Force along the way of the place that moves, as livermark table --kind forces defines it. */
function expectedForces() {
  const place = 1; // z_max
  const constraint = dataset('load_case/constraint'), value = dataset('load_case/value');
  const facets = constraint.flatMap((c, t) => (c === place ? [value[t]] : []));
  const way = [0, 1, 2].map((i) => facets.reduce((sum, v) => sum + (v[i] ?? 0), 0) / facets.length);
  const along = (reaction) => reaction[place].reduce((sum, x, i) => sum + (x * way[i]) / length(way), 0);
  const force = Object.fromEntries(['fem_p2', 'springs'].map((model) => [model, dataset(`solutions/${model}/path/reaction`).map(along)]));
  return { ways: dataset('load_case/path').map((part) => 1000 * part * length(way)), force };
}

/** Numbers of the coordinates of a line of the plot. */
async function plotted(selector) {
  return all.page.locator('#forces svg[data-place]').evaluate((plot, selector) => {
    const [, , width, height] = plot.getAttribute('viewBox').split(' ').map(Number);
    const { low, high, endMm } = Object.fromEntries(Object.entries(plot.dataset).map(([name, value]) => [name, Number(value)]));
    const [left, right, top, bottom] = [40, width - 6, 8, height - 22];
    return plot.querySelector(selector).getAttribute('points').split(' ').map((place) => place.split(',').map(Number))
      .map(([x, y]) => [((x - left) / (right - left)) * endMm, high - ((y - top) / (bottom - top)) * (high - low)]);
  }, selector);
}

test('every model is a line through the forces and ways of the file', async () => {
  const { ways, force } = expectedForces();
  const most = Math.max(...Object.values(force).flat());
  for (const model of ['fem_p2', 'springs']) {
    const [start, ...places] = await plotted(`polyline[data-model=${model}]`);
    assert.ok(Math.hypot(...start) < 1e-4 * most + 1e-6, 'at rest nothing pushes');
    assert.equal(places.length, ways.length);
    places.forEach(([x, y], k) => {
      near(x, ways[k], 1e-3);
      assert.ok(Math.abs(y - force[model][k]) < 1e-4 * most, `${y} N, not ${force[model][k]} N`);
    });
  }
});

test('the band is what the reactions of the reference are uncertain by', async () => {
  const { force } = expectedForces();
  const observed = Number(all.h5py({ path: 'solutions/fem_p2', attribute: 'observed_reaction' }, 'path_result.h5'));
  const reactions = dataset('solutions/fem_p2/path/reaction');
  const band = await plotted('polygon');
  const above = band.slice(1, 1 + reactions.length);
  assert.ok(observed > 0);
  above.forEach(([, y], k) => near(y - force.fem_p2[k], observed * length(reactions[k].flat()), 0.02));
  const hint = await all.page.locator('#forces .hint').textContent();
  assert.match(hint, new RegExp(`${(100 * observed).toFixed(3)} % of its reactions`));
});

test('hovering, focus and a key give the values at a part of the load', async () => {
  const { force } = expectedForces();
  const values = async () => (await all.page.locator('#forces li .value').allTextContents()).map(shown);
  const strip = (k) => all.page.locator(`#forces [data-key="z_max ${k}"]`);
  const are = async (k) => (await values()).forEach((value, i) => near(value, force[['fem_p2', 'springs'][i]][k]));
  await are(4);
  await strip(1).focus();
  await are(1);
  assert.match(await all.page.locator('#forces .at').textContent(), /^At 0\.400 mm/);
  await andDraw(all.page, () => all.page.keyboard.press('Enter'));
  assert.equal(await loaded(), '40 %: 0.400 of 1.00 mm');
  assert.equal(await all.page.evaluate(() => document.activeElement.dataset.key), 'z_max 1', 'and focus stays');
  await strip(3).hover();
  await are(3);
  const said = await strip(3).getAttribute('aria-label');
  near(shown(said.match(/springs (\S+) N/)[1]), force.springs[3]);
});

test('on a phone the slider and the forces are there without scrolling sideways', async () => {
  await all.page.setViewportSize({ width: 400, height: 800 });
  await frames(all.page);
  assert.ok((await all.page.evaluate(() => document.documentElement.scrollWidth)) <= 400);
  for (const place of ['#point', '#load_now', '#forces svg[data-place]', '#forces .forces']) {
    const { x, width } = await all.page.locator(place).boundingBox();
    assert.ok(x >= 0 && width >= 100 && x + width <= 400, place);
  }
});

test('what shows the load is accessible in light and dark, on a screen and a phone', async () => {
  const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
  for (const colorScheme of ['light', 'dark'])
    for (const width of [1200, 400]) {
      await all.open({ colorScheme, viewport: { width, height: 800 } }, path);
      await setPoint(1);
      await all.page.evaluate(axe);
      const { violations, passes } = await all.page.evaluate(() => axe.run({ include: ['#load', '#forces', '#legend', '#comparison'] }));
      assert.ok(passes.length > 5, 'something was checked');
      assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes[0].html}`), [], `${colorScheme}, ${width} px`);
    }
});
