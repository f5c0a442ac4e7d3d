// Random needles in the springs of the live page in WebAssembly: from any place of the surface to any node, at 2 to 10 cm/s in,
// half out, in again and out. No motion may be lost, and the hand does at least what friction and tearing take.
//   node tests/live/needle_trial.mjs RESULT.h5 [--springs NAME] [--needles NUMBER] [--seed NUMBER]
import { parseArgs } from 'node:util';
import { builtKernel, startKernel } from '../node_kernel.mjs';
import { bodyNumbers, bodyOf } from '../springs.mjs';

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { springs: { type: 'string', default: 'patch' }, needles: { type: 'string', default: '20' }, seed: { type: 'string', default: '1' } },
});
if (positionals.length !== 1) {
  console.error('name a result file of livermark run');
  process.exit(2);
}

/** Numbers in [0, 1), the same every time (mulberry32). */
function randomNumbers(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

const body = await bodyOf(positionals[0]);
const random = randomNumbers(Number(options.seed));
const within = (low, high) => low + (high - low) * random();
const kernel = await startKernel(builtKernel);
kernel.open(bodyNumbers(body));
const [step] = new Float64Array(kernel.reply([1, kernel.springs().indexOf(options.springs), 1, 5000, 0.45, 10, 0, 0]));
const at = (node) => body.points.slice(3 * node, 3 * node + 3);
const held = new Set(body.triangles.filter((_, i) => body.constrained[Math.floor(i / 3)]));
const free = [...new Set(body.triangles)].filter((node) => !held.has(node));
const stepsAtOnce = 40;
const found = { driven: 0, refused: 0, lost: 0, notFinite: 0, unbalanced: 0, strongest: 0, smallestVolume: 1 };

function drive() {
  const [entry, target] = [at(free[Math.floor(random() * free.length)]), at(Math.floor((random() * body.points.length) / 3))];
  const length = Math.hypot(...target.map((x, i) => x - entry[i]));
  if (length < 0.012 || length > 0.09) return drive();
  const [diameter, toughness, friction] = [within(0.0006, 0.0018), within(60, 210), random() < 0.1 ? 0 : within(0, 40)];
  const puncture = diameter * toughness * (random() < 0.5 ? 1 : within(1, 6));
  const spread = Math.min(within(0.005, 0.01), 0.9 * length), speed = within(0.02, 0.1), turn = within(0.3, 0.7) * length;
  const go = (depth, numSteps) => {
    const view = new DataView(kernel.reply([6, ...entry, ...target, diameter, spread, toughness, friction, puncture, depth, numSteps]));
    return [2, 8, 9, 10, 23, 25].map((i) => view.getFloat64(8 * i, true));
  };
  kernel.reply([3]);
  try {
    go(0, 1);
  } catch {
    found.refused++; // its way leaves the body, or enters where it is held
    return;
  }
  let [depth, last] = [0, null];
  for (const goal of [length, turn, length, -0.01]) {
    const [from, count] = [depth, Math.max(1, Math.ceil(Math.abs(goal - depth) / (speed * step * stepsAtOnce)))];
    for (let i = 1; i <= count; i++) {
      last = go(from + ((goal - from) * i) / count, stepsAtOnce);
      if (!Number.isFinite(last[0])) found.notFinite++;
      found.strongest = Math.max(found.strongest, Math.abs(last[0]));
      found.smallestVolume = Math.min(found.smallestVolume, last[4]);
    }
    depth = goal;
  }
  const [, hand, lost, torn, , restarts] = go(depth, 400);
  found.driven++;
  found.lost = restarts;
  if (hand < 0.98 * (lost + torn)) found.unbalanced++;
}

for (let i = 0; i < Number(options.needles); i++) drive();
console.log(`${options.springs}, steps of ${(1000 * step).toFixed(2)} ms:`, found);
process.exit(found.lost + found.notFinite + found.unbalanced > 0 ? 1 : 0);
