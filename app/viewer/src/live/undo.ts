// Back to before the last tool or cut: the tool and what there was of the body then. Where the body was, its engine keeps.
import { byId } from '../page/elements.ts';
import type { ToolState } from './tool/tool_state.ts';
import type { CutAnswer, CutRequest } from './tool/blade/types.ts';

/** What there was before. */
export interface Before {
  toolState: ToolState;
  cut: CutAnswer | null; // the last cut then
  cuts: CutRequest[]; // all of them
}

export interface Undo {
  /** A tool is about to be taken, or the body has been cut. */
  keep(before: Before): void;
  /** @return what there was, once; null if there is nothing to go back to */
  take(): Before | null;
  forget(): void;
}

const button = () => byId<HTMLButtonElement>('live-undo');

export function createUndo(): Undo {
  let kept: Before | null = null;
  const set = (before: Before | null) => {
    kept = before;
    button().disabled = before === null;
  };
  return {
    keep: set,
    take() {
      const before = kept;
      set(null);
      return before;
    },
    forget: () => set(null),
  };
}
