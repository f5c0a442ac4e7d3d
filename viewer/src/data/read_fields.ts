// Fields of one model, at the nodes of the mesh.
import type { File } from 'h5wasm';
import { children, dataset, has, rows } from './hdf5.ts';
import type { Field, Frame, Largest, NodeValues, ProbeMotion } from './types.ts';

const displacementPath = (model: string, frame: Frame) =>
  frame === null ? `/solutions/${model}/displacement` : `/solutions/${model}/history/frames`;
const errorPath = (model: string, frame: Frame) =>
  frame === null ? `/comparisons/${model}/error` : `/comparisons/${model}/error_frames`;

/** Frames stand one behind the other. */
function rowsOf(file: File, path: string, numNodes: number, frame: Frame): Float32Array {
  const first = (frame ?? 0) * numNodes;
  return Float32Array.from(rows(file, path, 3, [first, first + numNodes]));
}

export function readField(file: File, model: string, frame: Frame, numNodes: number): Omit<Field, 'strain'> {
  const error = errorPath(model, frame);
  return {
    displacement: rowsOf(file, displacementPath(model, frame), numNodes, frame),
    error: has(file, error) ? rowsOf(file, error, numNodes, frame) : null,
  };
}

function largestLength(file: File, path: string): number {
  if (!dataset(file, path)) return 0;
  const vectors = rows(file, path, 3);
  let largest = 0;
  for (let i = 0; i < vectors.length; i += 3) {
    const length = Math.hypot(vectors[i]!, vectors[i + 1]!, vectors[i + 2]!);
    if (Number.isFinite(length) && length > largest) largest = length;
  }
  return largest;
}

/** Over the static answer, or over all frames, so that colours mean the same at all times. */
export function readLargest(file: File, model: string, moving: boolean): Omit<Largest, 'strain'> {
  const frame = moving ? 0 : null;
  return {
    displacement: largestLength(file, displacementPath(model, frame)),
    error: largestLength(file, errorPath(model, frame)),
  };
}

function vectorAt(file: File, path: string, row: number): number[] | null {
  return dataset(file, path) ? Array.from(rows(file, path, 3, [row, row + 1])) : null;
}

/** In every model that has such a field. */
export function readNode(file: File, node: number, frame: Frame, numNodes: number): NodeValues[] {
  const row = (frame ?? 0) * numNodes + node;
  return children(file, '/solutions').flatMap((model) => {
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

