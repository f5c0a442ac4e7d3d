// Fields of one model, at the nodes of the mesh.
import type { File } from 'h5wasm';
import { children, dataset, has, rows } from './hdf5.ts';
import { numPointsOf, readPoint, readPointError } from './read_path.ts';
import type { Field, Frame, Largest, Moment, NodeValues, ProbeMotion, Result } from './types.ts';

type Source = Pick<Result, 'reference'> & { file: File; numNodes: number };

const displacementPath = (model: string, frame: Frame) =>
  frame === null ? `/solutions/${model}/displacement` : `/solutions/${model}/history/frames`;
const errorPath = (model: string, frame: Frame) =>
  frame === null ? `/comparisons/${model}/error` : `/comparisons/${model}/error_frames`;

/** Frames stand one behind the other. */
function rowsOf(file: File, path: string, numNodes: number, frame: Frame): Float32Array {
  const first = (frame ?? 0) * numNodes;
  return Float32Array.from(rows(file, path, 3, [first, first + numNodes]));
}

/** A model that did not come so far on the path has no numbers there. */
export function readField({ file, reference, numNodes }: Source, model: string, { frame, point }: Moment): Omit<Field, 'strain'> {
  if (frame === null && point !== null)
    return {
      displacement: readPoint(file, model, point, numNodes) ?? new Float32Array(3 * numNodes).fill(Number.NaN),
      error: readPointError(file, model, reference, point, numNodes),
    };
  const error = errorPath(model, frame);
  return {
    displacement: rowsOf(file, displacementPath(model, frame), numNodes, frame),
    error: has(file, error) ? rowsOf(file, error, numNodes, frame) : null,
  };
}

function largestLength(vectors: ArrayLike<number> | null): number {
  let largest = 0;
  for (let i = 0; i < (vectors?.length ?? 0); i += 3) {
    const length = Math.hypot(vectors![i]!, vectors![i + 1]!, vectors![i + 2]!);
    if (Number.isFinite(length) && length > largest) largest = length;
  }
  return largest;
}

/** Over all frames, or over the static answer and all points of the path, so that colours mean the same at all of them. */
export function readLargest(source: Source, model: string, moving: boolean): Omit<Largest, 'strain'> {
  const { file, numNodes } = source;
  const numPoints = moving ? 0 : numPointsOf(file, model, numNodes);
  const fields = Array.from({ length: numPoints }, (_, point) => readField(source, model, { frame: null, point }));
  const frame = moving ? 0 : null;
  const largest = (path: string, of: 'displacement' | 'error') =>
    Math.max(dataset(file, path) ? largestLength(rows(file, path, 3)) : 0, ...fields.map((field) => largestLength(field[of])));
  return { displacement: largest(displacementPath(model, frame), 'displacement'), error: largest(errorPath(model, frame), 'error') };
}

function vectorAt(file: File, path: string, row: number): number[] | null {
  return dataset(file, path) ? Array.from(rows(file, path, 3, [row, row + 1])) : null;
}

/** In every model that has such a field. */
export function readNode({ file, reference, numNodes }: Source, node: number, { frame, point }: Moment): NodeValues[] {
  const models = children(file, '/solutions');
  if (frame === null && point !== null) {
    const at = (model: string) => vectorAt(file, `/solutions/${model}/path/displacement`, point * numNodes + node)!;
    const there = models.filter((model) => point < numPointsOf(file, model, numNodes));
    const expected = there.includes(reference) ? at(reference) : null;
    return there.map((model) => {
      const displacement = at(model);
      return { model, displacement, error: expected && model !== reference ? displacement.map((x, i) => x - expected[i]!) : null };
    });
  }
  const row = (frame ?? 0) * numNodes + node;
  return models.flatMap((model) => {
    const displacement = vectorAt(file, displacementPath(model, frame), row);
    return displacement ? [{ model, displacement, error: vectorAt(file, errorPath(model, frame), row) }] : [];
  });
}

/**
 * How a probe moves in the models that move.
 * @param reference  the model whose first displacement gives the direction
 */
export function readMotion(file: File, probe: number, numProbes: number, reference: string): ProbeMotion[] {
  const path = (model: string) => `/solutions/${model}/history/displacement`;
  const moving = children(file, '/solutions').filter((model) => has(file, path(model)));
  const read = (model: string) => rows(file, path(model), 3 * numProbes);
  const at = (u: ArrayLike<number>, k: number) => [0, 1, 2].map((i) => u[3 * (k * numProbes + probe) + i]!);
  const start = at(read(moving.includes(reference) ? reference : moving[0]!), 0);
  const length = Math.hypot(...start) || 1;
  return moving.map((model) => {
    const u = read(model);
    const time = Float64Array.from(rows(file, `/solutions/${model}/history/time`, 1));
    const along = time.map((_, k) => at(u, k).reduce((sum, x, i) => sum + (x * start[i]!) / length, 0));
    return { model, time, along };
  });
}
