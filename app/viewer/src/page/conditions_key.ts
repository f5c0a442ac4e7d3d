// What the load case prescribes, in words: beside the picture, and at a node.
import type { Result } from '../data/types.ts';
import { facetsMarked, facetState, facetStates, largestOf, valueOf, vectorOf, type FacetMark, type FacetState } from '../picture/facet_conditions.ts';
import { short } from '../picture/scale.ts';
import { element } from './elements.ts';

const words: Record<FacetMark, string> = { fixed: 'Constrained', sliding: 'Slides', moved: 'Moved', loaded: 'Traction', supported: 'On elastic springs' };

const spoken = (name: string) => name.replaceAll('_', ' ');

/** Names of the places that are marked by this. */
function placesOf({ conditions }: Result, mark: FacetMark): string[] {
  return [...new Set(facetsMarked(conditions, mark).map((facet) => spoken(conditions.names[conditions.name[facet]!] ?? '')))].filter(Boolean);
}

/** 600 Pa or 1.2 kPa; 0.5 mm. */
function sizeOf(state: 'moved' | 'loaded', value: number): string {
  if (state === 'moved') return `${short(1000 * value)} mm`;
  return value >= 1000 ? `${short(value / 1000)} kPa` : `${short(value)} Pa`;
}

function bodyForce({ conditions, isAnatomical }: Result, load: number): string {
  const [x, y, z] = conditions.acceleration.map((a) => load * a) as [number, number, number];
  const size = Math.hypot(x, y, z);
  if (!(size > 0)) return '';
  const ends = isAnatomical ? [['right', 'left'], ['front', 'back'], ['feet', 'head']] : [['−x', '+x'], ['−y', '+y'], ['−z', '+z']];
  const parts = [x, y, z].flatMap((a, axis) => (Math.abs(a) > 0.01 * size ? [`${short(Math.abs(a))} m/s² to ${ends[axis]![a > 0 ? 1 : 0]}`] : []));
  return `Weight: ${parts.join(', ')}`;
}

/** How stiff springs below facets are: 100 Pa per mm, along the normal alone. */
function springsOf({ conditions: { foundation } }: Result, facets: readonly number[]): string {
  const wanted = new Set(facets);
  const which = foundation ? Array.from(foundation.facets.keys()).filter((i) => wanted.has(foundation.facets[i]!)) : [];
  const stiffness = which.map((i) => foundation!.stiffness[i]!);
  const ends = [stiffness.reduce((a, b) => Math.min(a, b), Infinity), stiffness.reduce((a, b) => Math.max(a, b), 0)];
  const size = [...new Set(ends.map((k) => sizeOf('loaded', 1e-3 * k)))].join(' to ');
  const numNormal = which.filter((i) => foundation!.normalOnly[i] === 1).length;
  const along = numNormal === 0 ? '' : numNormal === which.length ? ', along the normal alone' : ', in parts along the normal alone';
  return `${size} per mm${along}`;
}

/** Whose force is not known before. @param depth  m */
const pressed = (places: string[], depth: number) => `Pressed: ${places.join(', ')}; by ${sizeOf('moved', depth)} in the mean`;

/**
 * The key to patterns and arrows.
 * @param isReleased  tractions are let go
 * @param load        part of the load that is applied
 */
export function conditionsKey(result: Result, isReleased: boolean, load: number): Node[] {
  const entries = facetStates.flatMap((state) => {
    const places = placesOf(result, state);
    if (places.length === 0 || (state === 'loaded' && isReleased)) return [];
    const arrow = state === 'moved' || state === 'loaded' ? `; longest arrow ${sizeOf(state, load * largestOf(result.conditions, state))}` : '';
    const depth = result.conditions.pressDepth ?? 0;
    const sentence = state === 'loaded' && depth !== 0 ? pressed(places, load * depth) : `${words[state]}: ${places.join(', ')}${arrow}`;
    return [element('li', { class: state }, element('span', { class: `swatch ${state}`, 'aria-hidden': 'true' }), sentence)];
  });
  const weight = bodyForce(result, load);
  return [...entries, ...supportedKey(result), ...weight ? [element('li', {}, weight)] : []];
}

/** The entry of what stands on springs, if anything does. */
export function supportedKey(result: Result): Node[] {
  const places = placesOf(result, 'supported');
  if (places.length === 0) return [];
  return [element('li', { class: 'supported' }, element('span', { class: 'swatch supported', 'aria-hidden': 'true' }),
    `${words.supported}: ${places.join(', ')}; ${springsOf(result, facetsMarked(result.conditions, 'supported'))}`)];
}

/** What a part of the load prescribes on the facets around a node, each thing once; nothing if it is inside. */
export function conditionsAt(result: Result, node: number, load: number): string[] {
  const { conditions, surfaces } = result;
  const { nodes, triangles } = surfaces.outside;
  const vertex = nodes.indexOf(node);
  if (vertex < 0) return [];
  const around = [...new Set(Array.from(triangles.keys()).filter((i) => triangles[i] === vertex).map((i) => Math.floor(i / 3)))];
  const onSprings = new Set(facetsMarked(conditions, 'supported'));
  const sentences = around.flatMap((facet) => {
    const state = facetState(conditions, facet);
    const place = spoken(conditions.names[conditions.name[facet]!] ?? '');
    const springs = onSprings.has(facet) ? [`on elastic springs of ${springsOf(result, [facet])} (${place})`] : [];
    return state === 'free' && springs.length > 0 ? springs : [said(facet, state, place), ...springs];
  });
  return [...new Set(sentences)];

  function said(facet: number, state: FacetState, place: string): string {
    if (state === 'free') return `free (${place})`;
    if (state === 'fixed') return `constrained (${place})`;
    if (state === 'loaded' && conditions.pressDepth) return `pressed by ${sizeOf('moved', load * conditions.pressDepth)} in the mean (${place})`;
    const isFree = (i: number) => Number.isNaN(conditions.value[3 * facet + i]);
    const factor = load * (state === 'loaded' ? 1 : 1000 * (conditions.nodeFactor?.[node] ?? 1));
    const components = valueOf(conditions, facet).map((x, i) => (isFree(i) && state !== 'loaded' ? 'free' : short(factor * x))).join(', ');
    const size = state === 'loaded' ? `, ${sizeOf('loaded', load * Math.hypot(...vectorOf(conditions, facet)))}` : '';
    return `${state === 'loaded' ? 'traction' : state === 'moved' ? 'moved by' : 'slides:'} (${components}) ${state === 'loaded' ? 'Pa' : 'mm'}${size} (${place})`;
  }
}
