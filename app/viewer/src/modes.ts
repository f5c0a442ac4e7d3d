// What one does with the file that is open: compare the answers in it, or set its body in motion.
import { Closed, type OpenFile } from './data/client.ts';
import { createLiveView, type LiveView } from './live/view.ts';
import type { LiveBody } from './live/types.ts';
import { byId } from './page/elements.ts';

export interface Modes {
  /** @param path  in the server's list; empty for a file from elsewhere @param view  of the link that it was opened with, or empty */
  opened(opened: OpenFile, path: string, view: URLSearchParams): Promise<void>;
  /** Nothing is left that could be compared or moved. */
  closed(): void;
  /** What a link says of the body that moves; null while models are compared. */
  liveLink(): URLSearchParams | null;
}

export interface ModeHooks {
  say(sentence: string): void;
  /** What went wrong with a file. */
  complain(name: string, error: unknown): void;
  /** A link would be another one now. */
  changed(): void;
}

const switches = () => byId<HTMLFieldSetElement>('mode');
const choice = (value: string) => switches().querySelector<HTMLInputElement>(`[value=${value}]`)!;

export function createModes({ say, complain, changed }: ModeHooks): Modes {
  let live: LiveView | null = null; // once somebody has asked for it
  let file: { opened: OpenFile; path: string; view: URLSearchParams; body: LiveBody | null } | null = null;

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
      complain(shown.opened.result.file, error);
    }
    if (shown !== file) return;
    const goesLive = choice('live').checked && shown.body !== null;
    byId('compare').hidden = goesLive;
    byId('live').hidden = !goesLive;
    if (!goesLive) return live?.hide();
    live ??= createLiveView(say, changed);
    await live.show(shown.opened.result, shown.body!, shown.view);
  }
  switches().addEventListener('change', () => {
    say('');
    changed();
    void show();
  });

  return {
    opened(opened, path, view) {
      file = { opened, path, view, body: null };
      switches().hidden = false;
      // A link says which of the two it was made in; a choice from the list changes nothing in that.
      if (view.size > 0) choice(view.get('mode') === 'live' ? 'live' : 'compare').checked = true;
      return show();
    },
    closed() {
      file = null;
      switches().hidden = byId('compare').hidden = byId('live').hidden = true;
      live?.hide();
    },
    // Before the springs are there it says no more than that they are wanted.
    liveLink: () => (file && choice('live').checked ? (live?.link() ?? new URLSearchParams({ mode: 'live' })) : null),
  };
}
