// Random cuts in the springs of the live page in WebAssembly, each while somebody pulls, and each undone: what is left is closed and moves
// on, and what is undone is there to the bit. Says how long cuts take, and what the margin of a region is.
//   node tests/live/cut_trial.mjs RESULT.h5 [--springs NAME,...] [--cuts NUMBER] [--seed NUMBER]
import { parseArgs } from 'node:util';
import { builtKernel, startKernel } from '../node_kernel.mjs';
import { bodyNumbers, bodyOf, cutNumbers } from '../springs.mjs';
import { isClosed, randomCuts, randomNumbers } from './random_cuts.mjs';

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { springs: { type: 'string', default: 'nodal_neo_hookean' }, cuts: { type: 'string', default: '20' }, seed: { type: 'string', default: '1' } },
});
if (positionals.length !== 1) {
  console.error('name a result file of livermark run');
  process.exit(2);
}

const body = await bodyOf(positionals[0]);
const numNodes = body.points.length / 3;
const held = new Set(body.triangles.filter((_, i) => body.constrained[Math.floor(i / 3)]));
const free = [...new Set(body.triangles)].filter((node) => !held.has(node));
const displacements = (bytes) => new Float32Array(bytes.slice(bytes.byteLength - 12 * numNodes));
const restartsOf = (bytes) => new DataView(bytes).getFloat64(8 * 14, true);
const processor = () => Object.values(process.cpuUsage()).reduce((sum, each) => sum + each, 0) / 1000; // [ms]
const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];

const [first] = options.springs.split(',');

/** Each region inside with 5 mm, by centroids and with the margin kept. */
function showMargins(kernel) {
  for (let region = 1; region < body.density.length; region++) {
    const found = [false, true].map((keepsMargin) => {
      const [volume, area, margin] = new Float64Array(kernel.reply(cutNumbers({ tool: { kind: 'region', region, margin: 0.005, keepsMargin }, takesLoose: false })));
      kernel.reply([5]);
      return `${(1e6 * volume).toFixed(1)} mL, margin ${(1000 * margin).toFixed(1)} mm, wound ${(1e4 * area).toFixed(0)} cm^2`;
    });
    console.log(`region ${region} with 5 mm: by centroids ${found[0]}; kept ${found[1]}`);
  }
}

for (const springs of options.springs.split(',')) {
  const random = randomNumbers(Number(options.seed));
  const kernel = await startKernel(builtKernel);
  kernel.open(bodyNumbers(body));
  const begin = processor();
  kernel.reply([1, kernel.springs().indexOf(springs), 1, 5000, 0.45, 10, 0, 0]);
  const choosing = processor() - begin;
  if (springs === first) showMargins(kernel);
  const faults = [], times = { find: [], check: [], springs: [], all: [] };
  let numRefused = 0;
  for (const [c, request] of randomCuts(body, Number(options.cuts), random).entries()) {
    const node = free[Math.floor(random() * free.length)];
    const pull = [2, 2, ...[0, 1, 2].map((i) => body.points[3 * node + i] + 0.02 * (2 * random() - 1)), 0.015, node];
    kernel.reply([...pull, 60]);
    kernel.reply([4]);
    const before = displacements(kernel.reply([...pull, 0]));
    const start = processor();
    try {
      const answer = new Float64Array(kernel.reply(cutNumbers(request)));
      times.all.push(processor() - start);
      [times.find, times.check, times.springs].forEach((list, i) => list.push(1000 * answer[5 + i]));
      const [numGone, numTriangles] = [answer[9], answer[10]];
      if (!isClosed(answer.subarray(11 + numGone, 11 + numGone + 3 * numTriangles))) faults.push(`cut ${c}: open`);
      const moved = kernel.reply([2, 0, 0, 0, 0, 0, 0, 60]);
      if (restartsOf(moved) > 0 || !displacements(moved).every(Number.isFinite)) faults.push(`cut ${c}: the motion is lost`);
    } catch {
      numRefused++;
    }
    kernel.reply([5]);
    const after = displacements(kernel.reply([...pull, 0]));
    if (before.some((x, i) => x !== after[i])) faults.push(`cut ${c}: not as before`);
  }
  for (const fault of faults) console.log(`${springs}, ${fault}`);
  if (faults.length > 0) process.exitCode = 1;
  const [find, check, update, all] = [times.find, times.check, times.springs, times.all].map(median);
  console.log(`${springs}: chosen in ${choosing.toFixed(0)} ms; ${times.all.length} cut, ${numRefused} refused; what goes ${find.toFixed(0)} ms, length of steps ${check.toFixed(0)} ms, springs ${update.toFixed(2)} ms, all ${all.toFixed(0)} ms of processor time`);
}
