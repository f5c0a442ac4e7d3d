// Strain of a displacement field on linear tetrahedra: the largest eigenvalue of E = (F^T F - 1) / 2 (Green and Lagrange), which does
// not count rotations, in each tetrahedron, and its mean over the tetrahedra around a node, weighted by their volumes at rest.

/** Largest eigenvalue of a symmetric 3x3 matrix, by the trigonometric solution of its characteristic equation. */
export function largestEigenvalue(xx: number, yy: number, zz: number, xy: number, yz: number, xz: number): number {
  const mean = (xx + yy + zz) / 3;
  const [a, b, c] = [xx - mean, yy - mean, zz - mean];
  const p = Math.sqrt((a * a + b * b + c * c + 2 * (xy * xy + yz * yz + xz * xz)) / 6);
  if (p === 0) return mean;
  const determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
  const cosine = Math.min(Math.max(determinant / (2 * p * p * p), -1), 1);
  return mean + 2 * p * Math.cos(Math.acos(cosine) / 3);
}

/** What of a mesh the strain needs, made once. */
export interface StrainMesh {
  numNodes: number;
  tetrahedra: Int32Array; // (M,4)
  gradients: Float64Array; // (M,9) of the shape functions of corners 1 to 3 [1/m]
  volumes: Float64Array; // (M) m^3
}

/** @param points (N,3) m @param tetrahedra (M,4) */
export function strainMesh(points: ArrayLike<number>, tetrahedra: Int32Array): StrainMesh {
  const numCells = tetrahedra.length / 4;
  const gradients = new Float64Array(9 * numCells);
  const volumes = new Float64Array(numCells);
  for (let t = 0; t < numCells; t++) {
    const edge = (corner: number, i: number) => points[3 * tetrahedra[4 * t + corner]! + i]! - points[3 * tetrahedra[4 * t]! + i]!;
    const e = [1, 2, 3].map((corner) => [edge(corner, 0), edge(corner, 1), edge(corner, 2)]);
    const cross = (u: number[], v: number[]) => [u[1]! * v[2]! - u[2]! * v[1]!, u[2]! * v[0]! - u[0]! * v[2]!, u[0]! * v[1]! - u[1]! * v[0]!];
    const normals = [cross(e[1]!, e[2]!), cross(e[2]!, e[0]!), cross(e[0]!, e[1]!)];
    const determinant = e[0]!.reduce((sum, x, i) => sum + x * normals[0]![i]!, 0);
    volumes[t] = Math.abs(determinant) / 6;
    normals.forEach((normal, corner) => normal.forEach((x, i) => (gradients[9 * t + 3 * corner + i] = x / determinant)));
  }
  return { numNodes: points.length / 3, tetrahedra, gradients, volumes };
}

/** @param displacement (N,3) m @return (N); NaN at nodes without a tetrahedron, and around displacements that are no number */
export function nodalStrain({ numNodes, tetrahedra, gradients, volumes }: StrainMesh, displacement: ArrayLike<number>): Float32Array {
  const sums = new Float64Array(numNodes);
  const weights = new Float64Array(numNodes);
  const f = new Float64Array(9); // deformation gradient, row by row
  for (let t = 0; t < volumes.length; t++) {
    f.fill(0);
    f[0] = f[4] = f[8] = 1;
    const first = 3 * tetrahedra[4 * t]!;
    for (let corner = 0; corner < 3; corner++) {
      const node = 3 * tetrahedra[4 * t + corner + 1]!;
      for (let i = 0; i < 3; i++) {
        const u = displacement[node + i]! - displacement[first + i]!;
        for (let j = 0; j < 3; j++) f[3 * i + j]! += u * gradients[9 * t + 3 * corner + j]!;
      }
    }
    const green = (j: number, k: number) =>
      0.5 * (f[j]! * f[k]! + f[3 + j]! * f[3 + k]! + f[6 + j]! * f[6 + k]! - (j === k ? 1 : 0));
    const strain = largestEigenvalue(green(0, 0), green(1, 1), green(2, 2), green(0, 1), green(1, 2), green(0, 2));
    for (let corner = 0; corner < 4; corner++) {
      const node = tetrahedra[4 * t + corner]!;
      sums[node]! += volumes[t]! * strain;
      weights[node]! += volumes[t]!;
    }
  }
  return Float32Array.from(sums, (sum, node) => sum / weights[node]!);
}
