// The needle of the live page's springs in WebAssembly: what a step costs with it, whether slowly it meets what `livermark
// needle` found, and whether its work adds up. Times are those of the processor, medians of blocks of steps with and without it by turns.
//   node tests/live/needle_pace.mjs RESULT.h5 NEEDLE.h5 [--springs NAME,...] [--model NAME] [--speed M/S] [--poisson NUMBER]
// RESULT.h5 is of `livermark run --load-case palpation`, which holds the body where needles do; NEEDLE.h5 of
// `livermark needle --load-case biopsy`, and the model in it that the first springs are compared with.
import { parseArgs } from 'node:util';
import * as hdf5 from 'h5wasm/node';
import { builtKernel, startKernel } from '../node_kernel.mjs';
import { bodyNumbers, bodyOf } from '../springs.mjs';

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    springs: { type: 'string', default: 'nodal_neo_hookean,patch,lloyd' },
    model: { type: 'string', default: 'nodal_neo_hookean' },
    speed: { type: 'string', default: '0.02' },
    poisson: { type: 'string', default: '0.45' },
  },
});
if (positionals.length !== 2) {
  console.error('name a result file of livermark run and one of livermark needle');
  process.exit(2);
}
const body = await bodyOf(positionals[0]);
const needles = new hdf5.File(positionals[1], 'r');

// Those of load_cases/needles/biopsy.toml.
const [diameter, spread, toughness, friction] = [0.00127, 0.008, 164, 20];
const [massDamping, youngModulus] = [10, 5000];

/** A kernel that has chosen springs. @param wanted  length of a step [s]; 0 takes the longest */
async function started(springs, wanted) {
  const kernel = await startKernel(builtKernel);
  kernel.open(bodyNumbers(body));
  const [step] = new Float64Array(kernel.reply([1, kernel.springs().indexOf(springs), 1, youngModulus, Number(options.poisson), massDamping, 0, wanted]));
  return { kernel, step };
}
/** Leads the needle to a depth in so many steps. */
function led(kernel, way, depth, numSteps) {
  const view = new DataView(kernel.reply([6, ...way, diameter, spread, toughness, friction, toughness * diameter, depth, numSteps]));
  const number = (i) => view.getFloat64(8 * i, true);
  return { tip: number(1), force: number(2), target: [number(5), number(6), number(7)] };
}

const now = () => Object.values(process.cpuUsage()).reduce((sum, each) => sum + each, 0); // [us]
const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];
const numBlocks = 60, stepsInBlock = 30;
/** So short that no masses are scaled and no steps are divided: a step is one with a needle too [s]. */
const shortStep = 1.5e-4;

async function cost(springs, way) {
  const [alone, pricked] = [(await started(springs, shortStep)).kernel, (await started(springs, shortStep)).kernel];
  const length = Math.hypot(...[0, 1, 2].map((i) => way[3 + i] - way[i]));
  const times = { alone: [], going: [], held: [] };
  const timed = (list, act) => {
    const start = now();
    act();
    list.push((now() - start) / stepsInBlock);
  };
  led(pricked, way, 0, 1);
  for (const kind of ['going', 'held'])
    for (let block = 1; block <= numBlocks; block++) {
      const depth = kind === 'going' ? (length * block) / numBlocks : length;
      timed(times.alone, () => alone.reply([2, 0, 0, 0, 0, 0, 0, stepsInBlock]));
      timed(times[kind], () => led(pricked, way, depth, stepsInBlock));
    }
  const [without, going, held] = [times.alone, times.going, times.held].map(median);
  console.log(`${springs}: ${without.toFixed(0)} us; ${(going / without).toFixed(3)}, ${(held / without).toFixed(3)}`);
}

