// What the load case prescribes on each facet of the surface.
import type { File } from 'h5wasm';
import type { Foundation } from '../picture/facet_conditions.ts';
import { exactly, has, number, refuse, rows, texts } from './hdf5.ts';
import { Fault, type NamedConditions, type Patches } from './types.ts';

const mostKinds = 2; // of /load_case/condition: 0 free, 1 prescribed displacement, 2 traction

/** A round tool sinks in deepest in the middle. @return (N), or null where the file has none */
function readNodeFactor(file: File, numNodes: number): Float64Array | null {
  const path = '/load_case/node_factor';
  if (!has(file, path)) return null;
  const factor = Float64Array.from(exactly(numNodes, path, 1, rows(file, path, 1)));
  if (!factor.every((x) => x >= 0 && Number.isFinite(x)))
    throw new Fault(`${path} holds what is not a number from 0; make the file again with livermark run.`);
  return factor;
}

/** @return undefined where nothing stands on springs */
export function readFoundation(file: File, numTriangles: number): Foundation | undefined {
  const path = '/load_case/foundation';
  if (!has(file, path)) return undefined;
  const facets = Int32Array.from(rows(file, `${path}/facet`, 1));
  if (facets.some((facet) => facet < 0 || facet >= numTriangles))
    throw refuse(file, `${path}/facet names a facet that is not there`);
  const read = (name: string) => exactly(facets.length, `${path}/${name}`, 1, rows(file, `${path}/${name}`, 1));
  const stiffness = Float64Array.from(read('stiffness'));
  if (!stiffness.every((k) => k > 0 && k < Infinity))
    throw refuse(file, `${path}/stiffness has what is not above 0`);
  return { facets, stiffness, normalOnly: Uint8Array.from(read('normal_only')) };
}

/**
 * @param triangles  (T,3) of the boundary
 * @throws Fault with a sentence that names the place in the file
 */
export function readConditions(file: File, triangles: ArrayLike<number>, { patch, names: patches }: Patches, numNodes: number): NamedConditions {
  const numTriangles = triangles.length / 3;
  const read = (path: string, columns: number) => exactly(numTriangles, path, columns, rows(file, path, columns));
  const kind = Uint8Array.from(read('/load_case/condition', 1));
  if (kind.some((k) => k > mostKinds))
    throw new Fault('/load_case/condition has a kind that is not known; use the page of the same version.');
  const constraint = read('/load_case/constraint', 1);
  const constraints = texts(file, '/load_case/constraint', 'names');
  const nodeFactor = readNodeFactor(file, numNodes);
  const pressDepth = number(file, '/load_case', 'press_depth');
  const meanOf = (factor: Float64Array, t: number) => [0, 1, 2].reduce((sum, i) => sum + factor[triangles[3 * t + i]!]! / 3, 0);
  return {
    kind,
    ...(nodeFactor ? { factor: Float64Array.from(kind, (_, t) => meanOf(nodeFactor, t)) } : {}), // linear along edges
    nodeFactor,
    pressDepth: kind.some((k, t) => k === 2 && constraint[t]! >= 0) ? pressDepth : 0,
    value: Float64Array.from(read('/load_case/value', 3)),
    name: Int32Array.from(kind, (_, t) => (constraint[t]! >= 0 ? constraint[t]! : constraints.length + patch[t]!)),
    names: [...constraints, ...patches],
    foundation: readFoundation(file, numTriangles),
    acceleration: Array.from(exactly(3, '/load_case/acceleration', 1, rows(file, '/load_case/acceleration', 1))),
  };
}
