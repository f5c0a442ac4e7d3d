// The force on the tool as an arrow in the picture, and how long an arrow is for a force.
import { byId } from '../../page/elements.ts';
import type { Stage } from '../../picture/stage.ts';
import { createColourRange } from '../colour_range.ts';
import type { LiveFrame } from '../types.ts';
import { length, type Vector } from '../vector.ts';

const longest = 0.35; // of the size of the body
const least = 0.5; // force that the longest arrow stands for, at least [N]
const room = 110; // for the arrow of the key [CSS pixels]

export interface ForceArrow {
  /** Of the force of a frame, drawn from the tool [m]. */
  of(frame: LiveFrame): { from: Vector; along: Vector };
  /** Says how long the arrow of a round force is on the screen now, or nothing while there is no tool. */
  showKey(stage: Stage, at: Vector | null): void;
}

/** @param size  of the body [m] */
export function createForceArrow(size: number): ForceArrow {
  // As with colours: the longest arrow is that of the forces of now.
  const range = createColourRange(1, least);
  const metresPerNewton = () => (longest * size) / range.end();
  return {
    of({ tool, force, grasp }) {
      range.see(length(force), performance.now() / 1000);
      // A hand leads two jaws at the point between them.
      const from = grasp ? (tool.map((x, i) => 0.5 * (x + grasp.other[i]!)) as Vector) : tool;
      return { from, along: force.map((f) => f * metresPerNewton()) as Vector };
    },
    showKey(stage, at) {
      const key = byId('live-arrow-key');
      key.hidden = at === null;
      if (!at) return;
      const pixelsPerNewton = metresPerNewton() / stage.screenAt(at).metresPerPixel;
      const power = 10 ** Math.floor(Math.log10(room / pixelsPerNewton));
      const newtons = Number((([5, 2, 1].find((digit) => digit * power * pixelsPerNewton <= room) ?? 1) * power).toPrecision(1));
      const text = `${newtons} N`;
      const pixels = Math.round(newtons * pixelsPerNewton);
      key.style.setProperty('--length', `${pixels}px`);
      Object.assign(key.dataset, { newtons: String(newtons), pixels: String(pixels) });
      if (key.textContent !== text) key.textContent = text;
    },
  };
}
