// The path of loads: fields, errors and forces of each model at its points.
import type { File } from 'h5wasm';
import { valueOf, type Conditions } from '../picture/facet_conditions.ts';
import { children, dataset, has, number, rows, texts } from './hdf5.ts';
import { Fault, type ForceCurve, type ForcePlot, type MovingPlace, type PointErrors, type Result } from './types.ts';

const displacementPath = (model: string) => `/solutions/${model}/path/displacement`;
const smallestReaction = 1e-6; // of a force that would do the work of the loads on the peak displacement; below it is rounding

/** Parts of the load at which solutions are kept; none in the small regime. */
export function readLoads(file: File): number[] {
  const path = '/load_case/path';
  if (!has(file, path)) return [];
  const loads = Array.from(rows(file, path, 1));
  if (loads.length === 0 || !loads.every((part, k) => part > (loads[k - 1] ?? 0) && part <= 1) || loads.at(-1) !== 1)
    throw new Fault(`${path} does not ascend from above 0 to 1; make the file again with livermark run.`);
  return loads;
}

/** Of the points of the path; fewer than the loads where the way ended early, 0 where the model has none. */
export function numPointsOf(file: File, model: string, numNodes: number): number {
  return Math.floor((dataset(file, displacementPath(model))?.shape?.[0] ?? 0) / numNodes);
}

/** @return (N,3) m; null where the model did not come so far */
export function readPoint(file: File, model: string, point: number, numNodes: number): Float32Array | null {
  if (point >= numPointsOf(file, model, numNodes)) return null;
  return Float32Array.from(rows(file, displacementPath(model), 3, [point * numNodes, (point + 1) * numNodes]));
}

/** u - r at a point of the path, as the file has both. @return (N,3) m; null for r itself, and where one of them is not there */
export function readPointError(file: File, model: string, reference: string, point: number, numNodes: number): Float32Array | null {
  if (model === reference) return null;
  const [u, r] = [readPoint(file, model, point, numNodes), readPoint(file, reference, point, numNodes)];
  return u && r ? u.map((x, i) => x - r[i]!) : null;
}

/** The places where displacement is prescribed that is not 0, and those that press to a depth. @param names  of the constraints, which are the first names of the conditions */
export function movingPlaces(conditions: Conditions & { name: Int32Array }, names: string[]): MovingPlace[] {
  return names.flatMap((name, constraint) => {
    const facets = Array.from(conditions.name.keys()).filter((facet) => conditions.name[facet] === constraint);
    const mean = [0, 1, 2].map((i) => facets.reduce((sum, facet) => sum + valueOf(conditions, facet)[i]!, 0) / facets.length);
    const presses = facets.some((facet) => conditions.kind[facet] === 2);
    const way = presses ? mean.map((x) => ((conditions.pressDepth ?? 0) * x) / Math.hypot(...mean)) : mean; // tractions of a place all go one way
    return Math.hypot(...way) > 0 ? [{ name, constraint, way }] : [];
  });
}

/** Reactions of a model at the points of its path. @return rows of (P,3) N, one behind the other; null where the file has none */
function readReactions(file: File, model: string, numConstraints: number): ArrayLike<number> | null {
  const path = `/solutions/${model}/path/reaction`;
  return numConstraints > 0 && has(file, path) ? rows(file, path, 3 * numConstraints) : null;
}

function readEnergies(file: File, model: string): ArrayLike<number> {
  const path = `/solutions/${model}/path/strain_energy`;
  return has(file, path) ? rows(file, path, 1) : [];
}

/** What is observed of the reference's reactions: its error, as a part of the reactions of all places, and at which part of the load. */
export function readReactionUncertainty(file: File, reference: string): { relative: number; load: number } {
  const path = `/solutions/${reference}`;
  const observed = number(file, path, 'observed_reaction');
  const load = number(file, path, 'observed_load_fraction');
  const relative = Number.isNaN(observed) ? number(file, '/reference', 'reaction_uncertainty') : observed;
  return { relative, load: Number.isNaN(load) ? 1 : load };
}

