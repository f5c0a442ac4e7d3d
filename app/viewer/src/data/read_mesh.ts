// The mesh of a file: whatever names a node names one that is there.
import type { File } from 'h5wasm';
import { exactly, rows } from './hdf5.ts';
import { Fault } from './types.ts';

export interface Mesh {
  points: ArrayLike<number>; // (N,3) m
  tetrahedra: ArrayLike<number>; // (M,4)
  region: ArrayLike<number>; // (M)
  triangles: ArrayLike<number>; // (T,3) of the boundary
}

function readNodes(file: File, path: string, columns: number, numNodes: number): ArrayLike<number> {
  const nodes = rows(file, path, columns);
  for (let i = 0; i < nodes.length; i++)
    if (!(nodes[i]! >= 0 && nodes[i]! < numNodes))
      throw new Fault(`${path} names a node that is not there; make the file again with livermark run.`);
  return nodes;
}

/** @throws Fault with a sentence that names the place in the file */
export function readMesh(file: File): Mesh {
  const points = rows(file, '/mesh/points', 3);
  for (let i = 0; i < points.length; i++)
    if (!Number.isFinite(points[i]))
      throw new Fault(`/mesh/points has a place that is no number, of node ${Math.floor(i / 3)}; make the file again with livermark run.`);
  const tetrahedra = readNodes(file, '/mesh/tetrahedra', 4, points.length / 3);
  return {
    points,
    tetrahedra,
    region: exactly(tetrahedra.length / 4, '/mesh/region', 1, rows(file, '/mesh/region', 1)),
    triangles: readNodes(file, '/mesh/boundary_triangles', 3, points.length / 3),
  };
}
