// The numbers of the body that moves. Each element also has its number as it is, in data-value.
import { byId } from '../page/elements.ts';
import { millimetres, short } from '../picture/scale.ts';
import type { Timing } from './session.ts';
import { whySlow, type Circumstances, type Remedy } from './steps.ts';
import type { LiveFrame } from './types.ts';
import { length } from './vector.ts';

/** Text and value of an output. @param value  in SI units; NaN where there is none */
export function tell(id: string, value: number, text: string): void {
  const output = byId(id);
  output.dataset['value'] = String(value);
  if (output.textContent !== text) output.textContent = text;
}

export function showFrame(frame: LiveFrame, numSteps: number): void {
  const force = length(frame.force);
  tell('live-force', force, `${force.toFixed(2)} N`);
  tell('live-indentation', frame.indentation, `${(1000 * frame.indentation).toFixed(2).replace('-', '−')} mm`);
  tell('live-volume', frame.smallestVolume, short(frame.smallestVolume));
  tell('live-time', frame.time, `${frame.time.toFixed(2)} s`);
  tell('live-steps', numSteps, String(numSteps));
  const times = frame.restarts === 1 ? 'once' : `${frame.restarts} times`;
  tell('live-restarts', frame.restarts, frame.restarts === 0 ? '' : `The motion left all bounds ${times} and was set back to rest: push less, or take a shorter time step.`);
  byId('live-restarts').hidden = frame.restarts === 0;
}

function median(values: number[]): number {
  const sorted = [...values].sort((a, b) => a - b);
  const middle = sorted.length >> 1;
  return sorted.length % 2 === 1 ? sorted[middle]! : (sorted[middle - 1]! + sorted[middle]!) / 2;
}

/** The smallest of them that 95 of 100 do not exceed. */
function percentile95(values: number[]): number {
  return [...values].sort((a, b) => a - b)[Math.ceil(0.95 * values.length) - 1] ?? Number.NaN;
}

export const remedies: Record<Remedy, string> = { native: 'live-faster', longest: 'live-longest-steps', opaque: 'live-opaque' };

function showRemedies(some: readonly Remedy[]): void {
  for (const [remedy, id] of Object.entries(remedies)) byId(id).hidden = !some.includes(remedy as Remedy);
}

/**
 * Where the force is read: a body that is slower than life also answers a tool later.
 * @param simulated, solving  of a second of real time: how much motion there was, and how long steps took
 * @param parts               of a step in the mean
 */
function showPace(simulated: number, solving: number, parts: number, circumstances: Circumstances): void {
  const isSlow = simulated <= 0.97;
  const times = Number((1 / simulated).toPrecision(2));
  // Steps alone do not let it be faster, or something else takes the time.
  const isDrawn = solving <= simulated * 0.97;
  const { why, remedies } = whySlow(circumstances, solving / simulated, parts, isDrawn);
  tell('live-pace-now', simulated, simulated.toFixed(2));
  tell('live-pace', simulated, isSlow ? `Slower than real time: 1 s of motion takes ${times} s, because ${why}.` : '');
  byId('live-pace').hidden = !isSlow;
  showRemedies(isSlow ? remedies : []);
}

const span = 1; // that medians and the pace are taken over [s]
const longSpan = 5; // that the 95th percentile is taken over [s]
const frame = 1 / 60; // of the screen [s]

/** How a frame of the screen is spent, over the last seconds. */
export interface Budget {
  spend(timing: Timing): void;
  /** Nothing moves. */
  rest(): void;
  draw(seconds: number): void;
}

/** @param circumstances  of now; null before there are springs */
export function createBudget(circumstances: () => Circumstances | null): Budget {
  let spent: (Timing & { at: number })[] = [];
  let work: { at: number; seconds: number }[] = []; // that each answer took for a frame of motion
  let drawn: { at: number; seconds: number }[] = [];
  let shownAt = 0;

  function show(now: number): void {
    if (now - shownAt < 0.25) return; // no faster than one can read
    shownAt = now;
    spent = spent.filter(({ at }) => at > now - span);
    drawn = drawn.filter(({ at }) => at > now - span);
    work = work.filter(({ at }) => at > now - longSpan);
    if (work.length > 0) {
      const most = percentile95(work.map(({ seconds }) => seconds));
      tell('live-work', most, `${millimetres(most)} of ${millimetres(frame)} ms`);
    }
    const milliseconds = (id: string, values: number[]) => tell(id, median(values), values.length === 0 ? '–' : `${millimetres(median(values))} ms`);
    milliseconds('live-solver', spent.map((t) => t.solver));
    milliseconds('live-transfer', spent.map((t) => t.transfer));
    milliseconds('live-drawing', drawn.map(({ seconds }) => seconds));
    const sum = (of: (t: Timing) => number) => spent.reduce((total, t) => total + of(t), 0);
    // The first steps are few, to see how long they take.
    const elapsed = sum((t) => t.elapsed);
    const here = circumstances();
    if (here && elapsed > 0.5 * span)
      showPace(sum((t) => t.simulated) / elapsed, sum((t) => t.solver) / elapsed, sum((t) => t.numEvaluations) / sum((t) => t.numSteps), here);
  }
  return {
    spend(timing) {
      const now = performance.now() / 1000;
      if (timing.elapsed > 0) spent.push({ ...timing, at: now });
      if (timing.simulated > 0) work.push({ at: now, seconds: (timing.solver / timing.simulated) * frame });
      show(now);
    },
    rest() {
      spent = [];
      byId('live-pace').hidden = true;
      showRemedies([]);
    },
    draw: (seconds) => drawn.push({ at: performance.now() / 1000, seconds }),
  };
}
