// Regions inside a body: how large they are, and where.
import type { Lesion } from './types.ts';

type Vector = [number, number, number];

/**
 * @param names       of all regions; the first one is the body itself
 * @param points      (N,3) m
 * @param tetrahedra  (M,4)
 * @param region      (M)
 */
export function lesionsOf(names: string[], points: ArrayLike<number>, tetrahedra: ArrayLike<number>, region: ArrayLike<number>): Lesion[] {
  const at = (node: number): Vector => [points[3 * node]!, points[3 * node + 1]!, points[3 * node + 2]!];
  const volumes = names.map(() => 0);
  const moments = names.map((): Vector => [0, 0, 0]);
  const nodes = names.map(() => new Set<number>());
  for (let t = 0; t < region.length; t++) {
    const r = region[t]!;
    if (!(r > 0 && r < names.length)) continue;
    const corners = [0, 1, 2, 3].map((i) => tetrahedra[4 * t + i]!);
    const [o, a, b, c] = corners.map(at) as [Vector, Vector, Vector, Vector];
    const edge = (p: Vector) => p.map((x, i) => x - o[i]!) as Vector;
    const [u, v, w] = [edge(a), edge(b), edge(c)];
    const volume = Math.abs(u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0])) / 6;
    volumes[r]! += volume;
    for (const i of [0, 1, 2] as const) moments[r]![i] += (volume * (o[i] + a[i] + b[i] + c[i])) / 4;
    for (const node of corners) nodes[r]!.add(node);
  }
  return names.flatMap((name, r) => {
    if (nodes[r]!.size === 0) return [];
    const centre = moments[r]!.map((x) => x / volumes[r]!);
    const distance = (node: number) => Math.hypot(...at(node).map((x, i) => x - centre[i]!));
    const node = [...nodes[r]!].reduce((best, other) => (distance(other) < distance(best) ? other : best));
    const from = at(node);
    const along = (i: number) => [...nodes[r]!].map((other) => at(other)[i]! - from[i]!);
    const reach = (of: (values: number[]) => number) => [0, 1, 2].map((i) => of(along(i))) as Vector;
    const [below, above] = [reach((values) => -values.reduce((a, b) => Math.min(a, b))), reach((values) => values.reduce((a, b) => Math.max(a, b)))];
    return [{ name, region: r, volume: volumes[r]!, node, reach: { below, above } }];
  });
}
