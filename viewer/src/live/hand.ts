// What the hand of the reader does: which tool, taken where, moved how far, pushed in how deep. Values in, values out.
import type { Tool, Vector } from './types.ts';

export type Kind = Tool['kind'];
export type Holding = Exclude<Kind, 'none'>;

/** A place of the surface that is touched or held. */
export interface Grasp {
  point: Vector; // [m]
  inwards: Vector; // normal
  node: number;
  moved: Vector; // since it was taken, across the screen [m]
  depth: number; // now, along the normal [m]; below 0 it is outside
  goal: number; // depth that is asked for [m]
}

export interface Hand {
  kind: Kind;
  radius: Record<Holding, number>; // [m]
  start: Record<Holding, number>; // depth that a tool goes to when it is set down [m]
  grasp: Grasp | null;
}

export const deepest = 0.03; // [m]
const pushing = 0.05; // speed of a tool along the normal [m/s]

export const atRest: Hand = { kind: 'probe', radius: { probe: 0.01, pull: 0.015 }, start: { probe: 0.005, pull: 0 }, grasp: null };

export const plus = (a: Vector, b: Vector, factor = 1): Vector => [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]];
export const dot = (a: Vector, b: Vector) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a: Vector) => Math.hypot(...a);

/** Sets the tool down where it just touches; it then goes to the depth that it starts with. */
export function take(hand: Hand, place: Pick<Grasp, 'point' | 'inwards' | 'node'>): Hand {
  if (hand.kind === 'none') return hand;
  const { point, inwards, node } = place;
  return { ...hand, grasp: { point, inwards, node, moved: [0, 0, 0], depth: 0, goal: hand.start[hand.kind] } };
}

export const letGo = (hand: Hand): Hand => ({ ...hand, grasp: null });

export function choose(hand: Hand, kind: Kind): Hand {
  return { ...hand, kind, grasp: null };
}

export function slide(hand: Hand, by: Vector): Hand {
  return hand.grasp ? { ...hand, grasp: { ...hand.grasp, moved: plus(hand.grasp.moved, by) } } : hand;
}

/** How deep it is to be: of what is held, else of what will be taken. */
export function goalOf(hand: Hand): number {
  return hand.grasp?.goal ?? (hand.kind === 'none' ? 0 : hand.start[hand.kind]);
}

export function pushTo(hand: Hand, depth: number): Hand {
  const goal = Math.min(Math.max(depth, -deepest), deepest);
  if (hand.grasp) return { ...hand, grasp: { ...hand.grasp, goal } };
  return hand.kind === 'none' ? hand : { ...hand, start: { ...hand.start, [hand.kind]: goal } };
}

export function resize(hand: Hand, radius: number): Hand {
  return hand.kind === 'none' ? hand : { ...hand, radius: { ...hand.radius, [hand.kind]: radius } };
}

/** What is asked for at once is done at the speed of a hand. */
export function goOn(hand: Hand, seconds: number): Hand {
  const { grasp } = hand;
  if (!grasp || grasp.depth === grasp.goal) return hand;
  const step = Math.min(Math.abs(grasp.goal - grasp.depth), pushing * seconds);
  return { ...hand, grasp: { ...grasp, depth: grasp.depth + Math.sign(grasp.goal - grasp.depth) * step } };
}

export function toolOf({ kind, grasp, radius }: Hand): Tool {
  if (kind === 'none' || !grasp) return { kind: 'none' };
  const place = plus(grasp.point, grasp.moved);
  // The place of a probe is its centre.
  if (kind === 'probe') return { kind, radius: radius.probe, target: plus(place, grasp.inwards, grasp.depth - radius.probe) };
  return { kind, radius: radius.pull, node: grasp.node, target: plus(place, grasp.inwards, grasp.depth) };
}
