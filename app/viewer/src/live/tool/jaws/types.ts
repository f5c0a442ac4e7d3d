// A grasp of the live page; see app/live/messages.hpp. SI units.
import type { Vector } from '../../vector.ts';

/** The tool: two balls on both sides of an edge, which close against each other and are led together. */
export interface GraspTool {
  kind: 'grasp';
  place: Vector; // of the surface where it was grasped, as it was then [m]
  inwards: Vector; // from there to the other jaw
  target: Vector; // where the place is led to [m]
  radius: number; // of each ball [m]
  depth: number; // by which each closes [m]
}

/** What it does. */
export interface GraspFrame {
  depth: number; // by which each jaw has closed since both just touched [m]
  closing: number; // force of each along the axis, the mean of both [N]
  other: Vector; // centre of the other jaw [m]
  otherForce: Vector; // of the body on it [N]
}
