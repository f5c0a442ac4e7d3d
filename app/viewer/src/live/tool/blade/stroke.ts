// A stroke across the picture as a cut. Values in, values out.
import type { CutTool } from './types.ts';
import { dot, length, plus, type Vector } from '../../vector.ts';

/** How thick a blade is that takes what it touches [m]. */
export const thickness = 0.001;
/** A shorter stroke is a slip of the hand [m]. */
export const shortest = 0.005;

export interface Stroke {
  from: Vector; // on the surface [m]
  to: Vector; // as far from the viewer [m]
  away: Vector; // from the viewer, of length 1
}

function cross(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

export const lengthOfStroke = ({ from, to }: Stroke): number => length(plus(to, from, -1));

/** @param right, up  of the screen, of length 1 */
export function strokeOf(from: Vector, right: Vector, up: Vector, metresRight: number, metresUp: number): Stroke {
  const away = cross(up, right);
  return { from, to: plus(plus(from, right, metresRight), up, metresUp), away: away.map((x) => x / length(away)) as Vector };
}

/**
 * A blade that goes straight away from the viewer along the stroke.
 * @param depth  below where the stroke begins [m]
 * @param reach      towards the viewer: the surface may bulge between both ends [m]
 * @param thickness  0 for a blade that parts [m]
 */
export function bladeOf({ from, to, away }: Stroke, depth: number, reach: number, thickness: number): CutTool {
  return { kind: 'blade', corners: [plus(from, away, -reach), plus(to, away, -reach), plus(to, away, depth), plus(from, away, depth)], thickness };
}

/** All that is to the right of who goes along the stroke, seen by the viewer. */
export function beyondStroke({ from, to, away }: Stroke): CutTool {
  const along = plus(to, from, -1);
  const across = plus(along, away, -dot(along, away));
  return { kind: 'half-space', point: from, normal: cross(away, across) };
}
