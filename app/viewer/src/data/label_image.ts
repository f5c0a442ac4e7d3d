// The label image that a body was made of, as the server hands it over (`livermark-segment voxels`), checked where it enters the page.
import { Fault } from './types.ts';

/** What a voxel is of. */
export const voxelParts = ['outside', 'liver', 'lesion', 'vessel', 'other'] as const;
export type VoxelPart = (typeof voxelParts)[number];

type Vector = [number, number, number];

/** The voxels around the body. */
export interface LabelImage {
  size: Vector; // along each axis of the image
  origin: Vector; // centre of the first voxel in the world [m]
  steps: [Vector, Vector, Vector]; // from voxel to voxel along each axis [m]
  part: Uint8Array; // (voxels) index into voxelParts, with the first axis fastest
}

const mostVoxels = 2 ** 26; // as the server bounds it

const isVector = (value: unknown): value is Vector => Array.isArray(value) && value.length === 3 && value.every((x) => Number.isFinite(x));

/** Parts of all voxels out of runs: a part, how many voxels in a row are of it, and so on. */
function unpacked(runs: number[], known: readonly string[], numVoxels: number): Uint8Array | null {
  const part = new Uint8Array(numVoxels);
  let at = 0;
  for (let i = 0; i + 1 < runs.length; i += 2) {
    const index = voxelParts.indexOf(known[runs[i]!] as VoxelPart), count = runs[i + 1]!;
    if (index < 0 || !(count > 0) || at + count > numVoxels) return null;
    part.fill(index, at, at + count);
    at += count;
  }
  return at === numVoxels ? part : null;
}

/** @throws Fault if it is no such image */
export function labelImageOf(json: unknown): LabelImage {
  const { size, origin, steps, parts, runs } = (json ?? {}) as Record<string, unknown>;
  const isGrid = isVector(size) && size.every((n) => Number.isInteger(n) && n > 0) && size[0] * size[1] * size[2] <= mostVoxels
    && isVector(origin) && Array.isArray(steps) && steps.length === 3 && steps.every((step) => isVector(step) && Math.hypot(...step) > 0);
  const part = isGrid && Array.isArray(parts) && Array.isArray(runs) ? unpacked(runs as number[], parts as string[], size[0] * size[1] * size[2]) : null;
  if (!isGrid || !part) throw new Fault('The server’s image cannot be read; use the page of the same version.');
  return { size, origin, steps: steps as LabelImage['steps'], part };
}

/**
 * The image of the body of a result file.
 * @param path  in the server's list
 * @throws Fault with why there is none
 */
export async function fetchLabelImage(path: string): Promise<LabelImage> {
  const response = await fetch(`image/${path.split('/').map(encodeURIComponent).join('/')}`).catch(() => null);
  if (!response) throw new Fault('The server does not answer; start livermark view again.');
  if (!response.ok) throw new Fault((await response.text()).trim());
  return labelImageOf(await response.json());
}
