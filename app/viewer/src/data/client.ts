// Asks the worker that reads a file. Each file has a worker of its own: no answer can be about another file, a file that is refused or
// broken off leaves the others as they were, and one that breaks the HDF5 library breaks no other.
import type { Experiment } from './experiment.ts';
import type { Kind, Questions, Reply } from './messages.ts';
import { Fault, type Result } from './types.ts';
import ReadingWorker from './worker.ts?worker&inline';

type Ask = <K extends Kind>(kind: K, question: Questions[K]['question']) => Promise<Questions[K]['answer']>;

export interface OpenFile {
  result: Result;
  /** @throws Fault with a sentence about the file; Closed if the file is closed before the answer is there */
  ask: Ask;
  close(): void;
}

/** All of it was read. */
export interface OpenExperiment {
  experiment: Experiment;
  close(): void;
}

/** What is asked of a file that was closed has no answer, and nobody needs one. */
export class Closed extends Error {}

interface Reader {
  ask: Ask;
  close(): void;
}

function startReader(): Reader {
  const worker = new ReadingWorker();
  const waiting = new Map<number, { settle(reply: Reply): void; fail(error: Error): void }>();
  let numAsked = 0;
  let end: Error | null = null;
  const stop = (error: Error) => {
    end ??= error;
    worker.terminate();
    for (const { fail } of waiting.values()) fail(end);
    waiting.clear();
  };
  worker.onmessage = (event: MessageEvent<Reply>) => {
    waiting.get(event.data.id)?.settle(event.data);
    waiting.delete(event.data.id);
  };
  worker.onerror = (event) => stop(new Fault(`It cannot be read (${event.message}). Make it again with livermark run.`));
  return {
    ask: <K extends Kind>(kind: K, question: Questions[K]['question']) =>
      new Promise<Questions[K]['answer']>((resolve, reject) => {
        if (end) return reject(end);
        const id = numAsked++;
        const settle = (reply: Reply) =>
          'fault' in reply ? reject(new Fault(reply.fault)) : resolve(reply.answer as Questions[K]['answer']);
        waiting.set(id, { settle, fail: reject });
        worker.postMessage({ id, kind, question });
      }),
    close: () => stop(new Closed()),
  };
}

// The HDF5 library takes a moment to start: one reader waits for the next file.
let spare = startReader();

/**
 * @param signal  closes it, at any time
 * @throws Fault with a sentence about the file; Closed if it was broken off
 */
export async function openFile(file: File, signal: AbortSignal): Promise<OpenFile | OpenExperiment> {
  const reader = spare;
  spare = startReader();
  signal.addEventListener('abort', reader.close);
  try {
    const content = await reader.ask('open', { file });
    if ('experiment' in content) reader.close();
    return { ...content, ...reader };
  } catch (error) {
    reader.close();
    throw error;
  }
}
