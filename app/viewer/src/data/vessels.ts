// Vessels that are lines, as a picture needs them.
import { carriersOf, holdersOf, type Carriers } from './carriers.ts';
import type { SoftBody, Vessels } from './types.ts';

/** Vessels whose points ride on a mesh. */
export interface CarriedVessels extends Vessels {
  carriers: Carriers;
}

/** Of all segments together [m]. */
export function lengthOf({ points, segments }: Pick<Vessels, 'points' | 'segments'>): number {
  let length = 0;
  for (let s = 0; s < segments.length; s += 2) {
    const along = (i: number) => points[3 * segments[s + 1]! + i]! - points[3 * segments[s]! + i]!;
    length += Math.hypot(along(0), along(1), along(2));
  }
  return length;
}

const step = 1e-3; // between places of a segment that are looked at [m]

/**
 * What a cut has left of vessels: what was in tetrahedra that are gone is gone too.
 * @param gone  (G,4) nodes of those
 * @param left  the body as it is, with the nodes of the whole one
 */
export function vesselsLeft(vessels: CarriedVessels, gone: Int32Array, left: Pick<SoftBody, 'points' | 'tetrahedra' | 'triangles'>): CarriedVessels {
  const { points, radius, segments } = vessels;
  const [begins, places]: [number[], number[]] = [[], []]; // of the places of each segment
  for (let s = 0; s < segments.length; s += 2) {
    const [a, b] = [segments[s]!, segments[s + 1]!];
    const count = 1 + Math.ceil(lengthOf({ points, segments: segments.subarray(s, s + 2) }) / step);
    begins.push(places.length / 3);
    for (let k = 0; k <= count; k++)
      for (let i = 0; i < 3; i++) places.push(points[3 * a + i]! + (k / count) * (points[3 * b + i]! - points[3 * a + i]!));
  }
  begins.push(places.length / 3);
  const { isHeld: isGone } = holdersOf(places, left.points, gone);
  const pieces: { places: number[]; radius: number[] } = { places: [], radius: [] };
  for (let s = 0; s < segments.length / 2; s++) {
    const [first, behind] = [begins[s]!, begins[s + 1]!];
    const radiusAt = (p: number) => radius[segments[2 * s]!]! + ((p - first) / (behind - 1 - first)) * (radius[segments[2 * s + 1]!]! - radius[segments[2 * s]!]!);
    for (let from = first; from < behind; ) {
      let to = from;
      while (to < behind && !isGone[to]) to++;
      if (to - from > 1)
        for (const p of [from, to - 1]) {
          pieces.places.push(...places.slice(3 * p, 3 * p + 3));
          pieces.radius.push(radiusAt(p));
        }
      from = to + 1;
    }
  }
  return {
    ...vessels,
    points: Float64Array.from(pieces.places),
    radius: Float64Array.from(pieces.radius),
    segments: Int32Array.from(pieces.radius.keys()),
    carriers: carriersOf(pieces.places, left.points, left.tetrahedra, left.triangles),
  };
}
