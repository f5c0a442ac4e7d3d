// What a surgeon or an engineer sees besides the colours: what holds and loads the body, which way it lies, how large it is, what is
// inside, and how much it is strained.
import assert from 'node:assert/strict';
import { after, before, beforeEach, test } from 'node:test';
import { andDraw, frames, shown } from './browser.mjs';
import { startSamples } from './samples_page.mjs';

let all;
before(async () => (all = await startSamples()));
after(() => all?.stop());
beforeEach(() => all.open());

const choose = (node) => andDraw(all.page, () => all.page.fill('#node_number', String(node)).then(() => all.page.keyboard.press('Enter')));
const dataset = (path) => all.h5py({ path, row: null });
const isDark = ([r, g, b]) => Math.max(r, g, b) < 45;
const isRed = ([r, g, b]) => r > 110 && g < 0.45 * r && b < 0.45 * r;
const isBlue = ([r, g, b]) => b > 110 && r < 0.55 * b && g < 0.75 * b;
const count = (colours, is) => colours.filter(is).length;

test('the key names what the load case prescribes, with its size', async () => {
  const lines = await all.page.locator('#conditions li').allTextContents();
  const patches = all.h5py({ path: 'mesh/boundary_patch', attribute: 'names' }), patch = dataset('mesh/boundary_patch');
  const onSprings = [...new Set(dataset('load_case/foundation/facet').map((facet) => patches[patch[facet]].replaceAll('_', ' ')))];
  assert.deepEqual(lines, ['Constrained: x min', 'Moved: z max; longest arrow 1.00 mm', 'Traction: x max; longest arrow 120 Pa',
    `On elastic springs: ${onSprings.join(', ')}; 143 Pa per mm, along the normal alone`, 'Weight: 9.81 m/s² to feet']);
});

test('patterns and arrows are drawn where something is prescribed, and only if they are asked for', async () => {
  // The reference is off itself by nothing: one pale colour, on which all else is seen.
  await andDraw(all.page, () => all.page.check('#controls [value=error]'));
  const drawn = await all.side();
  await andDraw(all.page, () => all.page.uncheck('[name=conditions]'));
  const bare = await all.side();
  assert.ok(count(drawn, isDark) > 100, 'lines of the patterns');
  assert.ok(count(drawn, isRed) > 20 && count(drawn, isBlue) > 20, 'arrows of the traction and of the displacement');
  for (const is of [isDark, isRed, isBlue]) assert.equal(count(bare, is), 0);
});

test('tractions are gone once they are let go', async () => {
  await andDraw(all.page, () => all.page.check('#controls [value=error]'));
  await andDraw(all.page, () => all.page.check('input[value=motion]'));
  await andDraw(all.page, () => all.page.locator('#exaggeration').fill('0')); // this motion leaves the picture
  const moving = await all.side();
  assert.equal(count(moving, isRed), 0);
  assert.ok(count(moving, isBlue) > 20);
  assert.ok((await all.page.locator('#conditions li').allTextContents()).every((line) => !line.startsWith('Traction')));
});

test('springs below facets are drawn, and a node there says how stiff they are', async () => {
  const points = dataset('mesh/points'), triangles = dataset('mesh/boundary_triangles'), patch = dataset('mesh/boundary_patch');
  const front = all.h5py({ path: 'mesh/boundary_patch', attribute: 'names' }).indexOf('y_min');
  const fromMiddle = (facet) => Math.abs(triangles[facet].reduce((sum, node) => sum + points[node][0] / 3, 0) - 0.1);
  const nearest = [...patch.keys()].filter((facet) => patch[facet] === front).sort((a, b) => fromMiddle(a) - fromMiddle(b));
  const facets = nearest.slice(0, dataset('load_case/foundation/facet').length).sort((a, b) => a - b);
  all.variant('still_result.h5', 'bare.h5', { set: ['load_case/condition', null, 0] }); // nothing else has a pattern
  all.variant('bare.h5', 'on_springs.h5', { set: ['load_case/foundation/facet', null, facets] });
  await all.open({}, '#on_springs.h5?colours=error&times=0');
  assert.ok(count(await all.side(), isDark) > 40, 'zigzags');
  await choose(triangles[facets[0]][0]);
  assert.match(await all.page.locator('#node .prescribed').textContent(), /on elastic springs of 143 Pa per mm, along the normal alone \(y min\)/);
  await andDraw(all.page, () => all.page.fill('#node_number', '').then(() => all.page.keyboard.press('Enter')));
  await andDraw(all.page, () => all.page.uncheck('[name=conditions]'));
  assert.equal(count(await all.side(), isDark), 0);
});

