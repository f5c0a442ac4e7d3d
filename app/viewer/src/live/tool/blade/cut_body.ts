// What a cut leaves of a body, as the page draws and touches it. Values in, values out.
import { compactSurface, innerTriangles, type Surface, type Surfaces } from '../../../data/surface.ts';
import type { Foundation } from '../../../picture/facet_conditions.ts';
import type { LiveBody } from '../../types.ts';
import type { CutAnswer } from './types.ts';

/** Springs below the facets that are left, by their numbers now: those of the whole body keep their order and stand before the wound. */
function foundationLeft({ foundation, triangles: before }: LiveBody, { triangles, wound }: Pick<CutAnswer, 'triangles' | 'wound'>): Foundation | null {
  if (!foundation) return null;
  const now = new Int32Array(before.length / 3).fill(-1); // number of each facet
  for (let facet = 0, left = 0; facet < now.length && wound[left] === 0; facet++)
    if ([0, 1, 2].every((i) => before[3 * facet + i] === triangles[3 * left + i])) now[facet] = left++;
  const isLeft = (_: number, i: number) => now[foundation.facets[i]!]! >= 0;
  return {
    facets: foundation.facets.filter(isLeft).map((facet) => now[facet]!),
    stiffness: foundation.stiffness.filter(isLeft),
    normalOnly: foundation.normalOnly.filter(isLeft),
  };
}

/** @param whole  before all cuts; nodes keep its numbers */
export function bodyAfter(whole: LiveBody, { gone, triangles, constrained, wound }: CutAnswer): LiveBody {
  const isGone = new Uint8Array(whole.region.length);
  for (const t of gone) isGone[t] = 1;
  return {
    ...whole,
    tetrahedra: whole.tetrahedra.filter((_, i) => isGone[i >> 2] === 0),
    region: whole.region.filter((_, t) => isGone[t] === 0),
    modulusFactor: whole.modulusFactor.filter((_, t) => isGone[t] === 0),
    triangles,
    constrained,
    foundation: foundationLeft(whole, { triangles, wound }),
    cuts: { gone, wound },
  };
}

/** The outside with nodes at the rim of the wound twice, so that each side has its own normals. */
function outsideOf({ triangles, cuts }: LiveBody): Surface {
  const first = cuts ? 3 * cuts.wound.indexOf(1) : -1;
  if (first < 0) return compactSurface(triangles);
  const [capsule, wound] = [compactSurface(triangles.subarray(0, first)), compactSurface(triangles.subarray(first))];
  return {
    nodes: Int32Array.from([...capsule.nodes, ...wound.nodes]),
    triangles: Uint32Array.from([...capsule.triangles, ...wound.triangles.map((vertex) => vertex + capsule.nodes.length)]),
  };
}

/** What is drawn of a body that has been cut. */
export function surfacesOf(body: LiveBody): Surfaces {
  return { outside: outsideOf(body), inside: compactSurface(innerTriangles(body.tetrahedra, body.region)) };
}

/** Nodes of tetrahedra that are there. */
export const nodesThere = ({ tetrahedra }: Pick<LiveBody, 'tetrahedra'>): Set<number> => new Set(tetrahedra);
