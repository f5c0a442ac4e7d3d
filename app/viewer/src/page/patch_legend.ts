// What colours mean that are no numbers: named parts of the surface, and what a body is made of.
import type { Result } from '../data/types.ts';
import type { SurfaceLabel } from '../picture/body.ts';
import { cssOf, patchColour } from '../picture/patch_colours.ts';
import { tissueColours, tissueOfRegion, type Tissue } from '../picture/tissue.ts';
import { element } from './elements.ts';

type Vector = [number, number, number];

export interface ColourEntry {
  name: string;
  colour: string; // for CSS
  size: string; // at rest
}

/** The nodes of a facet, and its normal outwards, twice as long as its area. */
function facetOf({ surfaces, points }: Pick<Result, 'surfaces' | 'points'>, t: number): { corners: number[]; normal: Vector } {
  const { nodes, triangles } = surfaces.outside;
  const corners = [0, 1, 2].map((i) => nodes[triangles[3 * t + i]!]!);
  const [a, b, c] = corners.map((node) => [points[3 * node]!, points[3 * node + 1]!, points[3 * node + 2]!]) as [Vector, Vector, Vector];
  const [u, v] = [b, c].map((p) => p.map((x, i) => x - a[i]!)) as [Vector, Vector];
  return { corners, normal: [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]] };
}

/** Of each named part of the surface. */
export function patchEntries(result: Result): ColourEntry[] {
  const { patches } = result;
  const area = new Float64Array(patches.names.length);
  patches.patch.forEach((patch, t) => (area[patch]! += Math.hypot(...facetOf(result, t).normal) / 2));
  return patches.names.map((name, i) => ({ name: name.replaceAll('_', ' '), colour: cssOf(patchColour(i)), size: `${(1e4 * area[i]!).toFixed(0)} cm²` }));
}

/** The name of each part, its nodes, and which way these look. */
export function patchLabels(result: Pick<Result, 'patches' | 'surfaces' | 'points'>): SurfaceLabel[] {
  const { patches } = result;
  const outwards = patches.names.map(() => new Map<number, Vector>());
  patches.patch.forEach((patch, t) => {
    const { corners, normal } = facetOf(result, t);
    for (const corner of corners) outwards[patch]!.set(corner, (outwards[patch]!.get(corner) ?? [0, 0, 0]).map((x, i) => x + normal[i]!) as Vector);
  });
  return patches.names.map((name, patch) => ({
    name: name.replaceAll('_', ' '),
    nodes: Int32Array.from(outwards[patch]!.keys()),
    outwards: Float32Array.from([...outwards[patch]!.values()].flatMap((normal) => normal.map((x) => x / (Math.hypot(...normal) || 1)))),
  }));
}

/** What is there of tissue, lesions, and vessels that are regions. */
export function tissueEntries({ lesions, isAnatomical }: Result): ColourEntry[] {
  const of = (tissue: Tissue, name: string) => {
    const some = lesions.filter((lesion) => tissueOfRegion(lesion.name) === tissue);
    const volume = some.reduce((sum, lesion) => sum + lesion.volume, 0);
    return some.length > 0 ? [{ name: some.length > 1 ? `${some.length} ${name}s` : `1 ${name}`, colour: cssOf(tissueColours[tissue]), size: `${(1e6 * volume).toPrecision(3)} mL` }] : [];
  };
  return [{ name: isAnatomical ? 'liver' : 'body', colour: cssOf(tissueColours.parenchyma), size: '' }, ...of('lesion', isAnatomical ? 'lesion' : 'region inside'), ...of('vessel', 'vessel')];
}

export const listed = (entries: ColourEntry[], label: string) =>
  element('ul', { class: 'patches', 'aria-label': label }, ...entries.map(({ name, colour, size }) =>
    element('li', {}, element('span', { class: 'swatch', style: `background: ${colour}`, 'aria-hidden': 'true' }), [name, size].filter(Boolean).join(', '))));

export const tissueLegend = (result: Result): Node => listed(tissueEntries(result), 'What the body is made of');

export function patchLegend(result: Result, note: string): Node[] {
  const { confidence } = result.patches;
  const found = Number.isNaN(confidence) ? ''
    : `Found by the shape of the body, with a confidence of ${confidence.toFixed(2)} (1: no other orientation fits; 0: another one fits as well).`;
  return [
    listed(patchEntries(result), 'Patches of the surface'),
    ...[found, note].filter(Boolean).map((sentence) => element('p', { class: 'note' }, sentence)),
  ];
}
