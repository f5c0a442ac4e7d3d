// Back to before the last tool: its state as it was then. Where the body was, its engine keeps.
import { byId } from '../page/elements.ts';
import type { ToolState } from './tool/tool_state.ts';

export interface Undo {
  /** A tool is about to be taken. */
  keep(before: ToolState): void;
  /** @return the state of the tool as it was, once; null if there is nothing to go back to */
  take(): ToolState | null;
  forget(): void;
}

const button = () => byId<HTMLButtonElement>('live-undo');

export function createUndo(): Undo {
  let kept: ToolState | null = null;
  const set = (toolState: ToolState | null) => {
    kept = toolState;
    button().disabled = toolState === null;
  };
  return {
    keep: set,
    take() {
      const toolState = kept;
      set(null);
      return toolState;
    },
    forget: () => set(null),
  };
}
