// How fast the springs of the live page move in WebAssembly: a finger of 10 mm goes 10 mm deep and out again once in a
// second of motion, and a picture is asked for 60 times in it. Times are those of the processor.
//   node tests/kernel_pace.mjs RESULT.h5 [--springs NAME,...] [--poisson NUMBER,...] [--seconds NUMBER] [--kernel FILE.wasm]
import { basename, dirname } from 'node:path';
import { parseArgs } from 'node:util';
import { builtKernel, startKernel } from './node_kernel.mjs';
import { bodyNumbers, bodyOf } from './springs.mjs';

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    springs: { type: 'string', default: 'patch,nodal_neo_hookean' },
    poisson: { type: 'string', default: '0.45' },
    seconds: { type: 'string', default: '1' },
    kernel: { type: 'string', default: builtKernel },
  },
});
if (positionals.length === 0) {
  console.error('name a result file of livermark run');
  process.exit(2);
}

/** The free node of the surface that is furthest in front. */
function frontOf(body) {
  const isFree = new Array(body.points.length / 3).fill(true), isOutside = isFree.map(() => false);
  body.triangles.forEach((node, i) => {
    isOutside[node] = true;
    if (body.constrained[Math.floor(i / 3)]) isFree[node] = false;
  });
  const nodes = isFree.flatMap((free, node) => (free && isOutside[node] ? [node] : []));
  const front = nodes.reduce((best, node) => (body.points[3 * node + 1] < body.points[3 * best + 1] ? node : best));
  return body.points.slice(3 * front, 3 * front + 3);
}

/** Of the processor, in which other programs do not count [ms]. */
const now = () => Object.values(process.cpuUsage()).reduce((sum, each) => sum + each / 1000, 0);
const percentile = (sorted, part) => sorted[Math.ceil(part * sorted.length) - 1];
const milliseconds = (part) => part.toFixed(3);

console.log('body, springs, Poisson\'s ratio: step [ms], over the critical one at rest and over the longest of a pressed body; steps and picture of 1/60 s 50 %, 95 % [ms]; pace; to choose [ms]');
for (const path of positionals) {
  const body = await bodyOf(path);
  const [x, y, z] = frontOf(body);
  for (const name of options.springs.split(','))
    for (const ratio of options.poisson.split(',').map(Number)) {
      const kernel = await startKernel(options.kernel);
      kernel.open(bodyNumbers(body));
      const begin = now();
      const [timeStep, , critical, pressed] = new Float64Array(kernel.reply([1, kernel.springs().indexOf(name), 1, 5000, ratio, 10, 0, 0]));
      const toChoose = now() - begin;
      const took = [];
      const numSteps = Math.ceil(1 / 60 / timeStep);
      const picture = numSteps * timeStep;
      while (took.length * picture < Number(options.seconds)) {
        const depth = 0.005 * (1 - Math.cos(2 * Math.PI * took.length * picture));
        const before = now();
        kernel.reply([2, 1, x, y + depth - 0.01, z, 0.01, 0, numSteps]);
        took.push(now() - before);
      }
      const pace = (1000 * picture * took.length) / took.reduce((sum, each) => sum + each, 0);
      took.sort((a, b) => a - b);
      console.log(`${basename(dirname(path))}, ${name}, ${ratio}: ${milliseconds(1000 * timeStep)}, ${(timeStep / critical).toFixed(2)}, ${(timeStep / pressed).toFixed(2)}; ` +
        `${milliseconds(percentile(took, 0.5))}, ${milliseconds(percentile(took, 0.95))}; ${pace.toFixed(2)}; ${toChoose.toFixed(0)}`);
    }
}
