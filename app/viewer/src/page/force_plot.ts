// Force against way of a place that moves: every model beside the reference with its band.
import type { ForceCurve, ForcePlot, Result } from '../data/types.ts';
import { percent, roundedUp, short } from '../picture/scale.ts';
import { element, svg } from './elements.ts';
import { axesOf, lineThrough, referenceStroke, sample, strokeOf, type Axes, type Axis, type Stroke } from './plot.ts';

const height = 160;

interface Line extends ForceCurve {
  stroke: Stroke;
  width: number;
}

/** All that is finite of those models, and the band. The ones that failed do not stretch the axis, if there are others. */
function axisOfForce(plot: ForcePlot, result: Result): Axis {
  const sound = plot.curves.filter(({ model }) => result.models.find((m) => m.name === model)?.status === 'ok');
  const band = plot.curves.filter(({ model }) => model === result.reference)
    .flatMap(({ force }) => force.flatMap((f, k) => [f - (plot.uncertain[k] ?? 0), f + (plot.uncertain[k] ?? 0)]));
  const forces = [...(sound.length > 0 ? sound : plot.curves).flatMap(({ force }) => force), ...band].filter(Number.isFinite);
  const [least, most] = [Math.min(0, ...forces), Math.max(0, ...forces)];
  const high = most > 0.02 * -least ? roundedUp(most) : 0;
  const low = -least > 0.02 * most ? -roundedUp(-least) : 0;
  const ticks = [...new Set([high, high / 2, 0, ...(low < 0 ? [low] : [])])];
  return { low, high: high > low ? high : 1, ticks, text: (newton) => (newton === 0 ? '0' : String(Number(newton.toPrecision(4))).replace('-', '−')) };
}

function bandOf(axes: Axes, plot: ForcePlot, reference: ForceCurve | undefined, ways: number[]): SVGElement[] {
  if (!reference || plot.uncertain.length === 0) return [];
  const edge = (sign: number) => [[axes.x(0), axes.y(0)], ...reference.force.map((f, k) => [axes.x(ways[k]!), axes.y(f + sign * plot.uncertain[k]!)])];
  const places = [...edge(1), ...edge(-1).reverse()].filter((place) => place.every(Number.isFinite));
  return [svg('polygon', { points: places.map(([a, b]) => `${a!.toFixed(3)},${b!.toFixed(3)}`).join(' '), class: 'band' })];
}

const newton = (value: number | undefined) => (value === undefined ? '–' : short(value));

/** The models in the order of the file, the reference first. */
function linesOf(plot: ForcePlot, result: Result, shown: string[]): Line[] {
  const isReference = ({ model }: ForceCurve) => model === result.reference;
  const others = plot.curves.filter((curve) => !isReference(curve));
  const width = (model: string) => (shown.includes(model) ? 2.6 : 1.3);
  return [
    ...plot.curves.filter(isReference).map((curve) => ({ ...curve, stroke: referenceStroke, width: width(curve.model) })),
    ...others.map((curve, i) => ({ ...curve, stroke: strokeOf(i), width: width(curve.model) })),
  ];
}

/**
 * @param now       point of the path that is shown
 * @param onChoose  called with a point that was clicked
 */
function onePlot(plot: ForcePlot, result: Result, shown: string[], now: number, onChoose: (point: number) => void): Node[] {
  const ways = result.loads.map((part) => 1000 * part * plot.way);
  const lines = linesOf(plot, result, shown);
  const up = axisOfForce(plot, result);
  const end = ways.at(-1)!;
  const axes = axesOf({ low: 0, high: end, ticks: [0, end / 2, end], text: (mm) => `${mm === 0 ? '0' : short(mm)} mm` }, up, height);
  // A body at rest without loads pushes nobody.
  const drawn = [...lines].reverse().map(({ model, force, stroke, width }) =>
    lineThrough([[axes.x(0), axes.y(0)], ...force.map((f, k) => [axes.x(ways[k]!), axes.y(f)])], stroke, width, { 'data-model': model }));
  const cursor = axes.cursor(ways[now]!);
  const at = element('span');
  const rows = lines.map(({ model, force, stroke, width }) => {
    const value = element('span', { class: 'value' });
    const name = model === result.reference ? `${model} (reference)` : model;
    const line = element('li', { 'data-model': model, ...(shown.includes(model) ? { class: 'shown' } : {}) }, sample(stroke, width), element('span', {}, name), value);
    return { line, value, force };
  });
  const say = (point: number) => {
    at.textContent = `At ${short(ways[point]!)} mm [N]:`;
    for (const { value, force } of rows) value.textContent = newton(force[point]);
    for (const side of ['x1', 'x2']) cursor.setAttribute(side, String(axes.x(ways[point]!)));
  };
  const strips = axes.strips(ways).map((strip, point) => {
    const values = lines.map(({ model, force }) => `${model} ${newton(force[point])} N`).join(', ');
    const attributes = { tabindex: '0', role: 'button', 'data-key': `${plot.place} ${point}`, 'aria-pressed': String(point === now),
      'aria-label': `${Number((100 * result.loads[point]!).toPrecision(3))} % of the load, ${short(ways[point]!)} mm: ${values}` };
    for (const [name, value] of Object.entries(attributes)) strip.setAttribute(name, value);
    for (const event of ['pointerenter', 'focus']) strip.addEventListener(event, () => say(point));
    for (const event of ['pointerleave', 'blur']) strip.addEventListener(event, () => say(now));
    strip.addEventListener('click', () => onChoose(point));
    strip.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter' && event.key !== ' ') return;
      event.preventDefault();
      onChoose(point);
    });
    return strip;
  });
  say(now);
  const reference = plot.curves.find(({ model }) => model === result.reference);
  const place = plot.place.replaceAll('_', ' ');
  return [
    element('h3', {}, `Force at the ${place} [N]`),
    svg('svg', { viewBox: axes.viewBox, role: 'group', 'aria-label': `Force at the ${place} against its way`, 'data-place': plot.place, 'data-low': up.low, 'data-high': up.high, 'data-end-mm': end },
      ...axes.marks, axes.clipped(...bandOf(axes, plot, reference, ways), ...drawn), cursor, ...strips),
    element('div', { class: 'at' }, at),
    element('ul', { class: 'forces' }, ...rows.map(({ line }) => line)),
  ];
}

/** Of every place that moves. */
export function forcePlots(plots: ForcePlot[], result: Result, shown: string[], now: number, onChoose: (point: number) => void): Node[] {
  const [first] = plots;
  const observed = first && first.observedAt < 1 ? `, observed at ${Number((100 * first.observedAt).toPrecision(3))} % of the load` : '';
  const band = first && first.uncertain.length > 0
    ? ` Shaded: what the reference is uncertain by, ${percent(first.relative)} % of its reactions at all places together${observed}.` : '';
  return [
    ...plots.flatMap((plot) => onePlot(plot, result, shown, now, onChoose)),
    element('p', { class: 'hint' }, `On the body, along the way of the place.${band} A click shows that part of the load.`),
  ];
}
