// An experiment file as results/schema.md describes it, checked where it enters the page.
import type { File } from 'h5wasm';
import type { Experiment, ExperimentModel, ExperimentState, Markers } from './experiment.ts';
import { children, has, number, refuse, rows, text, texts } from './hdf5.ts';
import { compactSurface } from './surface.ts';

const group = '/experiment';
const knownSchema = 1;
const statuses = ['ok', 'diverged', 'not_converged'];

/** A dataset of a known number of rows. */
function sized(file: File, path: string, count: number, columns = 1): Float64Array {
  const values = rows(file, path, columns);
  if (values.length !== count * columns) throw refuse(file, `${path} does not have ${count} rows`);
  return Float64Array.from(values);
}

function namesIn(file: File, path: string, name: string, count?: number): string[] {
  const found = texts(file, path, name);
  if (found.length === 0) throw refuse(file, `${path} has no ${name}`);
  if (count !== undefined && found.length !== count) throw refuse(file, `${path} does not have ${count} ${name}`);
  return found;
}

function refuseWhatIsNoNumber(file: File, path: string, values: ArrayLike<number>, what: string): void {
  for (let i = 0; i < values.length; i++)
    if (!Number.isFinite(values[i])) throw refuse(file, `${path} has a place that is no number, of ${what} ${Math.floor(i / 3)}`);
}

function readMarkers(file: File): Markers {
  const path = `${group}/markers`;
  if (!has(file, path))
    throw refuse(file, 'It compares forces and no markers', 'livermark experiment --figure draws them');
  const names = namesIn(file, path, 'names');
  const drives = namesIn(file, path, 'drives', names.length);
  const position = sized(file, `${path}/position`, names.length, 3);
  refuseWhatIsNoNumber(file, `${path}/position`, position, 'marker');
  return { names, drives, position };
}

function readStates(file: File, numMarkers: number, numNodes: number): ExperimentState[] {
  const path = `${group}/states`;
  const names = namesIn(file, path, 'names');
  const count = names.length;
  const numbers = (name: string) => sized(file, `${path}/${name}`, count);
  const measured = sized(file, `${path}/displacement`, count, 3 * numMarkers);
  const deformed = sized(file, `${group}/body/displacement`, count, 3 * numNodes);
  const [noise, noMotion, rigidMotion] = [numbers('noise'), numbers('no_motion'), numbers('rigid_motion')];
  const affineMap = has(file, `${path}/affine_map`) ? numbers('affine_map') : new Float64Array(count).fill(Number.NaN); // files of older versions have none
  const [straightLine, fitResidual, uncertainty] = [numbers('straight_line'), numbers('fit_residual'), numbers('reference_uncertainty')];
  return names.map((name, s) => ({
    name,
    measured: measured.slice(3 * numMarkers * s, 3 * numMarkers * (s + 1)),
    deformed: Float32Array.from(deformed.subarray(3 * numNodes * s, 3 * numNodes * (s + 1))),
    noise: noise[s]! > 0 ? noise[s]! : Number.NaN,
    noMotion: noMotion[s]!,
    rigidMotion: rigidMotion[s]!,
    affineMap: affineMap[s]!,
    straightLine: straightLine[s]!,
    fitResidual: fitResidual[s]!,
    referenceUncertainty: uncertainty[s]!,
  }));
}

/** The larger the worse, with those last that have no solution somewhere. */
const badness = ({ runs }: ExperimentModel) =>
  runs.reduce((sum, run) => sum + (run?.status === 'ok' && Number.isFinite(run.error) ? run.error : Infinity), 0);

function readModels(file: File, numStates: number, numMarkers: number): ExperimentModel[] {
  const path = `${group}/runs`;
  const names = namesIn(file, path, 'models');
  const count = names.length;
  const words = namesIn(file, path, 'statuses', count);
  const messages = namesIn(file, path, 'messages', count);
  const numbers = (name: string) => sized(file, `${path}/${name}`, count);
  const [state, tetrahedra, error, worst, seconds] = [numbers('state'), numbers('tetrahedra'), numbers('error'), numbers('worst_error'), numbers('seconds')];
  const computed = sized(file, `${path}/displacement`, count, 3 * numMarkers);
  const models = new Map<string, ExperimentModel>();
  names.forEach((name, r) => {
    if (!statuses.includes(words[r]!)) throw refuse(file, `${path} has a status '${words[r]}' that is not known`);
    if (!(state[r]! >= 0 && state[r]! < numStates)) throw refuse(file, `${path}/state has a state that is not there`);
    const key = `${tetrahedra[r]} ${name}`;
    const model = models.get(key) ?? { name, tetrahedra: tetrahedra[r]!, runs: Array<null>(numStates).fill(null) };
    models.set(key, model);
    model.runs[state[r]!] = {
      status: words[r]!,
      message: messages[r]!,
      error: error[r]!,
      worstError: worst[r]!,
      seconds: seconds[r]!,
      computed: computed.slice(3 * numMarkers * r, 3 * numMarkers * (r + 1)),
    };
  });
  return [...models.values()].sort((a, b) => badness(a) - badness(b) || 0);
}

/** @throws Fault with a sentence that names the place in the file */
export function readExperiment(file: File, name: string): Experiment {
  const schema = number(file, '/', 'schema_version');
  if (schema !== knownSchema)
    throw refuse(file, `It is of schema ${schema}, and this page reads schema ${knownSchema}`, 'use the page of the same version');
  const markers = readMarkers(file);
  const points = rows(file, `${group}/body/points`, 3);
  refuseWhatIsNoNumber(file, `${group}/body/points`, points, 'node');
  const triangles = rows(file, `${group}/body/boundary_triangles`, 3);
  for (let i = 0; i < triangles.length; i++)
    if (!(triangles[i]! >= 0 && triangles[i]! < points.length / 3))
      throw refuse(file, `${group}/body/boundary_triangles names a node that is not there`);
  const states = readStates(file, markers.names.length, points.length / 3);
  return {
    file: name,
    name: text(file, group, 'name'),
    title: text(file, group, 'title'),
    source: text(file, group, 'source'),
    assumptions: texts(file, group, 'assumptions'),
    reference: text(file, group, 'reference'),
    markers,
    states,
    models: readModels(file, states.length, markers.names.length),
    points: Float32Array.from(points),
    surface: compactSurface(triangles),
    numRingDowns: children(file, `${group}/ring_downs`).length,
  };
}
