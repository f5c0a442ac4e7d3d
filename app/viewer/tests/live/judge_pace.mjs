// How long hyperelastic elements take to judge the springs of the live page under a finger of 12 mm, and how long another question waits that
// interrupts them. Times are those of the clock.
//   node tests/live/judge_pace.mjs FOLDER FILE.h5 [--depths MM,...]
// FILE.h5 is a result of `livermark run` in the folder, such as liver_healthy/palpation.h5; several may be named.
import { join } from 'node:path';
import { parseArgs } from 'node:util';
import { startBrowser, startServer } from '../browser.mjs';
import { builtKernel, startKernel } from '../node_kernel.mjs';
import { bodyNumbers, bodyOf, frameOf } from '../springs.mjs';

const { values: options, positionals: [folder, ...files] } = parseArgs({ allowPositionals: true, options: { depths: { type: 'string', default: '1,5,12' } } });
if (files.length === 0) {
  console.error('name a folder and result files in it');
  process.exit(2);
}
const radius = 0.012;

/** The free node of the surface that is furthest in front. */
function frontOf({ points, triangles, constrained }) {
  const free = triangles.filter((_, i) => !constrained[Math.floor(i / 3)]), held = new Set(triangles.filter((_, i) => constrained[Math.floor(i / 3)]));
  const front = free.filter((node) => !held.has(node)).reduce((best, node) => (points[3 * node + 1] < points[3 * best + 1] ? node : best));
  return points.slice(3 * front, 3 * front + 3);
}

/** What the finger exerts after 2 s at a depth, as the page asks about it. */
function loadAt(kernel, step, [x, y, z], depth) {
  const numSteps = Math.round(1 / 60 / step);
  let answer;
  for (let time = 0; time < 2; time += numSteps * step)
    answer = kernel.reply([2, 1, x, y + Math.min(depth, 0.05 * time) - radius, z, radius, 0, numSteps]);
  const { disc, force, loadedFacets, tractions } = frameOf(Buffer.from(answer), { kind: 'probe', radius });
  return { force: Math.hypot(...force), rows: [...disc.middle, disc.radius, ...loadedFacets.flatMap((facet, i) => [facet, ...tractions.slice(3 * i, 3 * i + 3)])] };
}

const server = await startServer(folder, ['--no-browser']);
const browser = await startBrowser();
try {
  const page = await (await browser.newContext()).newPage();
  await page.goto(server.address);
  console.log('body, depth [mm], force [N]: linear [s]; hyperelastic [s], of which before the first iteration, and iterations; longest between two sentences [s]; interrupted after [s]');
  for (const file of files) {
    const body = await bodyOf(join(folder, file));
    const kernel = await startKernel(builtKernel);
    kernel.open(bodyNumbers(body));
    const [step] = new Float64Array(kernel.reply([1, kernel.springs().indexOf('nodal_neo_hookean'), 1, 5000, 0.45, 40, 0, 0]));
    await page.evaluate(async (file) => {
      const socket = new WebSocket(`ws://${location.host}/live/fem?${new URLSearchParams({ file })}`);
      socket.binaryType = 'arraybuffer';
      await new Promise((done) => (socket.onopen = done));
      /** @return times of all sentences before the answer, and of the answer [s] */
      window.ask = (message, onProgress = () => {}) => new Promise((done) => {
        const start = performance.now(), times = [];
        socket.onmessage = ({ data }) => {
          times.push((performance.now() - start) / 1000);
          const isProgress = typeof data === 'string' && data.startsWith('progress=');
          if (isProgress) onProgress(times.length);
          else done({ times, answer: typeof data === 'string' ? data : 'numbers' });
        };
        socket.send(typeof message === 'string' ? message : Float64Array.from(message));
      });
      /** Another message as soon as there are so many sentences. @return how long the answer to the first then takes [s] */
      window.interrupt = async (message, count) => {
        let asked = 0;
        const { times, answer } = await window.ask(message, (number) => {
          if (number !== count) return;
          asked = performance.now();
          socket.send('elements=linear');
        });
        if (!answer.startsWith('interrupted=')) throw new Error(answer);
        const waited = (performance.now() - asked) / 1000;
        await new Promise((done) => (socket.onmessage = done)); // the answer to the other one
        return waited;
      };
    }, file);
    for (const depth of options.depths.split(',').map(Number)) {
      const { force, rows } = loadAt(kernel, step, frontOf(body), depth / 1000);
      const ask = (message) => page.evaluate((message) => ask(message), message);
      await ask(rows); // makes what is made once
      const linear = await ask(rows);
      await ask('elements=hyperelastic');
      const { times } = await ask(rows);
      const gaps = times.slice(1).map((time, i) => time - times[i]);
      const waits = [];
      for (const count of [1, 2, 3]) {
        await ask('elements=hyperelastic');
        waits.push(await page.evaluate(([rows, count]) => interrupt(rows, count), [rows, count]));
      }
      const seconds = (list) => list.map((time) => time.toFixed(1)).join(', ');
      console.log(`${file}, ${depth}, ${force.toFixed(3)}: ${seconds(linear.times)}; ${seconds([times.at(-1), times[2]])}, ${times.length - 3}; ${seconds([Math.max(...gaps)])}; ${seconds(waits)}`);
    }
  }
} finally {
  await browser.close();
  await server.stop();
}
