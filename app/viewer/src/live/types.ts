// What the live page and its engines say to each other. SI units.

import type { SoftBody } from '../data/types.ts';
import type { CutAnswer, CutRequest, PartedNodes } from './tool/blade/types.ts';
import type { GraspFrame, GraspTool } from './tool/jaws/types.ts';
import type { NeedleFrame, NeedleTool } from './tool/needle/types.ts';
import type { Vector } from './vector.ts';

/** All of a result file that moves. */
export interface LiveBody extends SoftBody {
  file: string; // path in the server's list; empty for a file that was dropped
  /** Of a body that has been cut: tetrahedra of the whole one that are gone, what is parted, and (T) which triangles are in the wound. */
  cuts?: { gone: Int32Array; parted: PartedNodes; wound: Uint8Array };
}

export interface LiveSettings {
  springLaw: string; // one of Engine.springLaws, which also names springs that are coupled around nodes
  keepsVolume: boolean; // with the nodal volume term
  youngModulus: number; // of the region with the largest volume [Pa]; the others keep their ratio to it
  poissonRatio: number; // of all regions, in [0, 0.49]; springs alone take no notice
  massDamping: number; // alpha of Rayleigh's damping [1/s], >= 0
  stiffnessDamping: number; // beta [s], >= 0
  timeStep: number; // [s]; 0 takes the longest that the page offers
}

/** What the settings come to. Everything that is said of steps is said of this. */
export interface Chosen {
  timeStep: number; // that steps have [s]
  longestTimeStep: number; // that the page may offer [s]
  criticalTimeStep: number; // predicted, at rest, with the masses of the steps that are taken [s]
  pressedTimeStep: number; // the longest while something is pressed: steps are divided then [s]
  numSprings: number;
  unscaledTimeStep: number; // the longest while masses of stiff parts are as they are [s]
  limit: 'rest' | 'pressed' | 'hand'; // what decides the longest
}

/**
 * What the tool does. A probe is a rigid ball that follows the target as if by a spring, and touches the body; a plate does the same with a
 * square face; a pull takes hold of the surface around a node and draws it to the target. A needle goes straight from an entry to a target
 * inside. A grasp closes two balls on an edge.
 */
export type Tool =
  | { kind: 'none' }
  | { kind: 'probe'; target: Vector; radius: number }
  | PlateTool
  | { kind: 'pull'; target: Vector; node: number; radius: number }
  | NeedleTool
  | GraspTool;

/** A plate, whose sides lie as those of a load case: see core::ToolShape. */
export interface PlateTool {
  kind: 'plate';
  target: Vector; // of the centre of its flat [m]
  inwards: Vector; // its axis
  radius: number; // half a side of the flat [m]
}

export interface LiveFrame {
  time: number; // since the start [s]
  displacement: Float32Array; // (N,3) m
  tool: Vector; // centre of the probe, of the flat of the plate, or of the patch that is pulled, tip of the needle, or centre of the first jaw [m]
  force: Vector; // of the body on the tool [N]
  radius: number; // of a probe or a jaw, or of what a pull holds, or half a side of a plate [m]; 0 of others
  /** Spread of a pull's tractions: a round load (core/load_case.hpp) around a point of the surface at rest [m]; radius 0 where they are even on each facet. */
  disc: { middle: Vector; radius: number };
  /** How far the body gives way, in the mean weighted with what the tool exerts: sum of f_i . u_i / |sum of f_i| over nodal forces, under two jaws over the sum of both sizes [m]; 0 untouched. */
  indentation: number;
  loadedNodes: Int32Array; // (K)
  nodalForces: Float64Array; // (K,3) of the tool on the body [N]
  loadedFacets: Int32Array; // (L) index into the triangles
  tractions: Float64Array; // (L,3) the same as the nodal forces, as the load cases say it: means over the facets [Pa]
  smallestVolume: number; // of a tetrahedron, as a part of its volume at rest; below 0 it is inverted
  largestSpeed: number; // of all nodes, and of the tool [m/s]
  restarts: number; // how often the motion left all bounds and was set back to rest
  stepSeconds: number; // that the engine needed for this frame [s]
  numEvaluations: number; // of all forces: more than steps where some were divided
  needle: NeedleFrame | null; // where the tool is one
  grasp: GraspFrame | null; // the same
}

/** Moves the springs. Answers come in the order of the questions. Faults are sentences. */
export interface Engine {
  readonly name: string;
  /** Springs of which laws it knows. */
  open(body: LiveBody): Promise<{ springLaws: string[] }>;
  /** May be called while it runs: the motion goes on with the new parameters. */
  choose(settings: LiveSettings): Promise<Chosen>;
  move(tool: Tool, numSteps: number): Promise<LiveFrame>;
  /** Takes tetrahedra away, and keeps what there was before. A cut that is refused is a fault, after which all is as before. */
  cut(request: CutRequest): Promise<CutAnswer>;
  /** Back to rest, where it lies without a tool, and whole. */
  reset(): Promise<void>;
  /** Keeps where the body is, how fast, and what the tool does to it, in place of what was kept before. */
  keep(): Promise<void>;
  /** Goes on from what was kept, which may be before a cut. */
  restore(): Promise<void>;
  close(): void;
}

/** Elements that are linear at any depth, or hyperelastic ones, which take ten times as long or more. */
export type Elements = 'linear' | 'hyperelastic';

/** The finite element answer to the same tractions, or to a needle. */
export interface TruthEngine {
  /** @param body  of a file in the server's list; it may have been cut */
  open(body: LiveBody): Promise<void>;
  choose(settings: Pick<LiveSettings, 'youngModulus' | 'poissonRatio'>): Promise<void>;
  /**
   * A question that comes before the answer interrupts it.
   * @return (N,3) displacement [m], and the work of the tractions in it, sum of f_i . u_i over all nodes of the elements [J]; null if it was interrupted
   */
  solve(load: Pick<LiveFrame, 'disc' | 'loadedFacets' | 'tractions'>, elements: Elements): Promise<{ displacement: Float32Array; work: number } | null>;
  /** @return (N,3) displacement [m], and that of the target [m]; null if it was interrupted */
  pierce(needle: Pick<NeedleFrame, 'line' | 'forces'>, elements: Elements): Promise<{ displacement: Float32Array; targetMoved: Vector } | null>;
  /** Nobody waits for the answer to the last question any longer. */
  interrupt(): void;
  close(): void;
}
