// Vessels that are lines: their points move with the body, their tubes are as thick as they say, and the page shows them.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { build } from 'vite';
import { andDraw, fragment, frames } from './browser.mjs';
import { startSamples } from './samples_page.mjs';

const viewer = join(import.meta.dirname, '..');
/** A module of the page, as it is bundled. */
async function moduleOf(path) {
  const [{ output }] = await build({ root: viewer, configFile: false, logLevel: 'warn',
    build: { write: false, minify: false, lib: { entry: join(viewer, 'src', path), formats: ['es'] } } });
  return import(`data:text/javascript;base64,${Buffer.from(output[0].code).toString('base64')}`);
}

let data, lines, picture;
before(async () => ([data, lines, picture] = [await moduleOf('data/carriers.ts'), await moduleOf('data/vessels.ts'), await moduleOf('picture/tubes.ts')]));

/** Numbers in [0, 1), the same every time. */
function numbersFrom(seed) {
  let state = seed;
  return () => (state = (48271 * state) % 2147483647) / 2147483647;
}

const sides = [0.2, 0.1, 0.15]; // of a block [m]

/** The block in cubes of six tetrahedra. @param unrest  how far nodes inside are off their place, as a part of a cube */
function block(count = 4, unrest = 0.3) {
  const random = numbersFrom(7);
  const node = (i, j, k) => (i * (count + 1) + j) * (count + 1) + k;
  const places = [], tetrahedra = [], faces = new Map();
  for (let i = 0; i <= count; i++) for (let j = 0; j <= count; j++) for (let k = 0; k <= count; k++)
    places.push(...[i, j, k].map((n, axis) => (sides[axis] / count) * (n + (n > 0 && n < count && [i, j, k].every((m) => m > 0 && m < count) ? unrest * (random() - 0.5) : 0))));
  const ways = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
  for (let i = 0; i < count; i++) for (let j = 0; j < count; j++) for (let k = 0; k < count; k++)
    for (const way of ways) {
      const at = [i, j, k], corners = [node(...at)];
      for (const axis of way) corners.push(node(...at.map((n, d) => (d === axis ? (at[d] = n + 1) : n))));
      tetrahedra.push(...corners);
      for (let c = 0; c < 4; c++) {
        const face = corners.filter((_, d) => d !== c), key = String([...face].sort((a, b) => a - b));
        if (!faces.delete(key)) faces.set(key, face);
      }
    }
  return { points: places, tetrahedra, triangles: [...faces.values()].flat() };
}

const gradient = [[0.11, -0.23, 0.05], [0.31, 0.07, -0.13], [-0.02, 0.17, 0.29]], shift = [0.003, -0.001, 0.002];
const linear = (x) => gradient.map((row, i) => shift[i] + row.reduce((sum, g, j) => sum + g * x[j], 0));
const rowsOf = (values) => Array.from({ length: values.length / 3 }, (_, p) => Array.from(values.slice(3 * p, 3 * p + 3)));
const largest = (values) => Math.max(...values.map(Math.abs));

test('a linear displacement moves points exactly, inside and on faces, edges and nodes', () => {
  const { points, tetrahedra, triangles } = block();
  const random = numbersFrom(3), rows = rowsOf(points);
  const mean = (nodes) => [0, 1, 2].map((i) => nodes.reduce((sum, node) => sum + rows[node][i], 0) / nodes.length);
  const on = [1, 2, 3].flatMap((count) => Array.from({ length: 80 }, (_, t) => mean(tetrahedra.slice(4 * t, 4 * t + count))));
  const places = [...Array.from({ length: 400 }, () => sides.map((side) => side * random())), ...on].flat();
  const carriers = data.carriersOf(places, points, tetrahedra, triangles);
  for (const [p, place] of rowsOf(places).entries()) {
    const weights = Array.from(carriers.weights.slice(4 * p, 4 * p + 4)), nodes = Array.from(carriers.nodes.slice(4 * p, 4 * p + 4));
    assert.ok(weights.every((w) => w > -1e-9), 'its own tetrahedron holds it');
    assert.ok(largest(place.map((x, i) => weights.reduce((sum, w, k) => sum + w * rows[nodes[k]][i], 0) - x)) < 1e-14);
  }
  const moved = data.carried(places, carriers, rows.flatMap(linear), 2.5);
  const expected = rowsOf(places).flatMap((x) => linear(x).map((u, i) => x[i] + 2.5 * u));
  assert.ok(largest(expected.map((x, i) => x - moved[i])) < 4e-8, 'to the digits of single precision');
});

test('a point outside moves as the nearest point of the body does', () => {
  const { points, tetrahedra, triangles } = block();
  const random = numbersFrom(5);
  // Beside faces, edges and corners of the block, where the nearest point is that of a box.
  const places = Array.from({ length: 300 }, () => sides.map((side) => side * (3 * random() - 1))).filter((x) => x.some((c, i) => c < 0 || c > sides[i]));
  const carriers = data.carriersOf(places.flat(), points, tetrahedra, triangles);
  const moved = rowsOf(data.carried(places.flat(), carriers, rowsOf(points).flatMap(linear), 1));
  places.forEach((place, p) => {
    const u = linear(place.map((x, i) => Math.min(Math.max(x, 0), sides[i])));
    assert.ok(largest(moved[p].map((x, i) => x - place[i] - u[i])) < 5e-8, String(place));
  });
});

test('a node whose displacement is no number leaves points at rest', () => {
  const { points, tetrahedra, triangles } = block(1);
  const places = [0.05, 0.05, 0.05];
  const moved = data.carried(places, data.carriersOf(places, points, tetrahedra, triangles), points.map(() => Number.NaN), 1);
  assert.deepEqual(Array.from(moved), Array.from(Float32Array.from(places)));
});

