// The springs of the live page: in WebAssembly they move as natively, to the last bit, and they bear what tools do.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { shippedFolder } from './browser.mjs';
import { bodyOf, frameOf, noReplay, playNatively, startHarness } from './springs.mjs';

let harness, healthy, tumours;
async function shippedBody(name) {
  const { folder, remove } = shippedFolder(name);
  const body = await bodyOf(join(folder, name, 'palpation.h5'));
  remove();
  return body;
}
before(async () => {
  harness = await startHarness();
  healthy = await shippedBody('liver_healthy');
  tumours = await shippedBody('liver_tumours');
});
after(() => harness?.stop());

const settings = (changes = {}) => ({
  springLaw: 'patch', keepsVolume: true, youngModulus: 5000, poissonRatio: 0.45, massDamping: 10, stiffnessDamping: 0, timeStep: 0, ...changes,
});

/** Numbers in [0, 1), the same every time (mulberry32). */
function randomNumbers(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** The body's own nodes that can be touched, with the normal there, outwards. */
function touchable(body) {
  const normals = new Map();
  const at = (node) => body.points.slice(3 * node, 3 * node + 3);
  const constrainedNodes = new Set(body.triangles.filter((_, i) => body.constrained[Math.floor(i / 3)]));
  for (let t = 0; t < body.constrained.length; t++) {
    const corners = body.triangles.slice(3 * t, 3 * t + 3);
    const [a, b, c] = corners.map(at);
    const u = b.map((x, i) => x - a[i]), v = c.map((x, i) => x - a[i]);
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const node of corners)
      if (!constrainedNodes.has(node)) normals.set(node, (normals.get(node) ?? [0, 0, 0]).map((x, i) => x + normal[i]));
  }
  return [...normals].map(([node, normal]) => ({ node, point: at(node), normal: normal.map((x) => x / Math.hypot(...normal)) }));
}

/** A poke or a pull that jumps to its target, and letting go. */
function handling(body, random, numSteps) {
  const places = touchable(body);
  const { node, point, normal } = places[Math.floor(random() * places.length)];
  const radius = 0.004 + 0.016 * random();
  const sideways = () => 0.03 * (random() - 0.5);
  const poke = random() < 0.6;
  const along = poke ? radius - 0.04 * random() : 0.06 * (random() - 0.3);
  const target = point.map((x, i) => x + along * normal[i] + sideways());
  const tool = poke ? { kind: 'probe', target, radius } : { kind: 'pull', target, radius, node };
  return [
    { kind: 'move', tool, numSteps },
    { kind: 'move', tool: { kind: 'none' }, numSteps: Math.floor(numSteps / 4) },
  ];
}

const moves = (body, seed, count, numSteps) => {
  const random = randomNumbers(seed);
  return Array.from({ length: count }, () => handling(body, random, numSteps)).flat();
};

/** A needle to the node that is furthest from the surface, in quickly and half out again. */
function pricks(body, numSteps) {
  const at = (node) => body.points.slice(3 * node, 3 * node + 3);
  const away = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));
  const outside = [...new Set(body.triangles)].map(at);
  const inside = Array.from({ length: body.points.length / 3 }, (_, node) => [Math.min(...outside.map((x) => away(x, at(node)))), at(node)]);
  const target = inside.reduce((best, next) => (next[0] > best[0] ? next : best))[1];
  const entry = touchable(body).map(({ point }) => point).reduce((best, next) => (away(next, target) < away(best, target) ? next : best));
  const values = { diameter: 0.00127, spread: 0.008, toughness: 164, friction: 20, punctureForce: 0.3 };
  return [0.2, 0.5, 0.8, 0.4].map((part) => ({ kind: 'move', tool: { kind: 'needle', entry, target, depth: part * away(entry, target), values }, numSteps }));
}

/** Places of the surface with 10 to 40 mm of body behind them, and a free face across the way there. */
function edges(body) {
  const at = (node) => body.points.slice(3 * node, 3 * node + 3);
  const minus = (a, b) => a.map((x, i) => x - b[i]);
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const facets = body.constrained.map((held, t) => {
    const [a, b, c] = body.triangles.slice(3 * t, 3 * t + 3).map(at);
    return { held, corners: [a, b, c], normal: cross(minus(b, a), minus(c, a)) };
  });
  /** Where a ray leaves the body first. */
  function exit(point, inwards) {
    const found = facets.map(({ held, corners, normal }) => {
      const along = dot(normal, inwards), way = dot(normal, minus(corners[0], point)) / along;
      const x = point.map((y, i) => y + way * inwards[i]);
      const isIn = corners.every((a, k) => dot(cross(minus(corners[(k + 1) % 3], a), minus(x, a)), normal) >= 0);
      return { held, way: isIn && along > 0 && way > 1e-6 ? way : Infinity, slope: along / Math.hypot(...normal) };
    });
    return found.reduce((a, b) => (b.way < a.way ? b : a));
  }
  const held = new Set(facets.filter((f) => f.held).flatMap((f) => f.corners.map(String)));
  return touchable(body).map(({ point, normal }) => ({ place: point, inwards: normal.map((x) => -x) })).filter(({ place, inwards }) => {
    const { held: isHeld, way, slope } = exit(place, inwards);
    const isFree = (x) => [...held].every((corner) => Math.hypot(...minus(x, corner.split(',').map(Number))) > 0.015);
    return !isHeld && way > 0.01 && way < 0.04 && slope > 0.8 && isFree(place) && isFree(place.map((x, i) => x + way * inwards[i]));
  });
}

