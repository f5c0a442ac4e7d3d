// Asks the worker that reads the file.
import type { Kind, Questions, Reply } from './messages.ts';
import { Fault } from './types.ts';
import ReadingWorker from './worker.ts?worker&inline';

const worker = new ReadingWorker();
const waiting = new Map<number, (reply: Reply) => void>();
let numAsked = 0;

worker.onmessage = (event: MessageEvent<Reply>) => {
  waiting.get(event.data.id)?.(event.data);
  waiting.delete(event.data.id);
};

/** @throws Fault with a sentence about the file */
export function ask<K extends Kind>(kind: K, question: Questions[K]['question']): Promise<Questions[K]['answer']> {
  return new Promise((resolve, reject) => {
    const id = numAsked++;
    waiting.set(id, (reply) => {
      if ('fault' in reply) reject(new Fault(reply.fault));
      else resolve(reply.answer as Questions[K]['answer']);
    });
    worker.postMessage({ id, kind, question });
  });
}
