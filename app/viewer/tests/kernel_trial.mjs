// A reckless user of the springs of the live page in WebAssembly, under Node or in the browser: says what was lost.
//   build/release/tests/live_trial --body liver_healthy --steps 700 --messages FILE
//   node app/viewer/tests/kernel_trial.mjs [--browser] FILE...
import { basename } from 'node:path';
import { frameOf, startHarness } from './springs.mjs';
import { builtKernel, startKernel } from './node_kernel.mjs';
import { bodyOfMessage, readMessages, rowOfMessage } from './trial.mjs';

const inBrowser = process.argv.includes('--browser');
const paths = process.argv.slice(2).filter((path) => path !== '--browser');
if (paths.length === 0) {
  console.error('name a file that live_trial --messages has written');
  process.exit(2);
}
const isFinite = (frame) => Object.values(frame).flat(Infinity).every((x) => typeof x === 'object' || Number.isFinite(x));

/** Pictures that answer the moves, from the kernel alone. */
async function* picturesUnderNode([body, ...messages]) {
  const kernel = await startKernel(builtKernel);
  kernel.open(body);
  for (const message of messages) {
    const answer = kernel.reply(message);
    if (message[0] !== 2) continue;
    const { restarts, smallestVolume, ...rest } = frameOf(Buffer.from(answer));
    yield { restarts, smallestVolume, finite: isFinite({ smallestVolume, ...rest }) };
  }
}

/** The same from the engine of the page, in an empty page of a browser. */
async function* picturesInBrowser([first, ...messages]) {
  const harness = await startHarness();
  try {
    const laws = await harness.open(bodyOfMessage(first));
    for (let i = 0; i < messages.length; i += 50) {
      const rows = messages.slice(i, i + 50).map((message) => rowOfMessage(message, laws));
      const answers = await harness.play(rows);
      for (const { restarts, smallestVolume, finite, force, indentation } of answers.filter((_, j) => rows[j].kind === 'move'))
        yield { restarts, smallestVolume, finite: finite && isFinite({ smallestVolume, force, indentation }) };
    }
  } finally {
    await harness.stop();
  }
}

for (const path of paths) {
  const messages = readMessages(path);
  const found = { pictures: 0, notFinite: 0, lost: 0, smallestVolume: 1 };
  let before = 0;
  for await (const { restarts, smallestVolume, finite } of (inBrowser ? picturesInBrowser : picturesUnderNode)(messages)) {
    ++found.pictures;
    found.notFinite += !finite;
    found.lost += Math.max(0, restarts - before); // other springs begin to count anew
    before = restarts;
    found.smallestVolume = Math.min(found.smallestVolume, smallestVolume);
  }
  const choices = messages.slice(1).filter(([kind]) => kind === 1).length;
  console.log(`${basename(path)}, ${inBrowser ? 'in the browser' : 'under Node'}: ${messages.length - 1} messages, ${found.pictures} pictures, ${choices} choices of springs; ${found.lost} motions lost, ${found.notFinite} pictures not finite; smallest volume ${found.smallestVolume.toFixed(2)}`);
  if (found.pictures === 0 || found.lost > 0 || found.notFinite > 0) process.exitCode = 1;
}