/** Force on the body along the way of each place that moves, at the points of the path, as livermark table --kind forces has it. */
export function readForces(file: File, { places, reference, numConstraints }: Result): ForcePlot[] {
  const reactions = children(file, '/solutions').flatMap((model) => {
    const values = readReactions(file, model, numConstraints);
    return values ? [{ model, values }] : [];
  });
  const { relative, load } = readReactionUncertainty(file, reference);
  const expected = reactions.find(({ model }) => model === reference)?.values ?? [];
  const width = 3 * numConstraints;
  const norm = (k: number) => Math.hypot(...Array.from({ length: width }, (_, i) => expected[k * width + i]!));
  // In that norm no place alone can be off by more.
  const uncertain = relative > 0 ? Array.from({ length: expected.length / width }, (_, k) => relative * norm(k)) : [];
  return places.map(({ name, constraint, way }) => {
    const length = Math.hypot(...way);
    const along = (values: ArrayLike<number>, k: number) =>
      way.reduce((sum, w, i) => sum + (values[k * width + 3 * constraint + i]! * w) / length, 0);
    const curves = reactions.map(({ model, values }): ForceCurve =>
      ({ model, force: Array.from({ length: values.length / width }, (_, k) => along(values, k)) }));
    return { place: name, way: length, curves, uncertain, relative, observedAt: load };
  });
}

interface PathState {
  displacement: Float32Array;
  energy: number;
  reaction: number[];
}

function stateAt(file: File, model: string, point: number, volumes: Float64Array, numConstraints: number): PathState | null {
  const displacement = readPoint(file, model, point, volumes.length);
  const width = 3 * numConstraints;
  const reactions = readReactions(file, model, numConstraints);
  const reaction = reactions ? Array.from({ length: width }, (_, i) => reactions[point * width + i] ?? Number.NaN) : [];
  return displacement && { displacement, energy: readEnergies(file, model)[point] ?? Number.NaN, reaction };
}

const sumOfSquares = (values: number[]) => values.reduce((sum, x) => sum + x * x, 0);

/** The norms of core::compare, at a point of the path. */
function errorsOf(u: PathState, r: PathState, volumes: Float64Array): Omit<PointErrors, 'model' | 'stiffness'> {
  let [squaredError, squaredReference, maxError, peak] = [0, 0, 0, 0];
  const greater = (a: number, b: number) => (Number.isNaN(a) || Number.isNaN(b) ? Number.NaN : Math.max(a, b));
  volumes.forEach((volume, node) => {
    const [error, size] = [0, 0].map((_, which) => Math.hypot(...[0, 1, 2].map((i) => {
      const x = r.displacement[3 * node + i]!;
      return which === 0 ? u.displacement[3 * node + i]! - x : x;
    }))) as [number, number];
    squaredError += volume * error * error;
    squaredReference += volume * size * size;
    maxError = greater(maxError, error);
    peak = greater(peak, size);
  });
  const total = Math.sqrt(sumOfSquares(r.reaction));
  const isResultant = total > (smallestReaction * r.energy) / peak;
  return {
    relativeL2: Math.sqrt(squaredError / squaredReference),
    maxError,
    energyError: (u.energy - r.energy) / r.energy,
    reactionError: isResultant ? Math.sqrt(sumOfSquares(u.reaction.map((x, i) => x - r.reaction[i]!))) / total : Number.NaN,
  };
}

/** Stiffness at the tool at a point of the path, of the place where it is largest in size; NaN where the file has none. */
function stiffnessAt(file: File, model: string, point: number): number {
  const group = `/comparisons/${model}/tool`;
  if (!has(file, `${group}/path`)) return Number.NaN;
  const width = texts(file, `${group}/stiffness`, 'places').length;
  const values = Array.from(rows(file, `${group}/path`, width)).slice(point * width, (point + 1) * width);
  return values.reduce((worst, value) => (Number.isNaN(worst) || Math.abs(value) > Math.abs(worst) ? value : worst), Number.NaN);
}

/** How far the models are from the reference at a point of the path; none of those that did not come so far. */
export function readPointErrors(file: File, { reference, numConstraints }: Result, point: number, volumes: Float64Array): PointErrors[] {
  const expected = stateAt(file, reference, point, volumes, numConstraints);
  if (!expected) return [];
  return children(file, '/solutions').flatMap((model) => {
    const state = model === reference ? null : stateAt(file, model, point, volumes, numConstraints);
    return state ? [{ model, stiffness: stiffnessAt(file, model, point), ...errorsOf(state, expected, volumes) }] : [];
  });
}
