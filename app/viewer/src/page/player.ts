// Plays the frames of a motion at their own speed.
import { byId } from './elements.ts';

export interface Player {
  stop(): void;
}

/**
 * @param times  of the frames [s]; none if nothing moves
 * @param frame  that is shown
 * @param show   shows another, and resolves when it is there
 */
export function createPlayer(times: () => number[], frame: () => number, show: (frame: number) => Promise<void>): Player {
  const button = byId('play');
  let isPlaying = false;

  function set(playing: boolean): void {
    isPlaying = playing;
    button.textContent = playing ? '❚❚' : '▶';
    button.setAttribute('aria-label', playing ? 'Pause' : 'Play');
  }

  async function play(): Promise<void> {
    set(true);
    const last = times().length - 1;
    const from = frame() >= last ? 0 : frame();
    const start = performance.now();
    // A machine that cannot keep up leaves frames out, and the motion still takes its time.
    while (isPlaying) {
      const time = times()[from]! + (performance.now() - start) / 1000;
      const next = times().findIndex((t) => t >= time);
      await show(next < 0 ? last : next);
      if (next < 0) set(false);
      await new Promise(requestAnimationFrame);
    }
  }

  button.addEventListener('click', () => (isPlaying ? set(false) : void play()));
  return { stop: () => set(false) };
}
