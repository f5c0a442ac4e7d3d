// A plot of errors in the rows of a table, on a logarithmic axis.
import { svg } from './elements.ts';

/** Powers of ten around all errors. Errors of 1 % and of 300 % have to fit into one plot. */
export function decades(errors: number[]): [low: number, high: number] {
  const known = errors.filter((error) => error > 0 && Number.isFinite(error));
  if (known.length === 0) return [-2, 0];
  const low = Math.floor(Math.log10(Math.min(...known)));
  return [low, Math.max(Math.ceil(Math.log10(Math.max(...known))), low + 1)];
}

type Axis = (error: number) => number; // per cent of the width

function axisOf([low, high]: [number, number]): Axis {
  return (error) => 100 * Math.min(Math.max((Math.log10(error) - low) / (high - low), 0), 1);
}

function gridLines([low, high]: [number, number]): SVGElement[] {
  return Array.from({ length: high - low + 1 }, (_, i) => {
    const x = `${(100 * i) / (high - low)}%`;
    return svg('line', { x1: x, x2: x, y1: -5, y2: 33, class: 'grid' });
  });
}

/** @param text  of a power of ten */
export function axisLabels([low, high]: [number, number], text: (error: number) => string): SVGElement {
  const labels = Array.from({ length: high - low + 1 }, (_, i) =>
    svg('text', { x: `${(100 * i) / (high - low)}%`, y: 20, 'text-anchor': 'middle' }, text(10 ** (low + i))));
  return svg('svg', { 'aria-hidden': 'true' }, ...labels);
}

/** @param uncertainty  errors below it are shaded; 0 for none */
export function dot(range: [number, number], error: number, uncertainty: number, isShown: boolean): SVGElement {
  const parts = gridLines(range);
  const axis = axisOf(range);
  if (uncertainty > 0)
    parts.push(svg('rect', { x: 0, y: -5, width: `${axis(uncertainty)}%`, height: 38, class: 'uncertain' }));
  if (error > 0 && Number.isFinite(error)) {
    const x = `${axis(error)}%`;
    parts.push(svg('line', { x1: 0, x2: x, y1: 14, y2: 14, class: 'stem' }));
    parts.push(svg('circle', { cx: x, cy: 14, r: 5, class: isShown ? 'dot shown' : 'dot' }));
  }
  return svg('svg', { 'aria-hidden': 'true' }, ...parts);
}

/** A table that is laid out as blocks stays a table for who hears it. */
export function sayRoles(table: HTMLTableElement): void {
  table.setAttribute('role', 'table');
  for (const part of [table.tHead!, ...table.tBodies]) part.setAttribute('role', 'rowgroup');
  for (const line of table.rows) {
    line.setAttribute('role', 'row');
    for (const cell of line.cells) cell.setAttribute('role', cell.tagName === 'TH' ? 'columnheader' : 'cell');
  }
}
