// The needle of the live page: it goes to a tumour, says what the hand feels and how far the target is off, and comes out.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { frames, pixels } from '../browser.mjs';
import { startLivePage } from './live_page.mjs';
import { bodyOf } from '../springs.mjs';

let site, shipped, live;

before(async () => {
  site = await startLivePage();
  ({ shipped, live } = site);
});
after(() => site?.stop());

const needle = (name) => live.value(`needle-${name}`);
/** @param depth  where its tip is led and stays, before the target [mm] */
const takeNeedle = async (depth) => {
  await live.page.check('[name=tool][value=needle]');
  await live.page.selectOption('#live-needle-target', { label: 'tumour 1' });
  await live.page.locator('#live-depth').fill(String(depth));
  const [x, y] = await live.place();
  await live.page.mouse.click(x, y);
};
/** Of the handle, which no other thing of the page has. */
const blue = (colour) => [0x1f, 0x6f, 0xb5].every((x, i) => Math.abs(x - colour[i]) <= 16);
const numBlue = async () => {
  await frames(live.page);
  return (await pixels(live.page, await live.page.locator('#live-stage canvas').boundingBox())).filter(blue).length;
};

for (const engine of ['wasm', 'native'])
  test(`a needle goes to a tumour, and hand and target are read (${engine})`, async () => {
    await live.goAnew();
    if (engine === 'native') {
      await live.take('native');
      // Masses of the tumours are not scaled while it is in, and digits of forces keep their nodes trembling then.
      await live.set('law', 'nodal_neo_hookean');
    }
    const before = await numBlue();
    await takeNeedle(25);
    await live.above('needle-inside', 0.015);
    await live.rests();
    assert.ok((await needle('inside')) > 0.015, 'it is in');
    assert.ok((await needle('force')) > 0.2, 'the tissue resists');
    assert.ok((await needle('moved')) > 2e-4 && (await needle('moved')) < 0.02, 'and goes along');
    assert.ok((await needle('left')) > 0);
    assert.equal(await needle('surface'), 1);
    assert.equal(await live.isShown('felt'), false);
    assert.ok((await numBlue()) > before + 100, 'it is seen');
    assert.equal(await live.page.locator('#live-translucent').isChecked(), true);
    await live.page.click('#live-let-go');
    await live.page.waitForFunction(() => document.querySelector('#live-let-go').disabled);
    await live.page.check('[name=tool][value=probe]');
    assert.equal(await live.isShown('needle-felt'), false);
    assert.equal(await live.isShown('felt'), true);
    await live.rests();
    assert.ok((await live.value('volume')) > 0.98);
  });

test('finite elements say how far the same needle moves the target', async () => {
  await live.goAnew();
  await takeNeedle(25);
  await live.above('needle-inside', 0.015);
  await live.page.check('#live-fem');
  await live.isJudged();
  assert.match(await live.text('fem-words'), /^The springs have the target [\d.]+ mm from where hyperelastic FEM has it\.$/);
  const [springs, elements] = [await live.value('fem-springs'), await live.value('fem-elements')];
  assert.ok(springs > 2e-4 && elements > 0.3 * springs && elements < 3 * springs, `${springs} m, ${elements} m`);
  assert.equal(await live.text('fem-springs-name'), 'Springs move the target by');
  assert.equal(await live.isShown('fem-off'), false);
  await live.page.uncheck('#live-fem');
});

test('a whole capsule holds for longer', async () => {
  await live.goAnew();
  await live.page.check('[name=tool][value=needle]');
  await live.page.check('#live-needle-capsule');
  await takeNeedle(6);
  await live.above('needle-force', 0.35);
  await live.rests();
  assert.ok((await needle('force')) > 0.35);
  assert.equal(await needle('surface'), 0);
  assert.equal(await needle('inside'), 0);
});

/** A node of the free surface where the body is so thin that 50 mm straight in is outside again. */
async function thinnest() {
  const { points, tetrahedra, triangles, constrained } = await bodyOf(join(shipped.folder, 'liver_tumours/palpation.h5'));
  const at = (node) => points.slice(3 * node, 3 * node + 3);
  const normals = new Map();
  for (let t = 0; t < constrained.length; t++) {
    if (constrained[t]) continue;
    const corners = triangles.slice(3 * t, 3 * t + 3);
    const [a, b, c] = corners.map(at);
    const [u, v] = [b, c].map((x) => x.map((y, i) => y - a[i]));
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const node of corners) normals.set(node, (normals.get(node) ?? [0, 0, 0]).map((x, i) => x + normal[i]));
  }
  const held = new Set(triangles.filter((_, i) => constrained[Math.floor(i / 3)]));
  const volume = (a, b, c, d) => {
    const [u, v, w] = [b, c, d].map((x) => x.map((y, i) => y - a[i]));
    return u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
  };
  const bodies = Array.from({ length: tetrahedra.length / 4 }, (_, t) => tetrahedra.slice(4 * t, 4 * t + 4).map(at));
  const isInside = (x) => bodies.some(([a, b, c, d]) => volume(x, b, c, d) >= 0 && volume(a, x, c, d) >= 0 && volume(a, b, x, d) >= 0 && volume(a, b, c, x) >= 0);
  const found = [...normals].find(([node, normal]) => {
    const size = Math.hypot(...normal);
    return !held.has(node) && !isInside(at(node).map((x, i) => x - (0.05 * normal[i]) / size));
  });
  return found[0];
}

test('a way that leaves the body is refused in a sentence, and another needle goes', async () => {
  await live.goAnew();
  await live.page.check('[name=tool][value=needle]');
  await live.page.selectOption('#live-needle-target', '');
  await live.page.locator('#live-node').fill(String(await thinnest()));
  await live.page.click('#live-touch');
  await live.page.waitForFunction(() => document.querySelector('#message').textContent.includes('leaves the body'));
  assert.equal(await live.page.locator('#live-let-go').isDisabled(), true);
  await takeNeedle(25);
  await live.above('needle-inside', 0.005);
});
