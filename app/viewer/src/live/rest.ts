// When a body has come to rest: nothing of it is stepped or drawn then.
import type { LiveFrame, Tool } from './types.ts';

/** Parts of the size of a body that its fastest node may go in a second: digits of forces keep nodes of stiff parts trembling, by less than they may get on. */
const trembling = 5e-3; // [1/s]
/** And how far the body may get from where it was at the beginning of that time, in every frame: it neither creeps nor swings. */
const creeping = 1e-5; // [1/s]
/** How long it has to be so: where a motion turns back it is slow for a moment. */
const longEnough = 0.25; // [s] of motion

export interface Rest {
  isReached(): boolean;
  /** @param tool  that the frame was asked for with */
  see(frame: LiveFrame, tool: Tool): void;
  disturb(): void;
}

function isSame(a: Tool, b: Tool): boolean {
  if (a.kind === 'none' || b.kind === 'none') return a.kind === b.kind;
  if (a.kind === 'needle' || b.kind === 'needle')
    return a.kind === 'needle' && b.kind === 'needle' && a.depth === b.depth && [...a.entry, ...a.target].every((x, i) => x === [...b.entry, ...b.target][i]);
  if (a.kind === 'grasp' && b.kind === 'grasp' && (a.depth !== b.depth || [...a.place, ...a.inwards].some((x, i) => x !== [...b.place, ...b.inwards][i])))
    return false;
  if (a.kind !== b.kind || a.radius !== b.radius || a.target.some((x, i) => x !== b.target[i])) return false;
  if (a.kind === 'plate' && b.kind === 'plate') return a.inwards.every((x, i) => x === b.inwards[i]);
  return a.kind !== 'pull' || b.kind !== 'pull' || a.node === b.node;
}

const largestDifference = (a: Float32Array, b: Float32Array) => a.reduce((most, x, i) => Math.max(most, Math.abs(x - b[i]!)), 0);

/** @param size  of the body [m] */
export function createRest(size: number): Rest {
  let start: LiveFrame | null = null; // of the time for which it has been slow
  let furthest = 0; // from there in all frames since [m]
  let isReached = false;
  let last: Tool = { kind: 'none' };
  return {
    isReached: () => isReached,
    see(frame, tool) {
      const isSlow = frame.largestSpeed <= trembling * size && isSame(tool, last);
      last = tool;
      if (!isSlow || !start) {
        start = isSlow ? frame : null;
        furthest = 0;
        return;
      }
      furthest = Math.max(furthest, largestDifference(frame.displacement, start.displacement));
      const passed = frame.time - start.time;
      if (passed < longEnough) return;
      isReached = furthest <= creeping * size * passed;
      [start, furthest] = [frame, 0];
    },
    disturb() {
      start = null;
      isReached = false;
    },
  };
}
