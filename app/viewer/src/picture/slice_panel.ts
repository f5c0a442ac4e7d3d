// One slice on a canvas: voxels in the colours of tissues, lines in which meshes meet it, and the sides of the patient. Dark on any page, as
// on a radiologist's screen, so that colours of lines are seen on all of it.
import { voxelParts, type LabelImage, type VoxelPart } from '../data/label_image.ts';
import type { Surface } from '../data/surface.ts';
import type { Colour } from './colour_maps.ts';
import { contourOf, lengthsOfSlice, placeInSlice, sizeOfSlice, sliceOf, voxelInSlice, type SliceView, type Voxel } from './slices.ts';
import { tissueColours } from './tissue.ts';

export const partColours: Record<VoxelPart, Colour | null> = {
  outside: null, liver: tissueColours.parenchyma, lesion: tissueColours.lesion, vessel: tissueColours.vessel, other: [112, 118, 124],
};
const ground = '#101418', letters = '#d5dade', halo = 'rgb(0 0 0 / 55%)', cross = 'rgb(255 255 255 / 45%)';
const margin = 20; // for the letters [CSS pixels]

/** A mesh whose contour is drawn. */
export interface SliceShape {
  name: string;
  colour: string;
  width: number; // [CSS pixels]
  voxels: Float32Array; // (N,3) of its nodes, as voxelsOf()
}

/** Where slices lie on a screen. [CSS pixels] */
export interface Panel {
  x: number;
  y: number;
  width: number;
  height: number;
  perMetre: number;
}

/** The largest scale at which all slices fit into their panels. */
export const scaleFor = (image: LabelImage, views: SliceView[], width: number, height: number): number =>
  Math.min(...views.flatMap((view) => lengthsOfSlice(image, view).map((length, i) => ([width, height][i]! - 2 * margin) / length)));

/** Upper left corner of the voxels, and the size of one. */
function gridOf(image: LabelImage, view: SliceView, { x, y, width, height, perMetre }: Panel): { corner: [number, number]; voxel: [number, number] } {
  const [columns, rows] = sizeOfSlice(image, view), [across, down] = lengthsOfSlice(image, view).map((length) => length * perMetre) as [number, number];
  return { corner: [x + (width - across) / 2, y + (height - down) / 2], voxel: [across / columns, down / rows] };
}

function bitmapOf(image: LabelImage, view: SliceView, at: number): OffscreenCanvas {
  const [width, height] = sizeOfSlice(image, view);
  const pixels = new ImageData(width, height);
  sliceOf(image, view, at).forEach((part, i) => {
    const colour = partColours[voxelParts[part]!];
    if (colour) pixels.data.set([...colour, 255], 4 * i);
  });
  const bitmap = new OffscreenCanvas(width, height);
  bitmap.getContext('2d')!.putImageData(pixels, 0, 0);
  return bitmap;
}

/** @param through  voxel that all slices go through @param surfaces  of the mesh whose contours are drawn */
export function drawSlice(context: CanvasRenderingContext2D, image: LabelImage, view: SliceView, through: Voxel, surfaces: readonly Surface[], shapes: readonly SliceShape[], panel: Panel): void {
  const { x, y, width, height } = panel;
  const { corner, voxel } = gridOf(image, view, panel);
  const at = through[view.axis], [columns, rows] = sizeOfSlice(image, view);
  const placed = ([column, row]: readonly number[]) => [corner[0] + column! * voxel[0], corner[1] + row! * voxel[1]] as const;
  context.save();
  context.beginPath();
  context.rect(x, y, width, height);
  context.clip();
  context.fillStyle = ground;
  context.fillRect(x, y, width, height);
  context.imageSmoothingEnabled = false;
  context.drawImage(bitmapOf(image, view, at), ...corner, columns * voxel[0], rows * voxel[1]);

  const stroke = (path: Path2D, colour: string, lineWidth: number) => {
    context.strokeStyle = colour;
    context.lineWidth = lineWidth;
    context.stroke(path);
  };
  const [crossX, crossY] = placed(placeInSlice(image, view, through));
  stroke(new Path2D(`M${crossX} ${y + margin}V${y + height - margin}M${x + margin} ${crossY}H${x + width - margin}`), cross, 0.6);
  context.lineCap = 'round';
  const contours = shapes.map(({ voxels }) => {
    const path = new Path2D();
    for (const surface of surfaces) {
      const lines = contourOf(image, view, at, surface, voxels);
      for (let i = 0; i < lines.length; i += 4) {
        path.moveTo(...placed(lines.subarray(i, i + 2) as unknown as number[]));
        path.lineTo(...placed(lines.subarray(i + 2, i + 4) as unknown as number[]));
      }
    }
    return path;
  });
  shapes.forEach((shape, i) => stroke(contours[i]!, halo, shape.width + 1.6)); // below all lines, so that each is seen beside the next
  shapes.forEach((shape, i) => stroke(contours[i]!, shape.colour, shape.width));
  context.fillStyle = letters;
  context.font = '600 13px system-ui, sans-serif';
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  const { left, right, top, bottom } = view.ends;
  for (const [letter, px, py] of [[left, x + margin / 2, y + height / 2], [right, x + width - margin / 2, y + height / 2], [top, x + width / 2, y + margin / 2], [bottom, x + width / 2, y + height - margin / 2]] as const)
    context.fillText(letter, px, py);
  context.restore();
}

/** The voxel at a place of a panel. */
export function voxelAt(image: LabelImage, view: SliceView, through: Voxel, panel: Panel, px: number, py: number): Voxel {
  const { corner, voxel } = gridOf(image, view, panel);
  return voxelInSlice(image, view, [(px - corner[0]) / voxel[0], (py - corner[1]) / voxel[1]], through);
}
