// A plane through a body: what of its tetrahedra and of its inner surfaces lies in it.
import type { Surface } from '../data/surface.ts';

/** What lies beyond a plane across an axis is taken away. */
export interface Cut {
  axis: 0 | 1 | 2;
  place: number; // along the axis, of the body as it is drawn [m]
  keepsAbove: boolean; // the half of the greater coordinates; else the other one
}

/** Triangles in the plane. Vertices lie on edges of the mesh. */
export interface Section {
  places: Float32Array; // (V,3) m
  values: Float32Array; // (V), along the edges as the nodes have them
  nodes: Int32Array; // (V) the nearer node of the edge
}

/** > 0 where it is taken away. */
export const beyond = (cut: Cut, coordinate: number) => (cut.keepsAbove ? cut.place - coordinate : coordinate - cut.place);

/** Of what is inside: those that the cut meets, or all that are left. */
export type Names = 'none' | 'cut' | 'all';

/** How far something goes from its place, along the axes [m]. */
export interface Reach {
  below: readonly number[];
  above: readonly number[];
}

/** Whether what is inside has its name in the picture. */
export function isNamed(names: Names, cut: Cut | null, place: readonly number[], { below, above }: Reach): boolean {
  if (!cut) return names === 'all';
  const at = place[cut.axis]!;
  const isMet = cut.place > at - below[cut.axis]! && cut.place < at + above[cut.axis]!;
  return names !== 'none' && (isMet || (names === 'all' && beyond(cut, at) <= 0));
}

interface Crossing {
  place: [number, number, number];
  value: number;
  node: number;
}

function crossings(corners: number[], heights: Float32Array, places: Float32Array, values: Float32Array): Crossing[] {
  const above = corners.filter((node) => heights[node]! > 0);
  const below = corners.filter((node) => !(heights[node]! > 0));
  // Around the polygon: each edge shares a corner with the next.
  const edges = above.length === 2 && below.length === 2
    ? [[0, 0], [0, 1], [1, 1], [1, 0]].map(([a, b]) => [above[a!]!, below[b!]!] as const)
    : above.flatMap((a) => below.map((b) => [a, b] as const));
  return edges.map(([a, b]) => {
    const part = heights[a]! / (heights[a]! - heights[b]!);
    const mix = (x: number, y: number) => x + part * (y - x);
    return {
      place: [0, 1, 2].map((i) => mix(places[3 * a + i]!, places[3 * b + i]!)) as [number, number, number],
      value: mix(values[a]!, values[b]!),
      node: part < 0.5 ? a : b,
    };
  });
}

function heightsOf(cut: Cut, places: Float32Array): Float32Array {
  return Float32Array.from({ length: places.length / 3 }, (_, node) => beyond(cut, places[3 * node + cut.axis]!));
}

/**
 * @param tetrahedra (M,4)
 * @param places     (N,3) of the nodes as they are drawn [m]
 * @param values     (N)
 */
export function sectionOf(cut: Cut, tetrahedra: Int32Array, places: Float32Array, values: Float32Array): Section {
  const heights = heightsOf(cut, places);
  const found: Crossing[] = [];
  for (let t = 0; t < tetrahedra.length; t += 4) {
    const corners = [tetrahedra[t]!, tetrahedra[t + 1]!, tetrahedra[t + 2]!, tetrahedra[t + 3]!];
    const numBeyond = corners.reduce((count, node) => count + Number(heights[node]! > 0), 0);
    if (numBeyond === 0 || numBeyond === 4) continue;
    const polygon = crossings(corners, heights, places, values);
    for (let i = 2; i < polygon.length; i++) found.push(polygon[0]!, polygon[i - 1]!, polygon[i]!);
  }
  return {
    places: Float32Array.from(found.flatMap((c) => c.place)),
    values: Float32Array.from(found, (c) => c.value),
    nodes: Int32Array.from(found, (c) => c.node),
  };
}

/** Where a surface meets the plane: pairs of ends of lines. @return (L,2,3) m */
export function outlineOf(cut: Cut, surface: Surface, places: Float32Array): Float32Array {
  const heights = heightsOf(cut, places);
  const ends: number[] = [];
  for (let t = 0; t < surface.triangles.length; t += 3) {
    const corners = [0, 1, 2].map((i) => surface.nodes[surface.triangles[t + i]!]!);
    const numBeyond = corners.reduce((count, node) => count + Number(heights[node]! > 0), 0);
    if (numBeyond === 0 || numBeyond === 3) continue;
    ends.push(...crossings(corners, heights, places, heights).flatMap((c) => c.place));
  }
  return Float32Array.from(ends);
}