/** Grasps of some of these at rest, which close, are led aside and let go. @param places  of edges() */
function grasps(places, seed, count, numSteps) {
  const random = randomNumbers(seed);
  return Array.from({ length: count }, () => {
    const grasp = { kind: 'grasp', ...places[Math.floor(random() * places.length)], radius: 0.004 + 0.004 * random() };
    const [depth, aside] = [0.004 + 0.008 * random(), [0, 1, 2].map(() => 0.03 * (random() - 0.5))];
    const tool = (depth, part) => ({ ...grasp, depth, target: grasp.place.map((x, i) => x + part * aside[i]) });
    return [
      { kind: 'reset' },
      ...[[0.5 * depth, 0], [depth, 0.3], [depth, 1]].map(([deep, part]) => ({ kind: 'move', tool: tool(deep, part), numSteps })),
      { kind: 'move', tool: { kind: 'none' }, numSteps },
    ];
  }).flat();
}

/** A plate that goes in where a body is furthest in a direction, so that nothing is in its way, is led aside and let go. */
function presses(body, seed, count, numSteps) {
  const random = randomNumbers(seed);
  const places = touchable(body);
  return Array.from({ length: count }, () => {
    const direction = [0, 1, 2].map(() => random() - 0.5);
    const reach = ({ point }) => point.reduce((sum, x, i) => sum + x * direction[i], 0);
    const { point, normal } = places.reduce((a, b) => (reach(b) > reach(a) ? b : a));
    const plate = { kind: 'plate', inwards: normal.map((x) => -x), radius: 0.005 + 0.01 * random() };
    const [depth, aside] = [0.002 + 0.018 * random(), [0, 1, 2].map(() => 0.03 * (random() - 0.5))];
    const tool = (depth, part) => ({ ...plate, target: point.map((x, i) => x + (0.1 * plate.radius - depth) * normal[i] + part * aside[i]) });
    return [
      { kind: 'reset' },
      ...[[0, 0], [depth, 0], [depth, 1]].map(([deep, part]) => ({ kind: 'move', tool: tool(deep, part), numSteps })),
      { kind: 'move', tool: { kind: 'none' }, numSteps },
    ];
  }).flat();
}

/** The longest step is told by an eigenvalue, whose last digits are those of a C library; what is recorded is the step. */
const about = (actual, expected) => assert.ok(Math.abs(actual - expected) <= 1e-12 * expected, `${actual}, not ${expected}`);

/** @param cuts  requests, each of which is undone */
async function movesAsNatively(body, choices, cuts = []) {
  const laws = await harness.open(body);
  const chosen = await harness.play(choices.map((choice) => ({ kind: 'choose', settings: settings(choice) })));
  const rows = choices.flatMap((choice, i) => [
    { kind: 'choose', settings: settings({ ...choice, timeStep: chosen[i].timeStep }) },
    ...moves(body, 10 + i, 4, 60),
  ]);
  rows.push(...pricks(body, 150), ...grasps(edges(body), 50, 3, 60), ...presses(body, 51, 3, 60));
  rows.push({ kind: 'keep' }, ...moves(body, 98, 1, 20), { kind: 'undo' }, ...moves(body, 97, 1, 20));
  const still = { kind: 'move', tool: { kind: 'none' }, numSteps: 40 };
  for (const request of cuts) rows.push(...moves(body, 96, 1, 20), { kind: 'cut', request }, still, { kind: 'undo' }, still);
  rows.push({ kind: 'reset' }, ...moves(body, 99, 1, 20));
  const inPage = await harness.play(rows, { whole: true });
  const natively = playNatively(body, rows, laws);
  assert.equal(natively.length, rows.length);
  let [closing, pressing] = [0, 0]; // of jaws, and of a plate [N]
  rows.forEach((row, i) => {
    if (row.kind === 'choose') {
      const [timeStep, longest, critical, pressed, numSprings, unscaled, limit] = new Float64Array(natively[i].buffer, natively[i].byteOffset, 7);
      assert.deepEqual([inPage[i].timeStep, inPage[i].numSprings, inPage[i].limit], [timeStep, numSprings, ['rest', 'pressed', 'hand'][limit]]);
      about(inPage[i].unscaledTimeStep, unscaled);
      about(inPage[i].longestTimeStep, longest);
      about(inPage[i].criticalTimeStep, critical);
      about(inPage[i].pressedTimeStep, pressed);
    }
    if (row.kind === 'cut') assert.ok(inPage[i].gone.length > 0, inPage[i].fault);
    if (row.kind === 'move') {
      const { stepSeconds, ...frame } = inPage[i];
      assert.deepEqual(frame, frameOf(natively[i], rows[i].tool), `row ${i}`);
      if (row.tool.kind === 'needle') assert.ok(frame.needle.tip >= 0 && frame.needle.work.hand > 0, 'a needle is felt');
      if (row.tool.kind === 'grasp') closing = Math.max(closing, frame.grasp.closing);
      if (row.tool.kind === 'plate') pressing = Math.max(pressing, Math.hypot(...frame.force));
      if (row.tool.kind === 'pull') assert.ok(Math.hypot(...frame.force) > 0, 'a pull is felt');
    }
  });
  assert.ok(closing > 0.01, 'jaws close on something');
  assert.ok(pressing > 0.05, 'a plate is felt');
}

