// What the colours of the named parts of the surface mean.
import type { Result } from '../data/types.ts';
import { cssOf, patchColour } from '../picture/patch_colours.ts';
import { element } from './elements.ts';

export interface PatchEntry {
  name: string;
  colour: string; // for CSS
  area: number; // m^2, at rest
}

/** Of each named part of the surface. */
export function patchEntries({ patches, surfaces, points }: Result): PatchEntry[] {
  const { nodes, triangles } = surfaces.outside;
  const area = new Float64Array(patches.names.length);
  patches.patch.forEach((patch, t) => {
    const corner = (i: number) => [0, 1, 2].map((axis) => points[3 * nodes[triangles[3 * t + i]!]! + axis]!);
    const [a, b, c] = [corner(0), corner(1), corner(2)];
    const [u, v] = [b, c].map((p) => p.map((x, i) => x - a[i]!)) as [number[], number[]];
    area[patch]! += Math.hypot(u[1]! * v[2]! - u[2]! * v[1]!, u[2]! * v[0]! - u[0]! * v[2]!, u[0]! * v[1]! - u[1]! * v[0]!) / 2;
  });
  return patches.names.map((name, i) => ({ name: name.replaceAll('_', ' '), colour: cssOf(patchColour(i)), area: area[i]! }));
}

export function patchLegend(result: Result, note: string): Node[] {
  const entries = patchEntries(result).map(({ name, colour, area }) =>
    element('li', {}, element('span', { class: 'swatch', style: `background: ${colour}`, 'aria-hidden': 'true' }), `${name}, ${(1e4 * area).toFixed(0)} cm²`));
  const { confidence } = result.patches;
  const found = Number.isNaN(confidence) ? ''
    : `Found by the shape of the body, with a confidence of ${confidence.toFixed(2)} (1: no other orientation fits; 0: another one fits as well).`;
  return [
    element('ul', { class: 'patches', 'aria-label': 'Patches of the surface' }, ...entries),
    ...[found, note].filter(Boolean).map((sentence) => element('p', { class: 'note' }, sentence)),
  ];
}
