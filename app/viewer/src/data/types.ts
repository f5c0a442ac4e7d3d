// What the page knows of a result file. Fields are read when they are shown.
import type { Conditions, Foundation } from '../picture/facet_conditions.ts';
import type { Reach } from '../picture/section.ts';
import type { Surfaces } from './surface.ts';
import type { CarriedVessels } from './vessels.ts';

/** Numbers of /comparisons/<model>; NaN where the file has none. */
export interface Comparison {
  reference: string;
  relativeL2: number;
  stiffness: number; // at the tool, over that of the reference, minus 1
  maxError: number; // m
  energyError: number;
  reactionError: number;
  motionError: number;
  motionLag: number; // s
  motionReference: string;
}

export interface Model {
  name: string;
  summary: string;
  source: string;
  status: string;
  message: string;
  solveSeconds: number;
  moves: boolean; // there are frames
  numPoints: number; // of the path of loads to which it came; 0 without a path
  comparison: Comparison | null; // null for the reference
}

/** A region inside the body. */
export interface Lesion {
  name: string;
  region: number; // its number
  volume: number; // m^3
  node: number; // of it, the nearest to its centre
  reach: Reach; // from that node
}

/** What the load case prescribes on the surface, and what it calls the places. */
export interface NamedConditions extends Conditions {
  name: Int32Array; // (T) index into names: of the constraint, or of the patch
  names: string[];
  nodeFactor: Float64Array | null; // (N) what a prescribed displacement is multiplied by at each node; null where all is as it says
  acceleration: number[]; // (3) m/s^2
}

/** The named parts of the surface. */
export interface Patches {
  names: string[]; // in alphabetical order
  patch: Int32Array; // (T) index into names
  confidence: number; // 0 to 1, of the orientation in which they were found; NaN where the file says none
}

/** Where displacement is prescribed that is not 0, or what presses to a depth. */
export interface MovingPlace {
  name: string;
  constraint: number; // index of its reaction
  way: number[]; // (3) m, under the whole load: mean over its facets, before any factor of a node
}

export interface Result {
  file: string;
  body: string;
  loadCase: string;
  title: string;
  reference: string;
  referenceUncertainty: number; // NaN if nobody looked
  motionReference: string; // the model that motion is measured by; empty without motion
  models: Model[];
  points: Float32Array; // (N,3) m
  surfaces: Surfaces;
  tetrahedra: Int32Array; // (M,4)
  lesions: Lesion[]; // all regions but the first
  isOfImage: boolean; // the body was made of a segmentation
  isAnatomical: boolean; // x to the left, y to the back, z to the head of a patient (LPS)
  conditions: NamedConditions;
  patches: Patches;
  capsule: Capsule | null;
  vessels: CarriedVessels | null;
  tissue: Float32Array; // (N) place of each node in the colours of tissues, 0 to 1
  modulus: Float32Array | null; // (N) Young's modulus at each node [Pa]; null without a map of stiffness
  loads: number[]; // parts of the load at which solutions are kept, ascending to 1; empty in the small regime
  numConstraints: number;
  places: MovingPlace[];
  frameTimes: number[]; // s; empty if nothing moves
  probes: string[];
}

export type Frame = number | null;

/** Which field: of a frame of the motion; else of a point of the path of loads; of the static answer if both are null. */
export interface Moment {
  frame: Frame;
  point: number | null;
}

/** What a moment is one of. */
export type Course = 'load' | 'motion' | 'path';
export const courseOf = ({ frame, point }: Moment): Course => (frame !== null ? 'motion' : point !== null ? 'path' : 'load');

export interface Field {
  displacement: Float32Array; // (N,3) m
  error: Float32Array | null; // (N,3) m; null for what it is measured by, and where nobody compared
  strain: Float32Array | null; // (N) largest principal Green strain; null if nobody asked for it
}

/** The largest finite values over all frames, or over the static answer and its path [m, m, 1]; error is 0 where there is none. */
export interface Largest {
  displacement: number;
  error: number;
  strain: number; // 0 if nobody asked for it
}

/** Of one model at one node [m]. */
export interface NodeValues {
  model: string;
  displacement: number[];
  error: number[] | null;
}

/** Motion of a probe: u along the way that the reference had gone at the start. */
export interface ProbeMotion {
  model: string;
  time: Float64Array; // s
  along: Float64Array; // m
}

/** How far a model is from the reference at a point of the path; NaN where there is nothing to compare. */
export interface PointErrors {
  model: string;
  relativeL2: number;
  stiffness: number; // at the tool
  maxError: number; // m
  energyError: number;
  reactionError: number;
}

/** Force on the body along the way of a place, at the points of the path. */
export interface ForceCurve {
  model: string;
  force: number[]; // N; fewer than there are points where the way ended early
}

export interface ForcePlot {
  place: string;
  way: number; // m, under the whole load
  curves: ForceCurve[];
  uncertain: number[]; // N, either side of the reference's force at each point; empty if nobody looked
  relative: number; // the same as a part of the reactions of all places; NaN if nobody looked
  observedAt: number; // part of the load at which that was observed
}

/** A membrane on the surface. */
export interface Capsule {
  thickness: number; // m
  youngModulus: number; // Pa
  covered: Uint8Array; // (T) 1 where it is: everywhere but on what cuts have opened
}

/** Vessels that are thinner than the tetrahedra: tubes along lines. */
export interface Vessels {
  points: Float64Array; // (V,3) of the axes, m
  radius: Float64Array; // (V) outer, m
  segments: Int32Array; // (W,2) points that a straight tube joins
  wallRatio: number; // thickness of walls over the radius
  wallModulus: number; // Pa
}

/** What of the file can be set in motion. */
export interface SoftBody {
  points: Float64Array; // (N,3) m
  tetrahedra: Int32Array; // (M,4)
  region: Int32Array; // (M) index into the three that follow
  density: Float64Array; // (R) kg/m^3
  youngModulus: Float64Array; // (R) Pa
  poissonRatio: Float64Array; // (R)
  triangles: Int32Array; // (T,3) boundary, right-handed seen from outside
  constrained: Uint8Array; // (T) 1 where the load case prescribes no displacement in all three components
  modulusFactor: Float64Array; // (M) moduli of a tetrahedron over those of its region; empty without a map of stiffness
  capsule: Capsule | null;
  vessels: Vessels | null;
  foundation: Foundation | null; // below facets that are not constrained, ascending
}

/** Something is wrong with a file; the message is for the reader of the page. */
export class Fault extends Error {}
