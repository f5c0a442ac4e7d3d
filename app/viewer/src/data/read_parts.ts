// What a body may have besides its mesh and its regions: a capsule, vessels as lines, a map of stiffness.
import type { File } from 'h5wasm';
import { exactly, has, number, refuse, rows } from './hdf5.ts';
import { nodalMeans } from './nodal_volumes.ts';
import type { Capsule, Patches, Vessels } from './types.ts';

export const isAboveZero = (value: number) => value > 0 && value < Infinity;

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
export function readModulusFactor(file: File, numTetrahedra: number): Float64Array {
  const path = '/mesh/modulus_factor';
  return has(file, path) ? readPositives(file, path, numTetrahedra) : new Float64Array();
}

/** Young's modulus at each node: the mean over its tetrahedra, weighted by volume. @return (N) Pa; null without a map of stiffness */
export function readNodalModulus(file: File, points: ArrayLike<number>, tetrahedra: ArrayLike<number>, region: ArrayLike<number>): Float32Array | null {
  const factor = readModulusFactor(file, region.length);
  if (factor.length === 0) return null;
  const ofRegion = rows(file, '/materials/young_modulus', 1);
  return nodalMeans(points, tetrahedra, factor.map((x, t) => x * ofRegion[region[t]!]!));
}

const wound = 'wound'; // patch that cuts open: core::wound_patch

export function readCapsule(file: File, { names, patch }: Patches): Capsule | null {
  const path = '/capsule';
  if (!has(file, path)) return null;
  const isWound = names.map((name) => name.split('+').includes(wound));
  return {
    thickness: readPositive(file, path, 'thickness'),
    youngModulus: readPositive(file, path, 'young_modulus'),
    covered: Uint8Array.from(patch, (p) => Number(!isWound[p])),
  };
}

export function readVessels(file: File): Vessels | null {
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