test('a cut takes the vessels of the tissue that it takes, and leaves the rest with their radii', () => {
  const { points, tetrahedra, triangles } = block(4, 0), rows = rowsOf(points);
  const cells = Array.from({ length: tetrahedra.length / 4 }, (_, t) => tetrahedra.slice(4 * t, 4 * t + 4));
  const isTaken = (cell) => cell.every((node) => rows[node][0] > 0.0999 && rows[node][0] < 0.1501); // the third of four layers
  const vessels = { points: Float64Array.of(0.01, 0.03, 0.06, 0.19, 0.03, 0.06), radius: Float64Array.of(1e-3, 4e-3), segments: Int32Array.of(0, 1) };
  const left = lines.vesselsLeft(vessels, Int32Array.from(cells.filter(isTaken).flat()), { points, tetrahedra: cells.filter((cell) => !isTaken(cell)).flat(), triangles });
  assert.deepEqual(Array.from(left.segments), [0, 1, 2, 3]);
  for (const [p, x] of [0.01, 0.1, 0.15, 0.19].entries()) {
    assert.ok(Math.abs(left.points[3 * p] - x) <= 1.001e-3, `${left.points[3 * p]}, not ${x}`);
    assert.ok(Math.abs(left.radius[p] - 1e-3 - (3e-3 * (left.points[3 * p] - 0.01)) / 0.18) < 1e-15);
  }
  const moved = rowsOf(data.carried(left.points, left.carriers, rows.flatMap(linear), 1));
  rowsOf(left.points).forEach((x, p) => assert.ok(largest(linear(x).map((u, i) => x[i] + u - moved[p][i])) < 4e-8));
});

test('a cut through a tube is the ellipse that its radius and its direction make', () => {
  const around = 24, radius = 0.003, shape = picture.tubeShape(around, 3);
  const polygon = 0.5 * around * Math.sin((2 * Math.PI) / around) * radius ** 2; // as large as the section of the prism that is drawn
  for (const [axis, way] of [[0, [1, 0, 0]], [1, [0.6, 0.8, 0]], [2, [0.3, -0.5, 0.4]]]) {
    const length = Math.hypot(...way), middle = [0.02, -0.01, 0.03];
    const end = (sign) => Float32Array.from([...middle.map((x, i) => x + (sign * 0.05 * way[i]) / length), radius]);
    const cut = { axis, place: middle[axis] + 0.004, keepsAbove: false };
    const triangles = picture.tubeSections(cut, { begin: end(-1), end: end(1) }, shape);
    let area = 0;
    for (let t = 0; t < triangles.length; t += 9) {
      const [u, v] = [3, 6].map((offset) => [0, 1, 2].map((i) => triangles[t + offset + i] - triangles[t + i]));
      area += Math.abs(u[(axis + 1) % 3] * v[(axis + 2) % 3] - u[(axis + 2) % 3] * v[(axis + 1) % 3]) / 2;
      for (let corner = 0; corner < 3; corner++) assert.ok(Math.abs(triangles[t + 3 * corner + axis] - cut.place) < 1e-8);
    }
    const expected = (polygon * length) / Math.abs(way[axis]);
    assert.ok(Math.abs(area / expected - 1) < 1e-4, `${area}, not ${expected}`);
    assert.equal(picture.tubeSections({ ...cut, place: middle[axis] + 0.06 }, { begin: end(-1), end: end(1) }, shape).length, 0);
  }
});

/** Through glass as well; the body is pale yellow without errors. */
const isBlue = ([red, , blue]) => blue > red + 25;

test('vessels are seen in glass and in cuts, until they are hidden', async (t) => {
  const all = await startSamples();
  t.after(() => all.stop());
  const points = all.h5py({ path: 'vessels/points', row: null }, 'with_jaws_result.h5');
  const inside = points.map((_, p) => [0.1, 0.05, 0.02 + (0.064 * p) / points.length]);
  all.variant('with_jaws_result.h5', 'even.h5', { set: ['materials/young_modulus', null, 7000] });
  all.variant('even.h5', 'veins.h5', { set: ['vessels/points', null, inside] });
  await all.open({ viewport: { width: 900, height: 560 } }, '#veins.h5?colours=error&conditions=off&times=0'); // little to draw
  const { page } = all, count = async () => (await frames(page), (await all.side()).filter(isBlue).length);
  assert.match(await page.locator('#conditions').textContent(), /^Vessels: 0\.06 m as lines, with radii of 10 mm; seen in glass, or cut open$/);
  assert.match(await page.locator('#about').textContent(), /Capsule: E t = \S+ N\/m; vessels: 0\.06 m as lines/);
  await andDraw(page, () => page.selectOption('#cut_axis', 'y'));
  const cut = await count();
  await andDraw(page, () => page.selectOption('#cut_axis', ''));
  const whole = await count();
  assert.ok(cut > whole + 200, `${cut} pixels with the section, ${whole} without`);
  await andDraw(page, () => page.check('#controls [value=translucent]'));
  const seen = await count();
  await andDraw(page, () => page.uncheck('[name=vessels]'));
  const hidden = await count();
  assert.ok(hidden < whole + 20 && seen > hidden + 200, `${seen} pixels in glass, ${hidden} without vessels`);
  assert.equal(await page.locator('#conditions').textContent(), '');
  assert.match(await fragment(page), /vessels=off/);
  await andDraw(page, () => page.check('#controls [value=modulus]'));
  assert.match(await page.locator('#legend .what').textContent(), /modulus \[kPa\]/);
  assert.equal(await page.locator('#legend .numbers').getAttribute('data-end-mm'), '8', 'the next round number above 7 kPa');
});
