// Cuts of the live page; see app/live/messages.hpp. SI units.
import type { Vector } from '../../vector.ts';

export type CutTool =
  | { kind: 'region'; region: number; margin: number; keepsMargin: boolean } // a region with a margin [m], which is kept everywhere
  | { kind: 'half-space'; point: Vector; normal: Vector } // all to which the normal points
  | { kind: 'blade'; corners: [Vector, Vector, Vector, Vector]; thickness: number }; // all that a straight blade touches [m]

export interface CutRequest {
  tool: CutTool;
  takesLoose: boolean; // pieces that nothing holds go as well
}

/** What a cut has done, and what is left of the body. */
export interface CutAnswer {
  volume: number; // that it has taken [m^3]
  woundArea: number; // of all cuts [m^2]
  margin: number; // left around the lesions that it took; NaN if there are none [m]
  numLoose: number; // pieces that went because nothing holds them
  numPieces: number; // that are left
  seconds: { find: number; check: number; springs: number; all: number };
  gone: Int32Array; // tetrahedra of the whole body that are gone by now
  triangles: Int32Array; // (T,3) the boundary now
  constrained: Uint8Array; // (T)
  wound: Uint8Array; // (T) 1 of those that cuts have made, which come last
}
