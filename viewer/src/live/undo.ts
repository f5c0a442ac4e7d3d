// Back to before the last tool: the hand as it was then. Where the body was, its engine keeps.
import { byId } from '../page/elements.ts';
import type { Hand } from './hand.ts';

export interface Undo {
  /** A tool is about to be taken. */
  keep(before: Hand): void;
  /** @return the hand as it was, once; null if there is nothing to go back to */
  take(): Hand | null;
  forget(): void;
}

const button = () => byId<HTMLButtonElement>('live-undo');

export function createUndo(): Undo {
  let kept: Hand | null = null;
  const set = (hand: Hand | null) => {
    kept = hand;
    button().disabled = hand === null;
  };
  return {
    keep: set,
    take() {
      const hand = kept;
      set(null);
      return hand;
    },
    forget: () => set(null),
  };
}
