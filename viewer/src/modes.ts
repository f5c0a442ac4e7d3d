// What one does with the file that is open: compare the answers in it, or set its body in motion.
import { Closed, type OpenFile } from './data/client.ts';
import { createLiveView, type LiveView } from './live/view.ts';
import type { LiveBody } from './live/types.ts';
import { byId } from './page/elements.ts';

export interface Modes {
  /** @param path  in the server's list; empty for a file from elsewhere */
  opened(opened: OpenFile, path: string): Promise<void>;
}

const switches = () => byId<HTMLFieldSetElement>('mode');
const choice = (value: string) => switches().querySelector<HTMLInputElement>(`[value=${value}]`)!;

/** @param onFault  is told what went wrong with a file */
export function createModes(say: (sentence: string) => void, onFault: (name: string, error: unknown) => void): Modes {
  let live: LiveView | null = null; // once somebody has asked for it
  let file: { opened: OpenFile; path: string; body: LiveBody | null } | null = null;

  async function show(): Promise<void> {
    if (!file) return;
    const shown = file;
    const isLive = choice('live').checked;
    try {
      shown.body ??= isLive ? { file: shown.path, ...(await shown.opened.ask('body', null)) } : null;
    } catch (error) {
      if (shown !== file || error instanceof Closed) return;
      // Nothing of it can move: it can still be compared.
      choice('compare').checked = true;
      onFault(shown.opened.result.file, error);
    }
    if (shown !== file) return;
    const goesLive = choice('live').checked && shown.body !== null;
    byId('compare').hidden = goesLive;
    byId('live').hidden = !goesLive;
    if (!goesLive) return live?.hide();
    live ??= createLiveView(say);
    await live.show(shown.opened.result, shown.body!);
  }
  switches().addEventListener('change', () => {
    say('');
    void show();
  });

  return {
    opened(opened, path) {
      file = { opened, path, body: null };
      switches().hidden = false;
      return show();
    },
  };
}
