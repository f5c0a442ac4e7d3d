// A reckless user of the springs of the live page in WebAssembly, under Node: says what was lost.
//   build/release/tests/live_trial --body liver_healthy --steps 700 --messages FILE
//   node viewer/tests/kernel_trial.mjs FILE...
import { basename } from 'node:path';
import { frameOf } from './springs.mjs';
import { builtKernel, startKernel } from './node_kernel.mjs';
import { readMessages } from './trial.mjs';

const paths = process.argv.slice(2);
if (paths.length === 0) {
  console.error('name a file that live_trial --messages has written');
  process.exit(2);
}
const isFinite = (frame) => Object.values(frame).flat(Infinity).every((x) => typeof x === 'object' || Number.isFinite(x));
for (const path of paths) {
  const kernel = await startKernel(builtKernel);
  const [body, ...messages] = readMessages(path);
  kernel.open(body);
  const found = { choices: 0, pictures: 0, notFinite: 0, restarts: 0, smallestVolume: 1 };
  for (const message of messages) {
    const answer = kernel.reply(message);
    if (message[0] === 1) ++found.choices;
    if (message[0] !== 2) continue;
    const frame = frameOf(Buffer.from(answer));
    ++found.pictures;
    found.notFinite += !isFinite(frame);
    found.restarts = frame.restarts;
    found.smallestVolume = Math.min(found.smallestVolume, frame.smallestVolume);
  }
  console.log(`${basename(path)}: ${messages.length} messages, ${found.pictures} pictures, ${found.choices} choices of springs; ${found.restarts} motions lost, ${found.notFinite} pictures not finite; smallest volume ${found.smallestVolume.toFixed(2)}`);
  if (found.restarts > 0 || found.notFinite > 0) process.exitCode = 1;
}