test('WebAssembly moves the liver as the native build does, bit for bit, whatever is chosen', { skip: noReplay }, () =>
  movesAsNatively(healthy, [{}, { poissonRatio: 0.3, youngModulus: 2000 }, { springLaw: 'lloyd', keepsVolume: false }, { poissonRatio: 0.49, massDamping: 30, stiffnessDamping: 1e-4 }, { springLaw: 'nodal_springs' }]));

test('WebAssembly moves the liver with tumours as the native build does, bit for bit', { skip: noReplay }, () =>
  movesAsNatively(tumours, [{}, { springLaw: 'van_gelder', poissonRatio: 0.25 }, { springLaw: 'nodal_neo_hookean' }, { springLaw: 'nodal_neo_hookean', poissonRatio: 0.49, stiffnessDamping: 1e-4 }, { springLaw: 'nodal_neo_hookean_f' }, { springLaw: 'nodal_neo_hookean_f', poissonRatio: 0.49, stiffnessDamping: 1e-4 }, { springLaw: 'edge_neo_hookean', stiffnessDamping: 1e-4 }, { springLaw: 'edge_neo_hookean_f' }]));

/** The liver with a capsule, a vessel through its middle, and tissue that gets stiffer to one side, on springs below half of what is free. */
function withParts(body) {
  const xs = body.points.filter((_, i) => i % 3 === 0), [low, high] = [xs.reduce((a, b) => Math.min(a, b)), xs.reduce((a, b) => Math.max(a, b))];
  const middle = [0, 1, 2].map((c) => (3 * body.points.filter((_, i) => i % 3 === c).reduce((sum, x) => sum + x, 0)) / body.points.length);
  const facets = body.constrained.flatMap((held, f) => (held === 0 && f % 4 < 2 ? [f] : []));
  return {
    ...body,
    modulusFactor: body.region.map((_, t) => 0.8 + (0.4 * (body.points[3 * body.tetrahedra[4 * t]] - low)) / (high - low)),
    capsule: { thickness: 20e-6, youngModulus: 8.22e6, covered: body.constrained.map(() => 1) },
    vessels: { points: [...middle, middle[0] + 0.03, ...middle.slice(1)], radius: [3e-3, 2e-3], segments: [0, 1], wallRatio: 0.2, wallModulus: 1e6 },
    foundation: { facets, stiffness: facets.map((f) => 1e5 * (1 + (f % 7))), normalOnly: facets.map((f) => f % 2) },
  };
}

/** A blade from the front through the vessel of withParts(). */
function slitOf({ vessels: { points: [x, y, z] } }) {
  const corner = (dy, dz) => [x + 0.015, y + dy, z + dz];
  return { tool: { kind: 'blade', corners: [corner(-0.2, -0.02), corner(-0.2, 0.02), corner(0.005, 0.02), corner(0.005, -0.02)], thickness: 0.001 }, takesLoose: true };
}

test('WebAssembly moves and cuts a capsule, vessels, a map of stiffness and a foundation as the native build does, bit for bit', { skip: noReplay }, async () => {
  const body = withParts(healthy);
  for (const choice of [{}, { springLaw: 'nodal_neo_hookean', youngModulus: 8000, stiffnessDamping: 1e-4 }])
    await movesAsNatively(body, [choice], [slitOf(body)]);
});