/** A facet with a traction that is not zero. */
const pulled = () => {
  const values = dataset('load_case/value');
  return dataset('load_case/condition').findIndex((kind, t) => kind === 2 && values[t].some((x) => x !== 0));
};

test('a node says what is prescribed around it, in the numbers of the file', async () => {
  const triangles = dataset('mesh/boundary_triangles');
  const kinds = dataset('load_case/condition');
  const values = dataset('load_case/value');
  const facet = pulled();
  await choose(triangles[facet][0]);
  const said = await all.page.locator('#node .prescribed').textContent();
  assert.match(said, /traction \(([^)]*)\) Pa, 120 Pa \(x max\)/);
  said.match(/traction \(([^)]*)\) Pa/)[1].split(', ').forEach((number, i) => assert.ok(Math.abs(shown(number) - values[facet][i]) < 0.5));
  const constrained = kinds.findIndex((kind, t) => kind === 1 && values[t].every((x) => x === 0));
  await choose(triangles[constrained][0]);
  assert.match(await all.page.locator('#node .prescribed').textContent(), /constrained \(x min\)/);
});

test('what presses to a depth is named with it, and its force is not', async () => {
  all.variant('still_result.h5', 'pressed.h5', { attribute: ['load_case', 'press_depth', 0.0015], set: ['load_case/constraint', pulled(), 1] });
  await all.open({}, '#pressed.h5');
  const lines = await all.page.locator('#conditions li').allTextContents();
  assert.ok(lines.some((line) => /^Pressed: .*; by 1\.5\d* mm in the mean$/.test(line)), lines.join('; '));
  await choose(dataset('mesh/boundary_triangles')[pulled()][0]);
  assert.match(await all.page.locator('#node .prescribed').textContent(), /pressed by 1\.5\d* mm in the mean/);
});

test('strain is that of the displacement gradient', async () => {
  await andDraw(all.page, () => all.page.check('#controls [value=strain]'));
  assert.equal(await all.page.locator('#legend .what').textContent(), 'Largest principal Green strain [%]');
  const points = dataset('mesh/points');
  for (const node of [0, 17]) {
    await choose(node);
    for (const model of ['fem_p2', 'springs']) {
      // The samples are stretched alike in all directions: F = (1 + s) 1, and E = s + s^2 / 2.
      const u = dataset(`solutions/${model}/displacement`);
      const s = (u.at(-1)[0] - u[0][0]) / (points.at(-1)[0] - points[0][0]);
      const expected = 100 * (s + s * s / 2);
      const strain = shown((await all.page.locator(`#node tr[data-model="${model}"] td`).allTextContents()).at(-1));
      assert.ok(Math.abs(strain - expected) < 0.006 * Math.abs(expected) + 1e-4, `${model}: ${strain} %, not ${expected} %`);
    }
  }
});

test('the picture says which way the body lies and how long a millimetre is', async () => {
  const words = await all.page.locator('#stage .overlay text').allTextContents();
  assert.ok(words.includes('left') && words.includes('head'), String(words));
  await andDraw(all.page, () => all.page.locator('#exaggeration').fill('0'));
  const bar = all.page.locator('#stage .overlay [data-mm]');
  const perPixel = Number(await bar.getAttribute('data-mm')) / Number(await bar.getAttribute('data-px'));
  await andDraw(all.page, () => all.page.uncheck('[name=conditions]'));
  // The box is 200 mm wide, its middle is as far away as the bar means, and its front is nearer.
  const { width } = await all.page.locator('#stage canvas').boundingBox();
  const colours = await all.side();
  const columns = Math.round(width / 2 - 8);
  const background = String(colours[0]);
  const isBody = (column) => { for (let i = column; i < colours.length; i += columns) if (String(colours[i]) !== background) return true; return false; };
  // The lower left corner has the axes: only what is above them counts.
  const upper = colours.splice(Math.floor(0.75 * colours.length / columns) * columns);
  assert.ok(upper.length > 0);
  const seen = Array.from({ length: columns }, (_, column) => column).filter(isBody).length * perPixel;
  assert.ok(seen > 195 && seen < 260, `${seen} mm`);
});

