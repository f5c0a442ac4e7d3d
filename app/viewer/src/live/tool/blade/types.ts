// Cuts of the live page; see app/live/messages.hpp. SI units.
import type { Vector } from '../../vector.ts';

export type CutTool =
  | { kind: 'region'; region: number; margin: number; keepsMargin: boolean; opens: boolean } // a region with a margin [m], which is kept everywhere; out through the capsule, so that no cavity stays closed
  | { kind: 'half-space'; point: Vector; normal: Vector } // all to which the normal points
  | { kind: 'blade'; corners: [Vector, Vector, Vector, Vector]; thickness: number }; // all that a straight blade touches [m]; without thickness it parts

export interface CutRequest {
  tool: CutTool;
  takesLoose: boolean; // pieces that nothing holds go as well
}

/** Distances of a wound from the blade [m]. */
export interface OffBlade {
  mean: number; // over its area
  worst: number;
}

/** What blades without thickness have made of a body by now. */
export interface PartedNodes {
  nodes: Int32Array; // (P) that are new or in other places, ascending: new ones are numbered behind the others
  places: Float64Array; // (P,3) at rest [m]
  parents: Int32Array; // (P) the node before all cuts that each is, or was parted from
  tetrahedra: Int32Array; // (Q,5) those that have other nodes: number, and nodes
}

/** What a cut has done, and what is left of the body. */
export interface CutAnswer {
  volume: number; // that it has taken [m^3]
  wayVolume: number; // of the way to the capsule among it [m^3]
  woundArea: number; // of all cuts [m^2]
  margin: number; // left around the lesions that it took; NaN if there are none [m]
  closed: { volume: number; depth: number }; // cavities that no way leads to [m^3], and their depth below the capsule [m]
  jagged: OffBlade; // of what a blade has parted, before nodes went to the blade
  snapped: OffBlade; // and after
  numLoose: number; // pieces that went because nothing holds them
  numPieces: number; // that are left
  seconds: { find: number; check: number; springs: number; all: number };
  gone: Int32Array; // tetrahedra of the whole body that are gone by now
  parted: PartedNodes;
  triangles: Int32Array; // (T,3) the boundary now
  constrained: Uint8Array; // (T)
  wound: Uint8Array; // (T) 1 of those that cuts have made, which come last
}
