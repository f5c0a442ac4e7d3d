// Springs in the page itself, in a worker. Also works from a disk, and with files that were dropped.
import { Fault } from '../../data/types.ts';
import type { Question, Reply } from './kernel_worker.ts';
import KernelWorker from './kernel_worker.ts?worker&inline';
import { springsEngine } from './springs_engine.ts';
import type { Engine } from '../types.ts';

export function wasmEngine(): Engine {
  const worker = new KernelWorker();
  const waiting: ((reply: Reply) => void)[] = []; // in the order of the questions, which is that of the answers
  worker.onmessage = (event: MessageEvent<Reply>) => waiting.shift()?.(event.data);
  worker.onerror = (event) => {
    for (const answer of waiting.splice(0)) answer({ fault: `The springs do not start (${event.message}). Load the page again.` });
  };
  const ask = async (question: Question): Promise<Exclude<Reply, { fault: string }>> => {
    const reply = await new Promise<Reply>((resolve) => {
      waiting.push(resolve);
      worker.postMessage(question, [question.message.buffer]);
    });
    if ('fault' in reply) throw new Fault(reply.fault);
    return reply;
  };
  return springsEngine('WebAssembly', {
    async open(_, message) {
      const reply = await ask({ kind: 'open', message: message() });
      return 'springLaws' in reply ? reply.springLaws : '';
    },
    async ask(message) {
      const reply = await ask({ kind: 'ask', message });
      return 'bytes' in reply ? reply.bytes : new ArrayBuffer(0);
    },
    close: () => worker.terminate(),
  });
}
