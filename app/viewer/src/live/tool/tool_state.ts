// What the tool of the reader does: which one, taken where, moved how far, pushed in how deep. Values in, values out.
import type { NeedleValues } from './needle/types.ts';
import type { Tool } from '../types.ts';
import { length, plus, type Vector } from '../vector.ts';

export type Holding = Exclude<Tool['kind'], 'none'>;
/** A blade takes hold of nothing: it is led across the picture, and then it has cut. */
export type Kind = Tool['kind'] | 'blade';
/** Whether a tool touches or grasps. */
export const isHolding = (kind: Kind): kind is Holding => kind !== 'none' && kind !== 'blade';

/** A place of the surface that is touched or grasped. */
export interface Grasp {
  point: Vector; // [m]
  inwards: Vector; // normal
  node: number;
  moved: Vector; // since it was taken, across the screen [m]
  depth: number; // now, along the normal [m]; below 0 it is outside
  goal: number; // depth that is asked for [m]
  needle: { target: Vector; values: NeedleValues } | null; // of a needle
}

export interface ToolState {
  kind: Kind;
  radius: Record<Holding, number>; // [m]
  start: Record<Holding, number>; // depth that a tool goes to when it is set down [m]
  grasp: Grasp | null;
}

export const deepest = 0.03; // [m]
/** How deep a needle may be asked to go before it has a target [m]. */
export const deepestNeedle = 0.1;
const pushing = 0.05; // speed of a tool along the normal [m/s]
const driving = 0.02; // speed of a needle [m/s]

/** Radius of the edges of a plate over half its side: that of app/live/scene.hpp. */
export const edgeOfPlate = 0.1;

/** At first a finger, 24 mm across, jaws of 16 mm, and a plate of 24 mm. */
export const atRest: ToolState = {
  kind: 'probe',
  radius: { probe: 0.012, plate: 0.012, grasp: 0.008, pull: 0.015, needle: 0.008 },
  start: { probe: 0.005, plate: 0.004, grasp: 0.004, pull: 0, needle: 0 },
  grasp: null,
};

/** Sets the tool down where it just touches; it then goes to the depth that it starts with. */
/** @param needle  where it goes, of a needle: all the way to its target unless it was to go less deep */
export function take(toolState: ToolState, place: Pick<Grasp, 'point' | 'inwards' | 'node'>, needle: Grasp['needle'] = null): ToolState {
  if (!isHolding(toolState.kind)) return toolState;
  const { point, inwards, node } = place;
  const start = toolState.start[toolState.kind];
  const goal = needle ? Math.min(start > 0 ? start : Infinity, length(plus(needle.target, point, -1))) : start;
  return { ...toolState, grasp: { point, inwards, node, moved: [0, 0, 0], depth: 0, goal, needle } };
}

export const letGo = (toolState: ToolState): ToolState => ({ ...toolState, grasp: null });

export function choose(toolState: ToolState, kind: Kind): ToolState {
  return { ...toolState, kind, grasp: null };
}

export function slide(toolState: ToolState, by: Vector): ToolState {
  return toolState.grasp ? { ...toolState, grasp: { ...toolState.grasp, moved: plus(toolState.grasp.moved, by) } } : toolState;
}

/** How deep it is to be: of what is grasped, else of what will be taken. */
export function goalOf(toolState: ToolState): number {
  return toolState.grasp?.goal ?? (isHolding(toolState.kind) ? toolState.start[toolState.kind] : 0);
}

/** The depths that may be asked for [m]. */
export function depths({ kind, grasp }: ToolState): [number, number] {
  if (kind !== 'needle') return [-deepest, deepest];
  return [grasp ? -deepest : 0, grasp?.needle ? length(plus(grasp.needle.target, grasp.point, -1)) : deepestNeedle];
}

export function pushTo(toolState: ToolState, depth: number): ToolState {
  const [least, most] = depths(toolState);
  const goal = Math.min(Math.max(depth, least), most);
  if (toolState.grasp) return { ...toolState, grasp: { ...toolState.grasp, goal } };
  return !isHolding(toolState.kind) ? toolState : { ...toolState, start: { ...toolState.start, [toolState.kind]: goal } };
}

export function resize(toolState: ToolState, radius: number): ToolState {
  return !isHolding(toolState.kind) ? toolState : { ...toolState, radius: { ...toolState.radius, [toolState.kind]: radius } };
}

/** What is asked for at once is done at the speed of somebody's hand. */
export function goOn(toolState: ToolState, seconds: number): ToolState {
  const { grasp } = toolState;
  if (!grasp || grasp.depth === grasp.goal) return toolState;
  const step = Math.min(Math.abs(grasp.goal - grasp.depth), (toolState.kind === 'needle' ? driving : pushing) * seconds);
  return { ...toolState, grasp: { ...grasp, depth: grasp.depth + Math.sign(grasp.goal - grasp.depth) * step } };
}

export function toolOf({ kind, grasp, radius }: ToolState): Tool {
  if (!isHolding(kind) || !grasp) return { kind: 'none' };
  if (kind === 'needle')
    return grasp.needle ? { kind, entry: grasp.point, depth: grasp.depth, ...grasp.needle } : { kind: 'none' };
  const place = plus(grasp.point, grasp.moved);
  // The place of a probe is its centre.
  if (kind === 'probe') return { kind, radius: radius.probe, target: plus(place, grasp.inwards, grasp.depth - radius.probe) };
  if (kind === 'plate') return { kind, radius: radius.plate, inwards: grasp.inwards, target: plus(place, grasp.inwards, grasp.depth - edgeOfPlate * radius.plate) };
  if (kind === 'grasp') return { kind, radius: radius.grasp, place: grasp.point, inwards: grasp.inwards, target: place, depth: grasp.depth };
  return { kind, radius: radius.pull, node: grasp.node, target: plus(place, grasp.inwards, grasp.depth) };
}
