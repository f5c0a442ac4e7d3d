// Slices of a label image, with what of a mesh lies in them. Each goes along voxels, and lies as on a radiologist's screen.
import type { LabelImage } from '../data/label_image.ts';
import type { Surface } from '../data/surface.ts';
import { outlineOf } from './section.ts';

type Axis = 0 | 1 | 2;
export type Voxel = [number, number, number]; // of the image; parts of one between centres

/** How slices across an axis of the image are shown. */
export interface SliceView {
  name: string; // that of the patient's axis that is nearest to the axis
  across: Axis; // that axis
  axis: Axis; // of the image
  right: Axis;
  down: Axis;
  isRightBack: boolean; // whether the image goes the other way
  isDownBack: boolean;
  isAcrossBack: boolean; // whether the image goes from left, back or head to the other end
  ends: { left: string; right: string; top: string; bottom: string }; // sides of the patient
}

/** Ends of the patient's axes. x goes to the left, y to the back, z to the head (LPS). */
const ends = [['R', 'L'], ['A', 'P'], ['I', 'S']] as const;
const names = ['Sagittal', 'Coronal', 'Axial'] as const;
const orders: Axis[][] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/** The axis of the patient of each axis of the image: of all ways to pair them, the one that is nearest. */
function patientAxes({ steps }: LabelImage): Axis[] {
  const along = (axis: number, patient: number) => Math.abs(steps[axis]![patient]!) / Math.hypot(...steps[axis]!);
  const near = (order: Axis[]) => order.reduce<number>((sum, patient, axis) => sum + along(axis, patient), 0);
  return orders.reduce((best, order) => (near(order) > near(best) + 1e-9 ? order : best));
}

/** How far the axes of an image are from those of the patient [degrees]. */
export function turnOf(image: LabelImage): number {
  const cosines = patientAxes(image).map((patient, axis) => Math.abs(image.steps[axis]![patient]!) / Math.hypot(...image.steps[axis]!));
  return (Math.acos(Math.min(1, ...cosines)) * 180) / Math.PI;
}

/** The axial, the coronal and the sagittal view. */
export function sliceViews(image: LabelImage): SliceView[] {
  const patient = patientAxes(image);
  const imageAxis = (of: Axis) => patient.indexOf(of) as Axis;
  return ([2, 1, 0] as Axis[]).map((across) => {
    const [horizontal, vertical] = ([0, 1, 2] as Axis[]).filter((axis) => axis !== across) as [Axis, Axis];
    const [right, down] = [imageAxis(horizontal), imageAxis(vertical)];
    const isHeadUp = vertical === 2; // and the front is up otherwise
    return {
      name: names[across],
      across,
      axis: imageAxis(across),
      right,
      down,
      isRightBack: image.steps[right]![horizontal]! < 0,
      isDownBack: image.steps[down]![vertical]! < 0 !== isHeadUp,
      isAcrossBack: image.steps[imageAxis(across)]![across]! < 0,
      ends: { left: ends[horizontal][0], right: ends[horizontal][1], top: ends[vertical][isHeadUp ? 1 : 0], bottom: ends[vertical][isHeadUp ? 0 : 1] },
    };
  });
}

type Vector = readonly [number, number, number];
const cross = (a: Vector, b: Vector): Vector => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a: ArrayLike<number>, b: ArrayLike<number>) => a[0]! * b[0]! + a[1]! * b[1]! + a[2]! * b[2]!;

/** Places in the world [m] as voxels of an image. @param places (N,3) @return (N,3) */
export function voxelsOf({ origin, steps }: LabelImage, places: ArrayLike<number>): Float32Array {
  const volume = dot(steps[0], cross(steps[1], steps[2]));
  const inverse = [cross(steps[1], steps[2]), cross(steps[2], steps[0]), cross(steps[0], steps[1])].map((row) => row.map((x) => x / volume));
  const voxels = new Float32Array(places.length);
  for (let i = 0; i < places.length; i += 3) {
    const from = [0, 1, 2].map((a) => places[i + a]! - origin[a]!);
    inverse.forEach((row, a) => (voxels[i + a] = dot(row, from)));
  }
  return voxels;
}

/** The place of a voxel in the world [m]. */
export const placeOfVoxel = ({ origin, steps }: LabelImage, voxel: readonly number[]): Voxel =>
  [0, 1, 2].map((a) => origin[a]! + voxel.reduce((sum, x, axis) => sum + x * steps[axis]![a]!, 0)) as Voxel;

/** The nearest voxel of the image. */
export const insideImage = ({ size }: LabelImage, voxel: readonly number[]): Voxel =>
  voxel.map((x, axis) => Math.min(Math.max(Math.round(x), 0), size[axis]! - 1)) as Voxel;

/** Width and height in voxels. */
export const sizeOfSlice = ({ size }: LabelImage, { right, down }: SliceView): [width: number, height: number] => [size[right], size[down]];

/** The same in metres. */
export function lengthsOfSlice(image: LabelImage, view: SliceView): [width: number, height: number] {
  const [width, height] = sizeOfSlice(image, view);
  return [width * Math.hypot(...image.steps[view.right]), height * Math.hypot(...image.steps[view.down])];
}

/** Parts of the voxels of a slice, row by row from above. */
export function sliceOf(image: LabelImage, view: SliceView, at: number): Uint8Array {
  const [width, height] = sizeOfSlice(image, view);
  const strides = [1, image.size[0], image.size[0] * image.size[1]];
  const found = new Uint8Array(width * height);
  for (let row = 0; row < height; row++)
    for (let column = 0; column < width; column++) {
      const right = view.isRightBack ? width - 1 - column : column, down = view.isDownBack ? height - 1 - row : row;
      found[row * width + column] = image.part[at * strides[view.axis]! + right * strides[view.right]! + down * strides[view.down]!]!;
    }
  return found;
}

/** Where a voxel is in a slice: columns and rows from the outer edge of its upper left one, so that the first has its centre at one half. */
export function placeInSlice(image: LabelImage, view: SliceView, voxel: ArrayLike<number>): [column: number, row: number] {
  const [width, height] = sizeOfSlice(image, view);
  const [x, y] = [voxel[view.right]! + 0.5, voxel[view.down]! + 0.5];
  return [view.isRightBack ? width - x : x, view.isDownBack ? height - y : y];
}

/** The voxel at a place of a slice: the inverse. */
export function voxelInSlice(image: LabelImage, view: SliceView, [column, row]: readonly [number, number], through: Voxel): Voxel {
  const [width, height] = sizeOfSlice(image, view);
  const voxel = [...through] as Voxel;
  voxel[view.right] = (view.isRightBack ? width - column : column) - 0.5;
  voxel[view.down] = (view.isDownBack ? height - row : row) - 0.5;
  return insideImage(image, voxel);
}

/** Where surfaces meet a slice: pairs of ends of lines. @param voxels (N,3) of the nodes, as voxelsOf() @return (L,2,2) columns and rows */
export function contourOf(image: LabelImage, view: SliceView, at: number, surface: Surface, voxels: Float32Array): Float32Array {
  const lines = outlineOf({ axis: view.axis, place: at, keepsAbove: true }, surface, voxels);
  const found = new Float32Array((2 * lines.length) / 3);
  for (let i = 0; i < lines.length / 3; i++) found.set(placeInSlice(image, view, lines.subarray(3 * i, 3 * i + 3)), 2 * i);
  return found;
}