async function comparison(springs, number, way) {
  const found = (name) => needles.get(`needles/${number}/models/${options.model}/${name}`).value;
  const [depth, force, target] = ['depth', 'force', 'target'].map(found);
  const plan = depth.indexOf(Math.max(...depth));
  const { kernel, step } = await started(springs, 0);
  let atPlan = null, pull = 0, apart = 0;
  const most = Math.max(...force);
  for (let j = 1; j < depth.length; j++) {
    const mean = led(kernel, way, depth[j], Math.max(1, Math.round(Math.abs(depth[j] - depth[j - 1]) / Number(options.speed) / step)));
    // Over the steps from record to record; where the static force jumps that says nothing.
    const expected = (force[j] + force[j - 1]) / 2;
    if (Math.abs(force[j] - force[j - 1]) < 0.05 * most) apart = Math.max(apart, Math.abs(mean.force - expected));
    pull = Math.max(pull, -mean.force);
    if (j === plan) atPlan = mean;
  }
  const size = (u) => 1000 * Math.hypot(...u);
  const planned = [0, 1, 2].map((i) => target[3 * plan + i]);
  const off = atPlan.target.map((u, i) => u - planned[i]);
  const numbers = [size(planned), size(atPlan.target), size(off)].map((x) => x.toFixed(2)).join(', ');
  const forces = [force[plan], atPlan.force, -Math.min(...force), pull].map((x) => x.toFixed(3)).join(', ');
  console.log(`needle ${number}: target ${numbers} mm; force at the plan and pull out, static and in steps ${forces} N; apart at most ${apart.toFixed(3)} N`);
}

/** [kg] of each node. */
function nodalMasses() {
  const { points, tetrahedra, region, density } = body;
  const masses = new Float64Array(points.length / 3);
  region.forEach((r, t) => {
    const nodes = tetrahedra.slice(4 * t, 4 * t + 4);
    const [o, ...rest] = nodes.map((node) => points.slice(3 * node, 3 * node + 3));
    const [u, v, w] = rest.map((x) => x.map((y, i) => y - o[i]));
    const six = u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
    for (const node of nodes) masses[node] += (density[r] * six) / 24;
  });
  return masses;
}

/** In at a speed, out again, and at rest: what the hand did, and where it went [J]. @param puncture  force [N] */
async function balance(springs, way, puncture, speed) {
  const step = 2.5e-4; // of bodies whose masses are not scaled, so that each is one step
  const { kernel } = await started(springs, step);
  const masses = nodalMasses();
  let [work, damped, depth, before] = [null, 0, 0, null];
  function go(to) {
    depth = to;
    const bytes = kernel.reply([6, ...way, diameter, spread, toughness, friction, puncture, depth, 1]);
    const view = new DataView(bytes);
    work = [8, 9, 10].map((i) => view.getFloat64(8 * i, true));
    const now = new Float32Array(bytes, bytes.byteLength - 12 * masses.length);
    // Damping by mass takes alpha m v^2 in a second.
    if (before) for (let i = 0; i < now.length; i++) damped += (massDamping * masses[Math.floor(i / 3)] * (now[i] - before[i]) ** 2) / step;
    before = now;
  }
  const length = Math.hypot(...[0, 1, 2].map((i) => way[3 + i] - way[i]));
  for (let d = 0; d < length; d += speed * step) go(d);
  for (let d = length; d > -0.012; d -= speed * step) go(d);
  for (let i = 0; i < 2500; i++) go(depth);
  const [hand, lost, torn] = work.map((x) => 1000 * x);
  const left = (100 * (hand - lost - torn - 1000 * damped)) / hand;
  console.log(`${springs}, surface gives way at ${puncture.toFixed(2)} N: hand ${hand.toFixed(2)}, friction ${lost.toFixed(2)}, tearing ${torn.toFixed(2)}, damping ${(1000 * damped).toFixed(2)} mJ; left ${left.toFixed(2)} %`);
}

const wayOf = (number) => [...needles.get(`needles/${number}/way`).value];
const [first] = options.springs.split(',');
console.log(`${first} at ${options.speed} m/s beside ${options.model} of livermark needle: the target moves by, static and in steps, and how far these are apart`);
for (const number of needles.get('needles').keys()) await comparison(first, number, wayOf(number));
console.log('a step without a needle; over it one while the needle goes in, and one while it is held');
for (const springs of options.springs.split(',')) await cost(springs, wayOf(0));
console.log('in and out at 4 cm/s: the work of the hand, and where it went');
for (const puncture of [toughness * diameter, 1]) await balance(first, wayOf(0), puncture, 0.04);
