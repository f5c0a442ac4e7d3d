// From the fields of a file to what is drawn: places and colours of vertices.
import type { Surface } from '../data/surface.ts';

/** @param vectors (N,3) @return their lengths (N) */
export function lengths(vectors: Float32Array): Float32Array {
  return Float32Array.from({ length: vectors.length / 3 }, (_, i) =>
    Math.hypot(vectors[3 * i]!, vectors[3 * i + 1]!, vectors[3 * i + 2]!));
}

/** Places of the vertices of a surface. A node whose displacement is no number stays at rest. */
export function displaced(surface: Pick<Surface, 'nodes'>, points: Float32Array, displacement: Float32Array, exaggeration: number): Float32Array {
  const places = new Float32Array(3 * surface.nodes.length);
  surface.nodes.forEach((node, vertex) => {
    for (let i = 0; i < 3; i++) {
      const u = displacement[3 * node + i]!;
      places[3 * vertex + i] = points[3 * node + i]! + (Number.isFinite(u) ? exaggeration * u : 0);
    }
  });
  return places;
}

/**
 * Where each vertex finds its colour in a texture of two rows: the map, and the colour of what is no number.
 * @param nodes   (V) of the vertices
 * @param values  of the nodes
 * @param end     the value at the end of the map
 * @param hasLines  of equal values
 */
export function textureCoordinates(nodes: Int32Array, values: Float32Array, end: number, width: number, hasLines = true): Float32Array {
  const coordinates = new Float32Array(2 * nodes.length);
  nodes.forEach((node, vertex) => {
    const part = values[node]! / end;
    const known = !Number.isNaN(part);
    coordinates[2 * vertex] = (0.5 + (known ? Math.min(Math.max(part, 0), 1) : 0) * (width - 1)) / width;
    coordinates[2 * vertex + 1] = known && hasLines ? 0.25 : 0.75;
  });
  return coordinates;
}

/** How much displacements are to be exaggerated by for the largest to be a tenth of the body. */
export function goodExaggeration(points: Float32Array, largest: number): number {
  let [low, high] = [Infinity, -Infinity];
  for (let i = 0; i < points.length; i += 3) {
    low = Math.min(low, points[i]!);
    high = Math.max(high, points[i]!);
  }
  const factor = (0.1 * (high - low)) / largest;
  return Number.isFinite(factor) ? Math.max(1, factor) : 1;
}

/** What the slider offers: at rest, as it is, and round numbers beyond. */
export const exaggerations = [
  0, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60, 80, 100, 150, 200, 300, 500, 1000, 2000, 5000, 10000,
];

export function nearestExaggeration(factor: number): number {
  const distances = exaggerations.map((e) => Math.abs(Math.log((e || 0.1) / factor)));
  return distances.indexOf(Math.min(...distances));
}
