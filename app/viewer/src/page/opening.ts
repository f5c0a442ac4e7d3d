// Opening a file takes a while: the page says so, keeps what it shows until all of the new file is there, and can break it off.
import { openFile, type OpenExperiment, type OpenFile } from '../data/client.ts';
import { byId } from './elements.ts';
import type { Link } from './link.ts';

export type Load = (signal: AbortSignal, onProgress: (part: number) => void) => Promise<File> | File;

export interface Opening<Prepared> {
  /** Reads what is to be shown first. */
  prepare(file: OpenFile | OpenExperiment, link: Link): Promise<Prepared>;
  /** Shows it, in the place of what was open. */
  accept(prepared: Prepared, link: Link): void;
  /** What was open stays. @param error  null if the reader broke it off */
  refuse(name: string, error: unknown): void;
}

/** @return opens a file; the latest call counts */
export function createOpening<Prepared>({ prepare, accept, refuse }: Opening<Prepared>): (name: string, link: Link, load: Load) => Promise<void> {
  let current: AbortController | null = null;
  const progress = byId<HTMLProgressElement>('loaded');

  function sayLoading(name: string): void {
    byId('loading').hidden = false;
    byId('loading_name').textContent = `Opening ${name}…`;
    progress.removeAttribute('value');
    document.body.dataset['state'] = 'loading';
  }

  function end(): void {
    current = null;
    byId('loading').hidden = true;
    document.body.dataset['state'] = 'ready';
  }

  byId('cancel').addEventListener('click', () => {
    current?.abort();
    end();
    refuse('', null);
  });

  return async (name, link, load) => {
    current?.abort();
    const mine = new AbortController();
    current = mine;
    sayLoading(name);
    let file: OpenFile | OpenExperiment | null = null;
    try {
      const blob = await load(mine.signal, (part) => current === mine && (progress.value = part));
      if (mine.signal.aborted) return;
      file = await openFile(blob, mine.signal);
      const prepared = await prepare(file, link);
      if (mine.signal.aborted) return file.close();
      accept(prepared, link);
      end();
    } catch (error) {
      file?.close();
      if (mine.signal.aborted) return; // another file was chosen meanwhile, or none
      end();
      refuse(name, error);
    }
  };
}
