// Random cuts in the springs of the live page in WebAssembly, each while somebody pulls, and each undone: what is left is closed and moves
// on, and what is undone is there to the bit. Says how long cuts take, and what the margin of a region is.
//   node tests/live/cut_trial.mjs RESULT.h5 [--springs NAME,...] [--cuts NUMBER] [--seed NUMBER] [--strokes]
import { parseArgs } from 'node:util';
import { builtKernel, startKernel } from '../node_kernel.mjs';
import { bodyNumbers, bodyOf, cutNumbers } from '../springs.mjs';
import { isClosed, randomCuts, randomNumbers } from './random_cuts.mjs';

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { springs: { type: 'string', default: 'nodal_neo_hookean' }, cuts: { type: 'string', default: '20' }, seed: { type: 'string', default: '1' }, strokes: { type: 'boolean', default: false } },
});
if (positionals.length !== 1) {
  console.error('name a result file of livermark run');
  process.exit(2);
}

const body = await bodyOf(positionals[0]);
const held = new Set(body.triangles.filter((_, i) => body.constrained[Math.floor(i / 3)]));
const free = [...new Set(body.triangles)].filter((node) => !held.has(node));
/** Of as many nodes as there are by now. */
const displacements = (bytes) => new Float32Array(bytes.slice(bytes.byteLength - 12 * new DataView(bytes).getFloat64(8 * 16, true)));
const restartsOf = (bytes) => new DataView(bytes).getFloat64(8 * 14, true);
const processor = () => Object.values(process.cpuUsage()).reduce((sum, each) => sum + each, 0) / 1000; // [ms]
const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];

const [first] = options.springs.split(',');

/** Each region inside with 5 mm, by centroids and with the margin kept. */
function showMargins(kernel) {
  for (let region = 1; region < body.density.length; region++) {
    const found = [false, true].map((keepsMargin) => {
      const [volume, , area, margin] = new Float64Array(kernel.reply(cutNumbers({ tool: { kind: 'region', region, margin: 0.005, keepsMargin, opens: false }, takesLoose: false })));
      kernel.reply([5]);
      return `${(1e6 * volume).toFixed(1)} mL, margin ${(1000 * margin).toFixed(1)} mm, wound ${(1e4 * area).toFixed(0)} cm^2`;
    });
    console.log(`region ${region} with 5 mm: by centroids ${found[0]}; kept ${found[1]}`);
  }
}

/** Blades without thickness from the front, across the body: how far their wounds are from them, and how long steps may be. */
function showStrokes(kernel, springs) {
  const chosen = [1, kernel.springs().indexOf(springs), 1, 5000, 0.45, 10, 0, 0];
  const random = randomNumbers(3);
  const axis = (i) => body.points.filter((_, j) => j % 3 === i);
  const [[x0, x1], [y0, y1], [z0, z1]] = [0, 1, 2].map((i) => [Math.min(...axis(i)), Math.max(...axis(i))]);
  const critical = () => 1000 * new Float64Array(kernel.reply(chosen))[2];
  const before = critical();
  const found = [];
  for (let stroke = 0; stroke < 20; stroke++) {
    const [x, y, tilt] = [x0 + (0.35 + 0.5 * random()) * (x1 - x0), y0 + (0.2 + 0.6 * random()) * (y1 - y0), 0.03 * (2 * random() - 1)];
    const corners = [[x - tilt, y0 - 0.05, z0 - 0.02], [x + tilt, y0 - 0.05, z1 + 0.02], [x + tilt, y, z1 + 0.02], [x - tilt, y, z0 - 0.02]];
    try {
      const answer = new Float64Array(kernel.reply(cutNumbers({ tool: { kind: 'blade', corners, thickness: 0 }, takesLoose: false })));
      found.push([...answer.subarray(6, 10), ...answer.subarray(12, 16)].map((value) => 1000 * value).concat(critical()));
    } catch {
      // Some leave a loose piece.
    }
    kernel.reply([3]);
    kernel.reply(chosen);
  }
  const mean = (c) => found.reduce((sum, row) => sum + row[c], 0) / found.length;
  const most = (c) => Math.max(...found.map((row) => row[c]));
  console.log(`${springs}: ${found.length} strokes that part; wound from the stroke ${mean(0).toFixed(2)} mm in the mean and ${most(1).toFixed(2)} mm at most, nodes on the stroke ${mean(2).toFixed(2)} and ${most(3).toFixed(2)} mm`);
  console.log(`${springs}: what parts ${mean(4).toFixed(0)} ms, length of steps ${mean(5).toFixed(0)} ms, springs ${mean(6).toFixed(0)} ms; critical step ${before.toFixed(3)} ms, after a stroke ${mean(8).toFixed(3)} ms in the mean and ${Math.min(...found.map((row) => row[8])).toFixed(3)} ms at least`);
}

for (const springs of options.springs.split(',')) {
  const random = randomNumbers(Number(options.seed));
  const kernel = await startKernel(builtKernel);
  kernel.open(bodyNumbers(body));
  const begin = processor();
  kernel.reply([1, kernel.springs().indexOf(springs), 1, 5000, 0.45, 10, 0, 0]);
  const choosing = processor() - begin;
  if (springs === first) showMargins(kernel);
  if (options.strokes) showStrokes(kernel, springs);
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
      [times.find, times.check, times.springs].forEach((list, i) => list.push(1000 * answer[12 + i]));
      const [numGone, numTriangles] = [answer[16], answer[17]];
      if (!isClosed(answer.subarray(20 + numGone, 20 + numGone + 3 * numTriangles))) faults.push(`cut ${c}: open`);
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
