// Weights of the norms and means that are weighted by volume.

/** @param points (N,3) m @param tetrahedra (M,4) @return (M) m^3 */
function volumesOf(points: ArrayLike<number>, tetrahedra: ArrayLike<number>): Float64Array {
  return Float64Array.from({ length: tetrahedra.length / 4 }, (_, t) => {
    const at = (corner: number, i: number) => points[3 * tetrahedra[4 * t + corner]! + i]! - points[3 * tetrahedra[4 * t]! + i]!;
    const minor = (i: number, j: number) => at(2, i) * at(3, j) - at(2, j) * at(3, i);
    return Math.abs(at(1, 0) * minor(1, 2) + at(1, 1) * minor(2, 0) + at(1, 2) * minor(0, 1)) / 6;
  });
}

/** Of the tetrahedra around each node. @param values (M) @return (N) */
function nodalSums(values: Float64Array, tetrahedra: ArrayLike<number>, numNodes: number): Float64Array {
  const sums = new Float64Array(numNodes);
  for (let i = 0; i < tetrahedra.length; i++) sums[tetrahedra[i]!]! += values[i >> 2]!;
  return sums;
}

/** Volumes of the nodes: a quarter of each tetrahedron at a node. @return (N) m^3 */
export function nodalVolumes(points: ArrayLike<number>, tetrahedra: ArrayLike<number>): Float64Array {
  return nodalSums(volumesOf(points, tetrahedra).map((volume) => volume / 4), tetrahedra, points.length / 3);
}

/** Means over the tetrahedra at each node. @param values (M) @return (N) */
export function nodalMeans(points: ArrayLike<number>, tetrahedra: ArrayLike<number>, values: Float64Array): Float32Array {
  const volumes = volumesOf(points, tetrahedra);
  const sums = nodalSums(volumes.map((volume, t) => volume * values[t]!), tetrahedra, points.length / 3);
  const whole = nodalSums(volumes, tetrahedra, points.length / 3);
  return Float32Array.from(sums, (sum, node) => sum / whole[node]!);
}
