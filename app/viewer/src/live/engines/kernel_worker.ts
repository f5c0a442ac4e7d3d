// Moves the springs off the thread that draws. One message after the other; each gets one reply.
import { Fault } from '../../data/types.ts';
import { startKernel, type Kernel } from './kernel.ts';
import code from '../../../../../build/wasm/livermark.wasm?url&inline';

export type Question = { kind: 'open' | 'ask'; message: Float64Array };
export type Reply = { bytes: ArrayBuffer } | { springLaws: string } | { fault: string };

// Not fetched: a page that opens from a disk may not.
const decoded = Uint8Array.from(atob(code.slice(code.indexOf(',') + 1)), (character) => character.charCodeAt(0));
const compiled = WebAssembly.compile(decoded);
let kernel: Kernel | null = null;

async function reply({ kind, message }: Question): Promise<Reply> {
  try {
    if (kind === 'open') {
      kernel = await startKernel(await compiled);
      kernel.open(message);
      return { springLaws: kernel.springLaws() };
    }
    if (!kernel) throw new Fault('No body is open.');
    return { bytes: kernel.reply(message) };
  } catch (error) {
    if (error instanceof Fault) return { fault: error.message };
    kernel = null; // nobody knows in which state it is
    return { fault: `The springs have stopped (${String(error)}). Open the file again.` };
  }
}

let last: Promise<void> = Promise.resolve();
self.onmessage = (event: MessageEvent<Question>) => {
  last = last.then(async () => {
    const answer = await reply(event.data);
    self.postMessage(answer, { transfer: 'bytes' in answer ? [answer.bytes] : [] });
  });
};
