// What the load case prescribes on each facet of the surface.
import type { File } from 'h5wasm';
import { exactly, rows, texts } from './hdf5.ts';
import { Fault, type NamedConditions } from './types.ts';

const mostKinds = 2; // of /load_case/condition: 0 free, 1 prescribed displacement, 2 traction

/** @throws Fault with a sentence that names the place in the file */
export function readConditions(file: File, numTriangles: number): NamedConditions {
  const read = (path: string, columns: number) => exactly(numTriangles, path, columns, rows(file, path, columns));
  const kind = Uint8Array.from(read('/load_case/condition', 1));
  if (kind.some((k) => k > mostKinds))
    throw new Fault('/load_case/condition has a kind that is not known; use the page of the same version.');
  const constraint = read('/load_case/constraint', 1);
  const patch = read('/mesh/boundary_patch', 1);
  const constraints = texts(file, '/load_case/constraint', 'names');
  const patches = texts(file, '/mesh/boundary_patch', 'names');
  return {
    kind,
    value: Float64Array.from(read('/load_case/value', 3)),
    name: Int32Array.from(kind, (_, t) => (constraint[t]! >= 0 ? constraint[t]! : constraints.length + patch[t]!)),
    names: [...constraints, ...patches],
    acceleration: Array.from(exactly(3, '/load_case/acceleration', 1, rows(file, '/load_case/acceleration', 1))),
  };
}
