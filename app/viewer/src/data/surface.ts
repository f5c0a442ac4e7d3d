// The surfaces that are drawn: the outside of the body, and what lies between two of its regions.

export interface Surface {
  nodes: Int32Array; // numbers in the mesh, of the vertices that are drawn
  triangles: Uint32Array; // (T,3) indices into nodes
}

export interface Surfaces {
  outside: Surface;
  inside: Surface; // of all regions but the first; no triangles in a body of one region
}

/** @param triangles (T,3) node numbers of the mesh */
export function compactSurface(triangles: ArrayLike<number>): Surface {
  const place = new Map<number, number>();
  const indices = Uint32Array.from(triangles, (node) => {
    if (!place.has(node)) place.set(node, place.size);
    return place.get(node)!;
  });
  return { nodes: Int32Array.from(place.keys()), triangles: indices };
}

/** Faces of a tetrahedron of positive volume, right-handed seen from outside. */
const faces = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]] as const;

/**
 * Faces between a tetrahedron of region 1 or higher and one of a lower region, seen from the lower one.
 * @param tetrahedra (M,4)
 * @param region (M)
 */
export function innerTriangles(tetrahedra: ArrayLike<number>, region: ArrayLike<number>): number[] {
  // A face of two tetrahedra of one region is met twice and struck out; what is left touches another region or nothing.
  const open = new Map<string, number[]>();
  for (let t = 0; t < region.length; t++) {
    if (region[t] === 0) continue;
    for (const face of faces) {
      const nodes = face.map((corner) => tetrahedra[4 * t + corner]!);
      const key = `${region[t]}:${[...nodes].sort((a, b) => a - b).join(',')}`;
      if (!open.delete(key)) open.set(key, nodes);
    }
  }
  return [...open.values()].flat();
}
