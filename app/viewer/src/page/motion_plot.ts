// How a probe moves, in the two models that are shown.
import type { ProbeMotion } from '../data/types.ts';
import { roundedUp } from '../picture/scale.ts';
import { element, svg } from './elements.ts';
import { axesOf, keyOf, lineThrough } from './plot.ts';

const colours = ['var(--first)', 'var(--second)'];

/** @param now  time of the frame that is shown [s]; null for the static answer */
export function motionPlot(probe: string, motions: ProbeMotion[], now: number | null): Node[] {
  const finite = motions.flatMap((m) => Array.from(m.along)).filter(Number.isFinite);
  const end = Math.max(...motions.map((m) => m.time.at(-1) ?? 0)) || 1;
  const size = roundedUp(1000 * Math.max(...finite.map(Math.abs), 1e-9));
  const axes = axesOf(
    { low: 0, high: end, ticks: [0, end / 2, end], text: (seconds) => `${Number(seconds.toFixed(3))} s` },
    { low: -size, high: size, ticks: [size, 0, -size], text: (mm) => String(mm).replace('-', '−') });
  const lines = motions.map((motion, i) =>
    lineThrough(Array.from(motion.along, (u, k) => [axes.x(motion.time[k]!), axes.y(1000 * u)]), { colour: colours[i]!, dash: 'none' }));
  const cursor = now === null ? [] : [axes.cursor(now)];
  return [
    element('h3', {}, `Motion of the ${probe} [mm]`),
    svg('svg', { viewBox: axes.viewBox, role: 'img', 'aria-label': `Motion of the ${probe} over time` }, ...axes.marks, ...lines, ...cursor),
    keyOf(motions.map((m, i) => [m.model, colours[i]!])),
  ];
}
