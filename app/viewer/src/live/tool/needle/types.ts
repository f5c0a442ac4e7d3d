// A needle of the live page; see core/tool/needle/needle.hpp and app/live/messages.hpp. SI units.
import type { Vector } from '../../vector.ts';

/** What kind of needle it is, and what it meets. */
export interface NeedleValues {
  diameter: number; // [m]
  spread: number; // radius over which forces are spread [m]
  toughness: number; // of the tissue [J/m^2]
  friction: number; // along the shaft [N/m]
  punctureForce: number; // at which the surface gives way [N]
}

/** The tool: straight from an entry at the surface to a target inside, both as at rest. */
export interface NeedleTool {
  kind: 'needle';
  entry: Vector; // [m]
  target: Vector; // [m]
  depth: number; // of the tip below the entry, as the hand leads it [m]
  values: NeedleValues;
}

/** Where the forces of a needle act. */
export interface NeedleLine {
  entry: Vector; // [m]
  target: Vector; // [m]
  spread: number; // [m]
}

/** What it does. */
export interface NeedleFrame {
  depth: number; // where the hand has led the tip [m]
  tip: number; // how much of the tissue's path is behind the tip, at rest [m]
  force: number; // of the hand, inwards [N]
  tipForce: number; // [N]
  isPunctured: boolean; // whether the surface has given way
  targetMoved: Vector; // displacement of the target [m]
  work: { hand: number; friction: number; tearing: number }; // since it was taken [J]
  line: NeedleLine; // on which its forces act
  forces: Float64Array; // (K,3) on the tissue, at the places of that line (core/tool/needle/needle.hpp) [N]
}
