// What the page knows of a result file. Fields are read when they are shown.
import type { Conditions } from '../picture/facet_conditions.ts';
import type { Reach } from '../picture/section.ts';
import type { Surfaces } from './surface.ts';

/** Numbers of /comparisons/<model>; NaN where the file has none. */
export interface Comparison {
  reference: string;
  relativeL2: number;
  maxError: number; // m
  energyError: number;
  reactionError: number;
  motionError: number;
  motionLag: number; // s
  motionReference: string;
  inBand: boolean | null; // null where there is no band
}

export interface Model {
  name: string;
  summary: string;
  source: string;
  status: string;
  message: string;
  solveSeconds: number;
  moves: boolean; // there are frames
  comparison: Comparison | null; // null for the reference
}

/** A region inside the body. */
export interface Lesion {
  name: string;
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
  isAnatomical: boolean; // x to the left, y to the back, z to the head of a patient (LPS)
  conditions: NamedConditions;
  frameTimes: number[]; // s; empty if nothing moves
  probes: string[];
}

/** Which field: of the static answer, or of a frame of the motion. */
export type Frame = number | null;

export interface Field {
  displacement: Float32Array; // (N,3) m
  error: Float32Array | null; // (N,3) m; null for what it is measured by, and where nobody compared
  strain: Float32Array | null; // (N) largest principal Green strain; null if nobody asked for it
}

/** The largest finite values over the static answer or all frames [m, m, 1]; error is 0 where there is none. */
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
}

/** Something is wrong with a file; the message is for the reader of the page. */
export class Fault extends Error {}
