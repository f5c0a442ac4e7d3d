// Where a needle goes: from a place of the surface to what the reader has chosen. Values in, values out.
import type { Lesion } from '../../../data/types.ts';
import type { LiveBody } from '../../types.ts';
import type { NeedleFrame, NeedleTool, NeedleValues } from './types.ts';
import { length, plus, type Vector } from '../../vector.ts';

/** What 18 G meets in liver (load_cases/needles/): toughness of bovine liver, and friction of the right size. */
const diameter = 0.00127, toughness = 164, friction = 20;
/** At which a whole capsule gives way [N]; through a nick it is what tissue takes to tear. */
const wholeCapsule = 1.41;
/** How deep a needle goes that has no target [m]. */
export const straightIn = 0.05;

export function valuesOf(spread: number, isWhole: boolean): NeedleValues {
  return { diameter, spread, toughness, friction, punctureForce: isWhole ? wholeCapsule : toughness * diameter };
}

/** Where a region inside is: its node that is nearest to its centre. */
export function placeOfLesion({ points }: Pick<LiveBody, 'points'>, { node }: Pick<Lesion, 'node'>): Vector {
  return [points[3 * node]!, points[3 * node + 1]!, points[3 * node + 2]!];
}

/** @param target  null for straight in along the normal */
export function targetFrom(entry: Vector, inwards: Vector, target: Vector | null): Vector {
  return target ?? plus(entry, inwards, straightIn);
}

export const lengthOf = ({ entry, target }: Pick<NeedleTool, 'entry' | 'target'>): number => length(plus(target, entry, -1));

/** The point of the axis that is so far below the entry. */
export function pointAt(tool: Pick<NeedleTool, 'entry' | 'target'>, depth: number): Vector {
  return plus(tool.entry, plus(tool.target, tool.entry, -1), depth / lengthOf(tool));
}

/** How far the target is from its place at rest, and the tip from where the target is now [m]. */
export function targetErrors(tool: NeedleTool, frame: NeedleFrame): { moved: number; left: number } {
  const now = plus(tool.target, frame.targetMoved);
  return { moved: length(frame.targetMoved), left: length(plus(now, pointAt(tool, frame.depth), -1)) };
}
