// How a probe moves, in the two models that are shown.
import type { ProbeMotion } from '../data/types.ts';
import { roundedUp } from '../picture/scale.ts';
import { element, svg } from './elements.ts';

const width = 280;
const height = 132;
const left = 40;
const bottom = 22;
const colours = ['var(--first)', 'var(--second)'];

/** @param now  time of the frame that is shown [s]; null for the static answer */
export function motionPlot(probe: string, motions: ProbeMotion[], now: number | null): Node[] {
  const finite = motions.flatMap((m) => Array.from(m.along)).filter(Number.isFinite);
  const end = Math.max(...motions.map((m) => m.time.at(-1) ?? 0)) || 1;
  const size = roundedUp(1000 * Math.max(...finite.map(Math.abs), 1e-9));
  const x = (seconds: number) => left + ((width - left - 6) * seconds) / end;
  const y = (mm: number) => 8 + ((height - bottom - 8) * (size - mm)) / (2 * size);
  const axes = [size, 0, -size].flatMap((mm) => [
    svg('line', { x1: left, x2: width - 6, y1: y(mm), y2: y(mm), class: 'grid' }),
    svg('text', { x: left - 6, y: y(mm) + 4, 'text-anchor': 'end' }, String(mm).replace('-', '−')),
  ]);
  const times = [0, end / 2, end].map((seconds, i) =>
    svg('text', { x: x(seconds), y: height - 4, 'text-anchor': ['start', 'middle', 'end'][i]! }, `${Number(seconds.toFixed(3))} s`));
  const lines = motions.map((motion, i) => {
    const points = Array.from(motion.along, (u, k) => [x(motion.time[k]!), y(1000 * u)]).filter(([, v]) => Number.isFinite(v));
    return svg('polyline', {
      points: points.map(([a, b]) => `${a!.toFixed(1)},${b!.toFixed(1)}`).join(' '),
      fill: 'none', style: `stroke: ${colours[i]}`, 'stroke-width': 1.6, 'stroke-linejoin': 'round',
    });
  });
  const cursor = now === null ? [] : [svg('line', { x1: x(now), x2: x(now), y1: 4, y2: height - bottom, class: 'now' })];
  const key = motions.map((m, i) => element('span', { style: `--colour: ${colours[i]}` }, m.model));
  return [
    element('h3', {}, `Motion of the ${probe} [mm]`),
    svg('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `Motion of the ${probe} over time` }, ...axes, ...times, ...lines, ...cursor),
    element('div', { class: 'key' }, ...key),
  ];
}
