// What the springs are told of a grasp, and what they answer before all else: see app/live/messages.hpp.
import type { GraspFrame, GraspTool } from './types.ts';
import type { Vector } from '../../vector.ts';

export function graspMessage({ place, inwards, target, radius, depth }: GraspTool, numSteps: number): Float64Array {
  return Float64Array.of(8, ...place, ...inwards, ...target, radius, depth, numSteps);
}

/** @param numbers  of the answer, from the front */
export function readGrasp(numbers: { number(): number; vector(): Vector }): GraspFrame {
  return { depth: numbers.number(), closing: numbers.number(), other: numbers.vector(), otherForce: numbers.vector() };
}
