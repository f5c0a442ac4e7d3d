// What is prescribed on the facets of the surface, and where arrows stand for it. Knows no three.js.

export interface Conditions {
  kind: Uint8Array; // (T) of each facet: 0 free, 1 prescribed displacement, 2 traction
  value: Float64Array; // (T,3) [m] or [Pa], as the kind says; NaN where a component of the displacement is free
  factor?: Float64Array; // (T) what a prescribed displacement is multiplied by at the centre of a facet; 1 where there is none
  pressDepth?: number; // m, to which tractions press, which then are for one newton; 0 where they are known
  foundation?: Foundation;
}

/** Elastic springs below facets, which may be loaded as well. */
export interface Foundation {
  facets: Int32Array; // (I)
  stiffness: Float64Array; // (I) k of the traction -k u [N/m^3]
  normalOnly: Uint8Array; // (I) 1 where they resist motion along the normal alone
}

/** fixed: no component moves; sliding: some do, freely; moved: by a prescribed displacement; loaded: by a traction. */
export type FacetState = 'free' | 'fixed' | 'sliding' | 'moved' | 'loaded';
export const facetStates = ['fixed', 'sliding', 'moved', 'loaded'] as const;
/** What facets are marked by: their state, and springs below them. */
export type FacetMark = (typeof facetStates)[number] | 'supported';
export const facetMarks: readonly FacetMark[] = [...facetStates, 'supported'];

export function facetState({ kind, value }: Conditions, facet: number): FacetState {
  const components = [value[3 * facet]!, value[3 * facet + 1]!, value[3 * facet + 2]!];
  const isZero = components.every((x) => x === 0 || Number.isNaN(x));
  if (kind[facet] === 2) return isZero ? 'free' : 'loaded';
  if (kind[facet] !== 1) return 'free';
  if (!isZero) return 'moved';
  return components.every((x) => x === 0) ? 'fixed' : components.every(Number.isNaN) ? 'free' : 'sliding';
}

type Vector = [number, number, number];

/** As the load case says it, before any factor; components that are free count as 0. */
export const valueOf = ({ value }: Conditions, facet: number): Vector => [0, 1, 2].map((i) => value[3 * facet + i]! || 0) as Vector;

/** The vector at the centre of a facet; components that are free count as 0. */
export function vectorOf(conditions: Conditions, facet: number): Vector {
  const factor = conditions.kind[facet] === 1 ? (conditions.factor?.[facet] ?? 1) : 1;
  return valueOf(conditions, facet).map((x) => factor * x) as Vector;
}

export function facetsIn(conditions: Conditions, state: FacetState): number[] {
  return Array.from(conditions.kind.keys()).filter((facet) => facetState(conditions, facet) === state);
}

export const facetsMarked = (conditions: Conditions, mark: FacetMark): number[] =>
  (mark === 'supported' ? Array.from(conditions.foundation?.facets ?? []) : facetsIn(conditions, mark));

/** The greatest length of what is prescribed in this state [m or Pa]; 0 if there is none. */
export function largestOf(conditions: Conditions, state: 'moved' | 'loaded'): number {
  return facetsIn(conditions, state).reduce((most, facet) => Math.max(most, Math.hypot(...vectorOf(conditions, facet))), 0);
}

/**
 * Some of the facets, about as far apart as is asked: each next one is the furthest from those before.
 * @param centres  (T,3) of all facets [m]
 * @param spacing  [m]
 */
export function spreadOut(facets: number[], centres: Float32Array, spacing: number, most: number): number[] {
  const distance = (a: number, b: number) =>
    Math.hypot(centres[3 * a]! - centres[3 * b]!, centres[3 * a + 1]! - centres[3 * b + 1]!, centres[3 * a + 2]! - centres[3 * b + 2]!);
  if (facets.length === 0) return [];
  const mean = [0, 1, 2].map((i) => facets.reduce((sum, f) => sum + centres[3 * f + i]!, 0) / facets.length);
  const fromMean = (f: number) => Math.hypot(...mean.map((x, i) => x - centres[3 * f + i]!));
  const chosen = [facets.reduce((best, f) => (fromMean(f) < fromMean(best) ? f : best))];
  const apart = facets.map((f) => distance(f, chosen[0]!));
  while (chosen.length < most) {
    const furthest = apart.indexOf(Math.max(...apart));
    if (apart[furthest]! < spacing) break;
    chosen.push(facets[furthest]!);
    facets.forEach((f, i) => (apart[i] = Math.min(apart[i]!, distance(f, chosen.at(-1)!))));
  }
  return chosen;
}
