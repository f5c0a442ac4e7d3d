// Weights of the norms that are weighted by volume.

/** Volumes of the nodes: a quarter of each tetrahedron at a node. @return (N) m^3 */
export function nodalVolumes(points: ArrayLike<number>, tetrahedra: ArrayLike<number>): Float64Array {
  const volumes = new Float64Array(points.length / 3);
  for (let t = 0; t < tetrahedra.length; t += 4) {
    const at = (corner: number, i: number) => points[3 * tetrahedra[t + corner]! + i]! - points[3 * tetrahedra[t]! + i]!;
    const minor = (i: number, j: number) => at(2, i) * at(3, j) - at(2, j) * at(3, i);
    const volume = Math.abs(at(1, 0) * minor(1, 2) + at(1, 1) * minor(2, 0) + at(1, 2) * minor(0, 1)) / 6;
    for (let corner = 0; corner < 4; corner++) volumes[tetrahedra[t + corner]!]! += volume / 4;
  }
  return volumes;
}
