// What plots over a number line share: axes, lines and the colours of models.
import { element, svg } from './elements.ts';

const width = 280;
const left = 40;
const [top, right, bottom] = [8, 6, 22];

/** A number line: where it goes, where its grid is, and how a place on it is written. */
export interface Axis {
  low: number;
  high: number;
  ticks: number[];
  text(value: number): string;
}

export interface Axes {
  x(value: number): number;
  y(value: number): number;
  /** Grid and numbers. */
  marks: SVGElement[];
  /** Cuts off what leaves the plot. */
  clipped(...content: SVGElement[]): SVGElement;
  /** A line across at a place of x. */
  cursor(value: number): SVGElement;
  /** From the middle between the neighbours of each place to that on its other side. */
  strips(values: number[]): SVGElement[];
  viewBox: string;
}

export function axesOf(across: Axis, up: Axis, height = 132): Axes {
  const [innerWidth, innerHeight] = [width - left - right, height - top - bottom];
  const x = (value: number) => left + (innerWidth * (value - across.low)) / (across.high - across.low || 1);
  const y = (value: number) => top + (innerHeight * (up.high - value)) / (up.high - up.low || 1);
  const anchor = (i: number, count: number) => (i === 0 ? 'start' : i === count - 1 ? 'end' : 'middle');
  const marks = [
    ...up.ticks.flatMap((value) => [
      svg('line', { x1: left, x2: width - right, y1: y(value), y2: y(value), class: 'grid' }),
      svg('text', { x: left - 6, y: y(value) + 4, 'text-anchor': 'end' }, up.text(value)),
    ]),
    ...across.ticks.map((value, i, all) => svg('text', { x: x(value), y: height - 4, 'text-anchor': anchor(i, all.length) }, across.text(value))),
  ];
  const box = { x: left, y: top - 4, width: innerWidth + right, height: innerHeight + 8 };
  return {
    x,
    y,
    marks,
    clipped: (...content) => svg('svg', { ...box, viewBox: `${box.x} ${box.y} ${box.width} ${box.height}` }, ...content),
    cursor: (value) => svg('line', { x1: x(value), x2: x(value), y1: top - 4, y2: height - bottom, class: 'now' }),
    strips: (values) => values.map((value, k) => {
      const from = k === 0 ? left : (x(values[k - 1]!) + x(value)) / 2;
      const to = k === values.length - 1 ? width : (x(value) + x(values[k + 1]!)) / 2;
      return svg('rect', { x: from, y: top - 4, width: to - from, height: innerHeight + 8, class: 'strip' });
    }),
    viewBox: `0 0 ${width} ${height}`,
  };
}

export interface Stroke {
  colour: string;
  dash: string; // of stroke-dasharray
}

const numColours = 7; // of style.css, --line-1 to --line-7
const dashes = ['none', '5 2.5', '1.5 2.5'];

/** The reference has the colour of the text, the others those of the style sheet, then the same with dashes. */
export function strokeOf(index: number): Stroke {
  return { colour: `var(--line-${(index % numColours) + 1})`, dash: dashes[Math.floor(index / numColours) % dashes.length]! };
}
export const referenceStroke: Stroke = { colour: 'var(--first)', dash: 'none' };

/** Through places of the picture. What is no number is left out. */
export function lineThrough(places: number[][], { colour, dash }: Stroke, strokeWidth = 1.6, more: Record<string, string> = {}): SVGElement {
  const points = places.filter((place) => place.every(Number.isFinite)).map(([a, b]) => `${a!.toFixed(3)},${b!.toFixed(3)}`);
  return svg('polyline', {
    points: points.join(' '), fill: 'none', style: `stroke: ${colour}`, 'stroke-width': strokeWidth, 'stroke-linejoin': 'round', 'stroke-dasharray': dash, ...more,
  });
}

/** A short piece of a line, for a key. */
export function sample({ colour, dash }: Stroke, strokeWidth = 1.6): SVGElement {
  return svg('svg', { viewBox: '0 0 20 8', class: 'sample', 'aria-hidden': 'true' },
    svg('line', { x1: 0, x2: 20, y1: 4, y2: 4, style: `stroke: ${colour}`, 'stroke-width': strokeWidth, 'stroke-dasharray': dash }));
}

export const keyOf = (names: [name: string, colour: string][]): HTMLElement =>
  element('div', { class: 'key' }, ...names.map(([name, colour]) => element('span', { style: `--colour: ${colour}` }, name)));