test('a cut is closed, with the colours of what is inside', async () => {
  await andDraw(all.page, () => all.page.uncheck('[name=conditions]'));
  await andDraw(all.page, () => all.page.locator('#exaggeration').fill('0'));
  await andDraw(all.page, () => all.page.selectOption('#cut_axis', 'z'));
  assert.match(await all.page.locator('#cut_at').textContent(), /^z = 50\.0 mm$/);
  await all.page.locator('#stage canvas').focus();
  for (let i = 0; i < 10; i++) await all.page.keyboard.press('ArrowUp'); // from above
  await frames(all.page);
  const map = (await all.page.locator('#legend .strip').getAttribute('style')).match(/\d+[ ,]+\d+[ ,]+\d+/g).map((c) => c.split(/[ ,]+/).map(Number));
  const end = Number(await all.page.locator('#legend .numbers').getAttribute('data-end-mm')) / 1000;
  const off = (a, b) => Math.max(...a.map((x, i) => Math.abs(x - b[i])));
  const values = (await all.side()).flatMap((colour) => {
    const nearest = map.map((c) => off(c, colour));
    const best = nearest.indexOf(Math.min(...nearest));
    return nearest[best] < 12 ? [(best / (map.length - 1)) * end] : [];
  });
  // u = s (x + c), c = (10, 20, 30) mm: in the plane at 50 mm nowhere below |(10, 20, 80)| s, but 37 mm s on the bottom.
  const u = dataset('solutions/fem_p2/displacement'), points = dataset('mesh/points');
  const s = (u.at(-1)[0] - u[0][0]) / (points.at(-1)[0] - points[0][0]);
  assert.ok(values.length > 1000, 'there is a face');
  const smallest = values.sort((a, b) => a - b)[Math.floor(0.01 * values.length)];
  assert.ok(smallest > 0.92 * Math.hypot(0.01, 0.02, 0.08) * s, `${smallest / s}`);
});

test('lesions have their names in glass', async () => {
  const named = () => all.page.locator('#stage .overlay text').allTextContents();
  assert.ok(!(await named()).includes('tumour'));
  await andDraw(all.page, () => all.page.check('#controls [value=translucent]'));
  await frames(all.page);
  assert.equal((await named()).filter((name) => name === 'tumour').length, 2);
  assert.match(await all.page.locator('#about').textContent(), /Inside: tumour \(\d+(\.\d+)? mL\)/);
});

test('a cut names the lesions that it meets, and no others', async () => {
  const named = async () => (await all.page.locator('#stage .overlay text').allTextContents()).filter((name) => name === 'tumour').length;
  await andDraw(all.page, () => all.page.locator('#exaggeration').fill('0'));
  const points = dataset('mesh/points'), tetrahedra = dataset('mesh/tetrahedra'), region = dataset('mesh/region');
  const inside = tetrahedra.filter((_, t) => region[t] === 1).flat().map((node) => points[node]);
  assert.ok(inside.length > 0);
  let numTried = 0;
  for (const axis of ['x', 'y', 'z']) {
    await andDraw(all.page, () => all.page.selectOption('#cut_axis', axis));
    const along = inside.map((point) => point['xyz'.indexOf(axis)]);
    const [low, high] = [Math.min(...along), Math.max(...along)];
    const at = async () => Number((await all.page.locator('#cut_at').textContent()).match(/= (\S+) mm/)[1]) / 1000;
    const moveTo = async (step) => {
      await andDraw(all.page, () => all.page.locator('#cut_place').fill(String(step)));
      await frames(all.page);
    };
    const most = Number(await all.page.locator('#cut_place').getAttribute('max'));
    await moveTo(0);
    const start = await at();
    await moveTo(most);
    const end = await at();
    const cutAt = (place) => moveTo(Math.round((most * (place - start)) / (end - start)));
    if (high - low < (3 * (end - start)) / most) continue; // thinner than steps of the slider
    numTried++;
    await cutAt((low + high) / 2);
    assert.ok((await at()) > low && (await at()) < high, `${axis} = ${await at()} is in the lesion`);
    assert.equal(await named(), 2, `both sides name it at ${axis} = ${await at()}`);
    await cutAt(low - start > end - high ? (start + low) / 2 : (high + end) / 2);
    assert.equal(await named(), 0, `${axis} = ${await at()} misses it`);
  }
  assert.ok(numTried > 0);
});
