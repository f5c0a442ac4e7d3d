// The little of HDF5 that the page needs, with checks: what a file lacks is a sentence, not an exception of the library.
import { Dataset, Group, type File } from 'h5wasm';
import { Fault } from './types.ts';

type Scalar = string | number | bigint;

const makers = new WeakMap<File, string>(); // of files that `livermark run` did not write

/** Says which command writes files of this kind. */
export const setMaker = (file: File, command: string) => makers.set(file, command);

/** What is wrong with a file, and what to do about it. */
export const refuse = (file: File, fault: string, remedy = `make the file again with ${makers.get(file) ?? 'livermark run'}`) =>
  new Fault(`${fault}; ${remedy}.`);

const own = new WeakMap<File, Set<string>>(); // places that were found to be in the file itself

/** The library would follow a link to whatever it names. */
function refuseLinks(file: File, path: string): void {
  const known = own.get(file) ?? new Set<string>();
  own.set(file, known);
  let parent = '/';
  for (const name of path.split('/').filter(Boolean)) {
    const part = parent === '/' ? `/${name}` : `${parent}/${name}`;
    if (!known.has(part)) {
      if (!names(file, parent).includes(name)) return; // it is not there
      if (file.get_link(part) || file.get_external_link(part)?.filename)
        throw refuse(file, `${part} is a link to another place, and links are not followed`);
      known.add(part);
    }
    parent = part;
  }
}

function names(file: File, path: string): string[] {
  try {
    return new Group(file.file_id, path).keys();
  } catch {
    return []; // no group
  }
}

function group(file: File, path: string): Group | null {
  refuseLinks(file, path);
  try {
    const found = file.get(path);
    return found instanceof Group ? found : null;
  } catch {
    return null;
  }
}

export function has(file: File, path: string): boolean {
  return dataset(file, path) !== null || group(file, path) !== null;
}

/** Names of what is in a group; none if the group is not there. */
export function children(file: File, path: string): string[] {
  return group(file, path)?.keys() ?? [];
}

export function dataset(file: File, path: string): Dataset | null {
  refuseLinks(file, path);
  try {
    const found = file.get(path);
    return found instanceof Dataset ? found : null;
  } catch {
    return null;
  }
}

function attribute(file: File, path: string, name: string): unknown {
  const owner = path === '/' ? file : (dataset(file, path) ?? group(file, path));
  return owner?.attrs[name]?.value ?? undefined;
}

/** Texts are padded with null characters. */
const trimmed = (text: unknown) => String(text).replace(/\0+$/, '');

export function text(file: File, path: string, name: string): string {
  const value = attribute(file, path, name);
  return value === undefined ? '' : trimmed(value);
}

export function texts(file: File, path: string, name: string): string[] {
  const value = attribute(file, path, name);
  return Array.isArray(value) ? value.map(trimmed) : value === undefined ? [] : [trimmed(value)];
}

/** NaN if it is not there. */
export function number(file: File, path: string, name: string): number {
  const value = attribute(file, path, name) as Scalar | ArrayLike<Scalar> | undefined;
  if (value === undefined) return Number.NaN;
  return Number(typeof value === 'object' ? value[0] : value);
}

type Numbers = ArrayLike<number> | BigInt64Array;

/** int64 arrives as BigInt64Array; node numbers are far below 2^53. */
function asNumbers(values: Numbers): ArrayLike<number> {
  return values instanceof BigInt64Array ? Float64Array.from(values, Number) : values;
}

/**
 * Rows of a dataset, one behind the other.
 * @param columns  length of a row; 1 for a dataset of rank 1
 * @param range    first row and the one behind the last; all if left out
 */
export function rows(file: File, path: string, columns: number, range?: [number, number]): ArrayLike<number> {
  const found = dataset(file, path);
  if (!found) throw refuse(file, `${path} is missing`);
  const shape = found.shape ?? [];
  if (shape.slice(1).reduce((product, length) => product * length, 1) !== columns)
    throw refuse(file, `${path} does not have rows of ${columns}`);
  if (range && !(range[0] >= 0 && range[1] <= (shape[0] ?? 0)))
    throw refuse(file, `${path} is too short`);
  const slice = range ? [range, ...shape.slice(1).map((length) => [0, length] as [number, number])] : undefined;
  const values = slice ? found.slice(slice) : found.value;
  if (!values || typeof values !== 'object')
    throw refuse(file, `${path} cannot be read: the file is damaged`);
  return asNumbers(values as Numbers);
}

/** A dataset of a known number of rows. */
export function exactly(count: number, path: string, columns: number, values: ArrayLike<number>): ArrayLike<number> {
  if (values.length !== count * columns)
    throw new Fault(`${path} does not have ${count} rows; make the file again with livermark run.`);
  return values;
}