test('the page marks after a cut the facets that still stand on springs', async () => {
  const body = withParts(healthy);
  await harness.open(body);
  const [, cut] = await harness.play([{ kind: 'choose', settings: settings({}) }, { kind: 'cut', request: slitOf(body) }]);
  const corners = (triangles, facet) => triangles.slice(3 * facet, 3 * facet + 3).join();
  const still = new Set(cut.wound.flatMap((isWound, facet) => (isWound ? [] : [corners(cut.triangles, facet)])));
  const { facets, stiffness, normalOnly } = body.foundation;
  const expected = facets.flatMap((facet, i) => (still.has(corners(body.triangles, facet)) ? [[corners(body.triangles, facet), stiffness[i], normalOnly[i]]] : []));
  assert.ok(expected.length > 0 && expected.length < facets.length);
  const left = await harness.foundationLeft(body, cut);
  assert.deepEqual(left.facets.map((facet, i) => [corners(cut.triangles, facet), left.stiffness[i], left.normalOnly[i]]), expected);
});

/** Every move is sound, and after the last one the body comes to rest in its own shape. */
async function bears(body, choices, count) {
  await harness.open(body);
  let smallest = 1;
  for (const [i, choice] of choices.entries()) {
    await harness.play([{ kind: 'choose', settings: settings(choice) }]);
    const answers = await harness.play(moves(body, 1000 + i, count / choices.length, 160));
    for (const { finite, restarts, force, indentation, smallestVolume } of answers) {
      assert.ok(finite && Number.isFinite(indentation) && force.every(Number.isFinite) && Number.isFinite(smallestVolume));
      assert.equal(restarts, 0, 'the motion left all bounds');
      smallest = Math.min(smallest, smallestVolume);
    }
    const rest = await harness.play(Array(8).fill({ kind: 'move', tool: { kind: 'none' }, numSteps: 500 }));
    assert.ok(rest.at(-1).smallestVolume > 0.9, `${JSON.stringify(choice)}: at rest a tetrahedron has ${rest.at(-1).smallestVolume} of its volume`);
  }
  return smallest;
}

/** A hundred of some handling under several springs. @param handle  (seed, count, numSteps) -> rows @param sizeOf  what of an answer is said */
async function bearsAHundred(t, handle, sizeOf) {
  let [smallest, largest] = [1, 0];
  for (const [i, choice] of [{}, { poissonRatio: 0.49 }, { springLaw: 'lloyd', keepsVolume: false }, { springLaw: 'nodal_neo_hookean' }].entries()) {
    await harness.play([{ kind: 'choose', settings: settings(choice) }]);
    const answers = await harness.play(handle(2000 + i, 25, 160));
    for (const answer of answers.filter(Boolean)) {
      const { finite, restarts, force, smallestVolume } = answer;
      assert.ok(finite && force.every(Number.isFinite) && Number.isFinite(smallestVolume));
      assert.equal(restarts, 0, 'the motion left all bounds');
      [smallest, largest] = [Math.min(smallest, smallestVolume), Math.max(largest, sizeOf(answer))];
    }
    const rest = await harness.play(Array(8).fill({ kind: 'move', tool: { kind: 'none' }, numSteps: 500 }));
    assert.ok(rest.at(-1).smallestVolume > 0.9, `${JSON.stringify(choice)}: at rest a tetrahedron has ${rest.at(-1).smallestVolume} of its volume`);
  }
  t.diagnostic(`smallest volume on the way: ${smallest}, largest force: ${largest} N`);
}

test('100 random grasps leave the liver sound', async (t) => {
  await harness.open(healthy);
  const places = edges(healthy);
  await bearsAHundred(t, (...how) => grasps(places, ...how), ({ grasp }) => grasp?.closing ?? 0);
});

test('100 random presses of a plate leave the liver sound', async (t) => {
  await harness.open(healthy);
  await bearsAHundred(t, (...how) => presses(healthy, ...how), ({ force }) => Math.hypot(...force));
});

test('500 random pokes and pulls leave the liver sound', async (t) => {
  t.diagnostic(`smallest volume on the way: ${await bears(healthy, [{}, { poissonRatio: 0.49 }, { springLaw: 'lloyd', keepsVolume: false }, { poissonRatio: 0.3, massDamping: 2 }, { springLaw: 'nodal_neo_hookean' }], 500)}`);
});

test('500 random pokes and pulls leave the liver with tumours sound', async (t) => {
  t.diagnostic(`smallest volume on the way: ${await bears(tumours, [{}, { springLaw: 'lloyd' }, { springLaw: 'lloyd', keepsVolume: false }, { poissonRatio: 0.49 }, { springLaw: 'nodal_springs' }], 500)}`);
});
