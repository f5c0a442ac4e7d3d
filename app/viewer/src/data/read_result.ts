// A result file as results/schema.md describes it, checked where it enters the page.
import type { File } from 'h5wasm';
import { carriersOf } from './carriers.ts';
import { children, has, number, rows, text, texts } from './hdf5.ts';
import { readConditions } from './read_conditions.ts';
import { readMesh } from './read_mesh.ts';
import { readCapsule, readNodalModulus, readVessels } from './read_parts.ts';
import { readPatches } from './read_patches.ts';
import { movingPlaces, numPointsOf, readLoads } from './read_path.ts';
import { lesionsOf } from './lesions.ts';
import { compactSurface, innerTriangles } from './surface.ts';
import { Fault, type Comparison, type Model, type Result } from './types.ts';
import { tissueOfNodes } from '../picture/tissue.ts';

const knownSchema = 1;
const madeOfImage = 'made of the segmentation '; // how the reader of bodies begins its remark on the image

/** Livermark writes other files too, in which there is no body to be drawn. */
function refuseOtherFiles(file: File): void {
  if (has(file, '/mesh') && children(file, '/solutions').length > 0) return;
  const kinds: [path: string, kind: string][] = [
    ['/modes', 'vibrations (livermark modes)'],
    ['/critical_time_step', 'time steps (livermark stability)'],
    ['/springs', 'calibrated springs (python3 -m livermark.calibration)'],
    ['/timings', 'timings of the benchmarks'],
    ['/statistics', 'errors over a cohort (livermark cohort)'],
    ['/arena', 'accuracy and time of methods (livermark arena)'],
    ['/needles', 'needles in bodies (livermark needle)'],
    ['/sensitivity', 'indices of a sensitivity analysis (livermark sensitivity)'],
  ];
  const kind = kinds.find(([path]) => has(file, path))?.[1];
  const what = kind ? `it holds ${kind}` : 'it is an HDF5 file of something else';
  throw new Fault(`It has no solution of a model: ${what}. Choose a file that livermark run or livermark experiment wrote.`);
}

function readComparison(file: File, model: string): Comparison | null {
  const path = `/comparisons/${model}`;
  const value = (name: string) => number(file, path, name);
  if (!has(file, path) || Number.isNaN(value('relative_l2')) && !text(file, path, 'reference')) return null;
  return {
    reference: text(file, path, 'reference'),
    relativeL2: value('relative_l2'),
    stiffness: value('stiffness_at_tool'),
    maxError: value('max_error'),
    energyError: value('energy_error'),
    reactionError: value('reaction_error'),
    motionError: value('history_relative_l2'),
    motionLag: value('history_lag'),
    motionReference: text(file, path, 'history_reference'),
  };
}

function readModel(file: File, name: string, numNodes: number): Model {
  const path = `/solutions/${name}`;
  return {
    name,
    summary: text(file, path, 'summary'),
    source: text(file, path, 'source'),
    status: text(file, path, 'status'),
    message: text(file, path, 'message'),
    solveSeconds: number(file, path, 'solve_seconds'),
    moves: has(file, `${path}/history/frames`),
    numPoints: numPointsOf(file, name, numNodes),
    comparison: readComparison(file, name),
  };
}

/** Finite elements after a name that the file gives, or the first model if no model was compared. */
function referenceOf(file: File, models: Model[]): string {
  const named = text(file, '/reference', 'model') || models.map((m) => m.comparison?.reference).find(Boolean);
  return models.some((m) => m.name === named) ? named! : models[0]!.name;
}

function frameTimes(file: File): number[] {
  return has(file, '/VTKHDF/Steps/Values') ? Array.from(rows(file, '/VTKHDF/Steps/Values', 1)) : [];
}

/** @throws Fault with a sentence that names the place in the file */
export function readResult(file: File, name: string): Result {
  refuseOtherFiles(file);
  const schema = number(file, '/', 'schema_version');
  if (schema !== knownSchema)
    throw new Fault(`It is of schema ${schema}, and this page reads schema ${knownSchema}; use the page of the same version.`);
  const { points, tetrahedra, region, triangles } = readMesh(file);
  const models = children(file, '/solutions').map((model) => readModel(file, model, points.length / 3));
  const patches = readPatches(file, triangles.length / 3);
  const conditions = readConditions(file, triangles, patches, points.length / 3);
  const constraints = texts(file, '/load_case/constraint', 'names');
  const regions = texts(file, '/mesh/region', 'names');
  const vessels = readVessels(file);
  return {
    file: name,
    body: text(file, '/', 'body'),
    loadCase: text(file, '/load_case', 'name'),
    title: text(file, '/load_case', 'title'),
    reference: referenceOf(file, models),
    referenceUncertainty: number(file, '/reference', 'reference_uncertainty'),
    motionReference: models.map((m) => m.comparison?.motionReference).find(Boolean) ?? '',
    models,
    points: Float32Array.from(points),
    surfaces: {
      outside: compactSurface(triangles),
      inside: compactSurface(innerTriangles(tetrahedra, region)),
    },
    tetrahedra: Int32Array.from(tetrahedra),
    lesions: lesionsOf(regions, points, tetrahedra, region),
    isOfImage: texts(file, '/mesh', 'assumptions').some((remark) => remark.startsWith(madeOfImage)),
    isAnatomical: regions[0] === 'parenchyma',
    conditions,
    patches,
    capsule: readCapsule(file, patches),
    vessels: vessels && { ...vessels, carriers: carriersOf(vessels.points, points, tetrahedra, triangles) },
    tissue: tissueOfNodes(points.length / 3, tetrahedra, region, regions),
    modulus: readNodalModulus(file, points, tetrahedra, region),
    loads: readLoads(file),
    numConstraints: constraints.length,
    places: movingPlaces(conditions, constraints),
    frameTimes: models.some((m) => m.moves) ? frameTimes(file) : [],
    probes: texts(file, '/load_case/release/probe', 'names'),
  };
}
