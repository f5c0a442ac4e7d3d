// The named parts of the surface, by their names in alphabetical order, so that a name has the same colour on every body that has these names.
import type { File } from 'h5wasm';
import { exactly, number, rows, texts } from './hdf5.ts';
import { Fault, type Patches } from './types.ts';

const path = '/mesh/boundary_patch';

/** @throws Fault with a sentence that names the place in the file */
export function readPatches(file: File, numTriangles: number): Patches {
  const names = texts(file, path, 'names');
  const patch = Int32Array.from(exactly(numTriangles, path, 1, rows(file, path, 1)));
  if (patch.some((p) => p < 0 || p >= names.length))
    throw new Fault(`${path} has a number without a name; make the file again with livermark run.`);
  const sorted = [...names].sort();
  return { names: sorted, patch: patch.map((p) => sorted.indexOf(names[p]!)), confidence: number(file, path, 'confidence') };
}
