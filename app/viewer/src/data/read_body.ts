// What of a file can be set in motion: the mesh, its materials, its capsule and vessels, where the load case fixes it, and what bears it.
import type { File } from 'h5wasm';
import type { Foundation } from '../picture/facet_conditions.ts';
import { exactly, rows, text } from './hdf5.ts';
import { readFoundation } from './read_conditions.ts';
import { readMesh } from './read_mesh.ts';
import { isAboveZero, readCapsule, readModulusFactor, readVessels } from './read_parts.ts';
import { readPatches } from './read_patches.ts';
import { Fault, type SoftBody } from './types.ts';

const prescribedDisplacement = 1; // of /load_case/condition

/** 1 for each triangle that the load case fixes in all three components; app/server/sessions/live_body.cpp decides likewise. */
function readConstrained(file: File, numTriangles: number): Uint8Array {
  const condition = exactly(numTriangles, '/load_case/condition', 1, rows(file, '/load_case/condition', 1));
  const value = exactly(numTriangles, '/load_case/value', 3, rows(file, '/load_case/value', 3));
  const constrained = Uint8Array.from({ length: numTriangles }, (_, t) =>
    Number(condition[t] === prescribedDisplacement && [0, 1, 2].every((i) => value[3 * t + i] === 0)));
  if (!constrained.includes(1))
    throw new Fault(`Its load case ${text(file, '/load_case', 'name')} does not fix any part of the surface, and the body would fly away; choose a result of a load case that does, such as palpation.`);
  return constrained;
}

/** Springs below what is not constrained; app/server/sessions/live_body.cpp decides likewise. */
function readSpringsBelow(file: File, constrained: Uint8Array): Foundation | null {
  const whole = readFoundation(file, constrained.length);
  if (!whole) return null;
  const isFree = (_: number, i: number) => constrained[whole.facets[i]!] === 0;
  return { facets: whole.facets.filter(isFree), stiffness: whole.stiffness.filter(isFree), normalOnly: whole.normalOnly.filter(isFree) };
}

/** @param isOne  whether there is a material with this value */
function readMaterial(file: File, quantity: string, numRegions: number, isOne: (value: number) => boolean): Float64Array {
  const path = `/materials/${quantity}`;
  const values = Float64Array.from(rows(file, path, 1));
  if (values.length < numRegions)
    throw new Fault(`${path} does not have all of the ${numRegions} regions; make the file again with livermark run.`);
  const wrong = values.find((value) => !isOne(value));
  if (wrong !== undefined)
    throw new Fault(`${path} has ${wrong}, which nothing is made of; make the file again with livermark run.`);
  return values;
}

/** @throws Fault with a sentence that names the place in the file */
export function readBody(file: File): SoftBody {
  const mesh = readMesh(file);
  const region = Int32Array.from(mesh.region);
  if (region.some((r) => r < 0))
    throw new Fault('/mesh/region has a number below 0; make the file again with livermark run.');
  const numRegions = region.reduce((most, r) => Math.max(most, r), 0) + 1;
  const numTriangles = mesh.triangles.length / 3;
  const constrained = readConstrained(file, numTriangles);
  return {
    points: Float64Array.from(mesh.points),
    tetrahedra: Int32Array.from(mesh.tetrahedra),
    region,
    density: readMaterial(file, 'density', numRegions, isAboveZero),
    youngModulus: readMaterial(file, 'young_modulus', numRegions, isAboveZero),
    poissonRatio: readMaterial(file, 'poisson_ratio', numRegions, (value) => value > -1 && value < 0.5),
    triangles: Int32Array.from(mesh.triangles),
    constrained,
    modulusFactor: readModulusFactor(file, region.length),
    capsule: readCapsule(file, readPatches(file, numTriangles)),
    vessels: readVessels(file),
    foundation: readSpringsBelow(file, constrained),
  };
}
