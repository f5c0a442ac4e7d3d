// What a cut leaves of a body, as the page draws and touches it. Values in, values out.
import { compactSurface, innerTriangles, type Surface, type Surfaces } from '../../../data/surface.ts';
import type { Foundation } from '../../../picture/facet_conditions.ts';
import type { LiveBody } from '../../types.ts';
import type { CutAnswer, PartedNodes } from './types.ts';

/** Of each node, the one of the whole body that it is, or was parted from. */
function originals(numNodes: number, { nodes, parents }: PartedNodes): Int32Array {
  const numAll = Math.max(numNodes, (nodes.at(-1) ?? -1) + 1);
  const original = Int32Array.from({ length: numAll }, (_, i) => i);
  nodes.forEach((node, i) => (original[node] = parents[i]!));
  return original;
}

/** Values of nodes of a body that may be parted: new nodes have those of the node that they were. @param values (N,width) */
export function carried(values: Float32Array, width: number, { cuts }: Pick<LiveBody, 'cuts'>): Float32Array {
  if (!cuts || cuts.parted.nodes.length === 0) return values;
  const original = originals(values.length / width, cuts.parted);
  return Float32Array.from({ length: width * original.length }, (_, i) => values[width * original[Math.floor(i / width)]! + (i % width)]!);
}

function partedPoints(points: LiveBody['points'], { nodes, places }: PartedNodes): LiveBody['points'] {
  if (nodes.length === 0) return points;
  const all = new Float64Array(Math.max(points.length, 3 * (nodes.at(-1)! + 1)));
  all.set(points);
  nodes.forEach((node, i) => all.set(places.subarray(3 * i, 3 * i + 3), 3 * node));
  return all;
}

function partedTetrahedra(tetrahedra: Int32Array, { tetrahedra: changed }: PartedNodes): Int32Array {
  const all = tetrahedra.slice();
  for (let i = 0; i < changed.length; i += 5) all.set(changed.subarray(i + 1, i + 5), 4 * changed[i]!);
  return all;
}

/** Springs below the facets that are left, by their numbers now: those of the whole body keep their order and stand before the wound. */
function foundationLeft({ foundation, triangles: before, points }: LiveBody, { triangles, wound, parted }: CutAnswer): Foundation | null {
  if (!foundation) return null;
  const original = originals(points.length / 3, parted);
  const now = new Int32Array(before.length / 3).fill(-1); // number of each facet
  for (let facet = 0, left = 0; facet < now.length && wound[left] === 0; facet++)
    if ([0, 1, 2].every((i) => before[3 * facet + i] === original[triangles[3 * left + i]!])) now[facet] = left++;
  const isLeft = (_: number, i: number) => now[foundation.facets[i]!]! >= 0;
  return {
    facets: foundation.facets.filter(isLeft).map((facet) => now[facet]!),
    stiffness: foundation.stiffness.filter(isLeft),
    normalOnly: foundation.normalOnly.filter(isLeft),
  };
}

/** @param whole  before all cuts; nodes keep its numbers */
export function bodyAfter(whole: LiveBody, answer: CutAnswer): LiveBody {
  const { gone, parted, triangles, constrained, wound } = answer;
  const isGone = new Uint8Array(whole.region.length);
  for (const t of gone) isGone[t] = 1;
  return {
    ...whole,
    points: partedPoints(whole.points, parted),
    tetrahedra: partedTetrahedra(whole.tetrahedra, parted).filter((_, i) => isGone[i >> 2] === 0),
    region: whole.region.filter((_, t) => isGone[t] === 0),
    modulusFactor: whole.modulusFactor.filter((_, t) => isGone[t] === 0),
    triangles,
    constrained,
    foundation: foundationLeft(whole, answer),
    cuts: { gone, parted, wound },
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
