// What of a file can be set in motion: the mesh, its materials, its capsule and vessels, and where the load case fixes it.
import type { File } from 'h5wasm';
import { exactly, has, number, refuse, rows, text } from './hdf5.ts';
import { readMesh } from './read_mesh.ts';
import { readPatches } from './read_patches.ts';
import { Fault, type Capsule, type SoftBody, type Vessels } from './types.ts';

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

const isAboveZero = (value: number) => value > 0 && value < Infinity;

/** An attribute that has to be above zero. */
function readPositive(file: File, path: string, name: string, most = Infinity): number {
  const value = number(file, path, name);
  if (!(isAboveZero(value) && value <= most))
    throw refuse(file, Number.isNaN(value) ? `${path}@${name} is missing` : `${path}@${name} is ${value}, which nothing has`);
  return value;
}

/** Rows that have to be above zero. */
function readPositives(file: File, path: string, count: number): Float64Array {
  const values = Float64Array.from(exactly(count, path, 1, rows(file, path, 1)));
  const wrong = values.find((value) => !isAboveZero(value));
  if (wrong !== undefined) throw refuse(file, `${path} has ${wrong}, which nothing has`);
  return values;
}

/** @return empty without a map of stiffness */
function readModulusFactor(file: File, numTetrahedra: number): Float64Array {
  const path = '/mesh/modulus_factor';
  return has(file, path) ? readPositives(file, path, numTetrahedra) : new Float64Array();
}

const wound = 'wound'; // patch that cuts open: core::wound_patch

function readCapsule(file: File, numTriangles: number): Capsule | null {
  const path = '/capsule';
  if (!has(file, path)) return null;
  const { names, patch } = readPatches(file, numTriangles);
  const isWound = names.map((name) => name.split('+').includes(wound));
  return {
    thickness: readPositive(file, path, 'thickness'),
    youngModulus: readPositive(file, path, 'young_modulus'),
    covered: Uint8Array.from(patch, (p) => Number(!isWound[p])),
  };
}

function readVessels(file: File): Vessels | null {
  const path = '/vessels';
  if (!has(file, path)) return null;
  const points = Float64Array.from(rows(file, `${path}/points`, 3));
  const numPoints = points.length / 3;
  if (!points.every(Number.isFinite)) throw refuse(file, `${path}/points has a place that is no number`);
  const segments = Int32Array.from(rows(file, `${path}/segments`, 2));
  if (segments.some((point) => point < 0 || point >= numPoints))
    throw refuse(file, `${path}/segments names a point that is not there`);
  return {
    points,
    radius: readPositives(file, `${path}/radius`, numPoints),
    segments,
    wallRatio: readPositive(file, path, 'wall_ratio', 1),
    wallModulus: readPositive(file, path, 'wall_modulus'),
  };
}

/** @throws Fault with a sentence that names the place in the file */
export function readBody(file: File): SoftBody {
  const mesh = readMesh(file);
  const region = Int32Array.from(mesh.region);
  if (region.some((r) => r < 0))
    throw new Fault('/mesh/region has a number below 0; make the file again with livermark run.');
  const numRegions = region.reduce((most, r) => Math.max(most, r), 0) + 1;
  const numTriangles = mesh.triangles.length / 3;
  return {
    points: Float64Array.from(mesh.points),
    tetrahedra: Int32Array.from(mesh.tetrahedra),
    region,
    density: readMaterial(file, 'density', numRegions, isAboveZero),
    youngModulus: readMaterial(file, 'young_modulus', numRegions, isAboveZero),
    poissonRatio: readMaterial(file, 'poisson_ratio', numRegions, (value) => value > -1 && value < 0.5),
    triangles: Int32Array.from(mesh.triangles),
    constrained: readConstrained(file, numTriangles),
    modulusFactor: readModulusFactor(file, region.length),
    capsule: readCapsule(file, numTriangles),
    vessels: readVessels(file),
  };
}
