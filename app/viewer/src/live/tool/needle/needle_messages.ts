// What the springs are told of a needle, and what they answer before all else: see app/live/messages.hpp.
import type { NeedleFrame, NeedleTool } from './types.ts';
import type { Vector } from '../../vector.ts';

export function needleMessage({ entry, target, depth, values }: NeedleTool, numSteps: number): Float64Array {
  const { diameter, spread, toughness, friction, punctureForce } = values;
  return Float64Array.of(6, ...entry, ...target, diameter, spread, toughness, friction, punctureForce, depth, numSteps);
}

/** @param numbers  of the answer, from the front @param tool  that was asked for */
export function readNeedle(numbers: { number(): number; vector(): Vector; take(count: number): Float64Array }, tool: NeedleTool): NeedleFrame {
  return {
    depth: numbers.number(),
    tip: numbers.number(),
    force: numbers.number(),
    tipForce: numbers.number(),
    isPunctured: numbers.number() !== 0,
    targetMoved: numbers.vector(),
    work: { hand: numbers.number(), friction: numbers.number(), tearing: numbers.number() },
    line: { entry: tool.entry, target: tool.target, spread: tool.values.spread },
    forces: numbers.take(3 * numbers.number()),
  };
}
