// Places on the surface of a body that has moved.
import type { LiveBody } from './types.ts';
import { dot, length, plus, type Vector } from './vector.ts';

const vectorAt = (values: ArrayLike<number>, row: number): Vector => [values[3 * row]!, values[3 * row + 1]!, values[3 * row + 2]!];

export function placeOf(body: LiveBody, displacement: Float32Array, node: number): Vector {
  return plus(vectorAt(body.points, node), vectorAt(displacement, node));
}

function across(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** Of the triangles that are free, those at a node. */
function trianglesAt(body: LiveBody, node: number): number[] {
  const found: number[] = [];
  for (let i = 0; i < body.triangles.length; i++)
    if (body.triangles[i] === node && !body.constrained[Math.floor(i / 3)]) found.push(Math.floor(i / 3));
  return found;
}

/** Where a node of the free surface is, and its normal. @return null for a node that cannot be touched */
export function surfaceAt(body: LiveBody, displacement: Float32Array, node: number): { point: Vector; inwards: Vector; node: number } | null {
  const around = trianglesAt(body, node);
  if (around.length === 0) return null;
  let outwards: Vector = [0, 0, 0];
  for (const t of around) {
    const [a, b, c] = [0, 1, 2].map((i) => placeOf(body, displacement, body.triangles[3 * t + i]!)) as [Vector, Vector, Vector];
    outwards = plus(outwards, across(plus(b, a, -1), plus(c, a, -1)));
  }
  const size = length(outwards) || 1;
  return { point: placeOf(body, displacement, node), inwards: outwards.map((x) => -x / size) as Vector, node };
}

/** The node of the free surface that is furthest in a direction: something to begin with. */
export function furthest(body: LiveBody, direction: Vector): number {
  let [best, most] = [0, -Infinity];
  body.triangles.forEach((node, i) => {
    const reach = dot(vectorAt(body.points, node), direction);
    if (reach <= most || body.constrained[Math.floor(i / 3)]) return;
    [best, most] = [node, reach];
  });
  return best;
}

/** At rest [m^3]. */
export function volumeOf(body: LiveBody, tetrahedron: number): number {
  const corners = [0, 1, 2, 3].map((i) => vectorAt(body.points, body.tetrahedra[4 * tetrahedron + i]!));
  const [a, b, c, d] = corners as [Vector, Vector, Vector, Vector];
  return dot(across(plus(b, a, -1), plus(c, a, -1)), plus(d, a, -1)) / 6;
}

/** The region with the largest volume: its materials are the ones that one chooses. */
export function largestRegion(body: LiveBody): number {
  const volume = new Float64Array(body.density.length);
  body.region.forEach((region, t) => (volume[region]! += volumeOf(body, t)));
  return volume.indexOf(Math.max(...volume));
}
