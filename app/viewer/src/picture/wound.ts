// The wound of a body that has been cut: a colour of its own, and normals that hide the facets along which it was cut.
import * as three from 'three';

const passes = 3; // of averaging; facets are as large as edges, and the wound is as rough

/** Triangles of a surface from this one on are in the wound, and share no vertex with those before. */
export interface WoundParts {
  /** Groups of the geometry: the surface, then the wound. */
  outside(skin: three.Material): three.Material | three.Material[];
  mesh: three.Mesh | null;
  /** After places and normals were set. */
  follow(): void;
}

/** @param firstTriangle  of the wound; none where there is no such triangle */
export function createWound(geometry: three.BufferGeometry, firstTriangle: number, material: three.Material, unseen: three.Material): WoundParts {
  const index = geometry.getIndex()!;
  const first = 3 * firstTriangle;
  if (firstTriangle < 0 || first >= index.count) return { outside: (skin) => skin, mesh: null, follow: () => {} };
  geometry.addGroup(0, first, 0);
  geometry.addGroup(first, index.count - first, 1);
  // Each edge of the wound inside once from both sides; at the rim from one, which does no harm.
  const vertices = new Set<number>();
  const pairs: [number, number][] = [];
  for (let i = first; i < index.count; i += 3)
    for (const [a, b] of [[0, 1], [1, 2], [2, 0]] as const) {
      vertices.add(index.getX(i + a));
      pairs.push([index.getX(i + a), index.getX(i + b)]);
    }
  return {
    outside: (skin) => [skin, unseen],
    mesh: new three.Mesh(geometry, [unseen, material]),
    follow() {
      const normal = geometry.getAttribute('normal');
      const values = normal.array as Float32Array;
      for (let pass = 0; pass < passes; pass++) {
        const before = values.slice();
        for (const [a, b] of pairs)
          for (let c = 0; c < 3; c++) {
            values[3 * a + c]! += before[3 * b + c]!;
            values[3 * b + c]! += before[3 * a + c]!;
          }
        for (const vertex of vertices) {
          const size = Math.hypot(values[3 * vertex]!, values[3 * vertex + 1]!, values[3 * vertex + 2]!) || 1;
          for (let c = 0; c < 3; c++) values[3 * vertex + c]! /= size;
        }
      }
      normal.needsUpdate = true;
    },
  };
}
