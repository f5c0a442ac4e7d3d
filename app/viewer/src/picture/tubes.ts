// Tubes with round ends along straight segments, and where a plane cuts them. Knows no three.js.
import { beyond, type Cut } from './section.ts';

/** Both ends of each segment: x, y, z and the radius there. [m] */
export interface Tubes {
  begin: Float32Array; // (W,4)
  end: Float32Array; // (W,4)
}

/** The surface of all tubes: a ball that is parted at its equator, with one half at each end. */
export interface TubeShape {
  outwards: Float32Array; // (K,3) normals: across, across, and along the segment
  along: Float32Array; // (K) 0 at the begin, 1 at the end
  triangles: Uint16Array; // right-handed seen from outside
}

/** @param around  corners of a tube @param steps  from its side to its tip */
export function tubeShape(around: number, steps: number): TubeShape {
  const angles = Array.from({ length: steps + 1 }, (_, i) => (0.5 * Math.PI * i) / steps);
  const rings = [...[...angles].reverse().map((a) => [-a, 0] as const), ...angles.map((a) => [a, 1] as const)];
  const corners = rings.flatMap(([latitude]) => Array.from({ length: around }, (_, k) => {
    const longitude = (2 * Math.PI * k) / around;
    return [Math.cos(latitude) * Math.cos(longitude), Math.cos(latitude) * Math.sin(longitude), Math.sin(latitude)];
  }));
  const triangles = rings.slice(1).flatMap((_, ring) => Array.from({ length: around }, (_, k) => {
    const [a, b] = [ring * around + k, ring * around + ((k + 1) % around)];
    return [a, b, a + around, b, b + around, a + around];
  })).flat();
  return {
    outwards: Float32Array.from(corners.flat()),
    along: Float32Array.from(rings.flatMap(([, part]) => Array<number>(around).fill(part))),
    triangles: Uint16Array.from(triangles),
  };
}

/** @param places (V,3) where points are drawn @param radius (V) @param segments (W,2) @param into  is changed */
export function placeTubes(places: Float32Array, radius: ArrayLike<number>, segments: Int32Array, { begin, end }: Tubes): void {
  for (let s = 0; s < segments.length / 2; s++)
    for (const [ends, point] of [[begin, segments[2 * s]!], [end, segments[2 * s + 1]!]] as const) {
      for (let i = 0; i < 3; i++) ends[4 * s + i] = places[3 * point + i]!;
      ends[4 * s + 3] = radius[point]!;
    }
}

type Vector = [number, number, number];
const cross = (a: Vector, b: Vector): Vector => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a: Vector): Vector => {
  const length = Math.hypot(...a) || 1;
  return [a[0] / length, a[1] / length, a[2] / length];
};

/** Puts the corners of one tube where the shader of picture/vessels.ts places them. @param corners (K,3) is changed */
function placeCorners({ begin, end }: Tubes, segment: number, { outwards, along }: TubeShape, corners: Float64Array): void {
  const [a, b] = [begin.subarray(4 * segment, 4 * segment + 4), end.subarray(4 * segment, 4 * segment + 4)];
  const axis = unit([b[0]! - a[0]!, b[1]! - a[1]!, b[2]! - a[2]!]);
  const side = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
  const other = cross(axis, side);
  for (let k = 0; k < along.length; k++) {
    const part = along[k]!;
    const radius = a[3]! + part * (b[3]! - a[3]!);
    for (let i = 0; i < 3; i++) {
      const normal = outwards[3 * k]! * side[i]! + outwards[3 * k + 1]! * other[i]! + outwards[3 * k + 2]! * axis[i]!;
      corners[3 * k + i] = a[i]! + part * (b[i]! - a[i]!) + radius * normal;
    }
  }
}

/** Where the edges of a tube pass a plane, once each. @param corners (K,3) */
function crossings(cut: Cut, corners: Float64Array, { triangles }: TubeShape): Vector[] {
  const found: Vector[] = [];
  const height = (corner: number) => beyond(cut, corners[3 * corner + cut.axis]!);
  for (let i = 0; i < triangles.length; i++) {
    const [a, b] = [triangles[i]!, triangles[i % 3 === 2 ? i - 2 : i + 1]!];
    const above = height(a);
    if (!(above > 0)) continue;
    const below = height(b);
    if (below > 0) continue; // each edge is met from both sides, and once this way
    const part = above / (above - below);
    const at = (k: number) => corners[3 * a + k]! + part * (corners[3 * b + k]! - corners[3 * a + k]!);
    found.push([at(0), at(1), at(2)]);
  }
  return found;
}

/** What a plane cuts out of tubes: a convex polygon of each, as triangles. @return (K,3,3) m */
export function tubeSections(cut: Cut, tubes: Tubes, shape: TubeShape): Float32Array {
  const found: number[] = [];
  const corners = new Float64Array(shape.outwards.length);
  const [right, up] = [(cut.axis + 1) % 3, (cut.axis + 2) % 3] as [0 | 1 | 2, 0 | 1 | 2];
  for (let s = 0; s < tubes.begin.length / 4; s++) {
    const reaches = (ends: Float32Array, sign: number) => sign * beyond(cut, ends[4 * s + cut.axis]!) < ends[4 * s + 3]!;
    if ([1, -1].some((sign) => !reaches(tubes.begin, sign) && !reaches(tubes.end, sign))) continue;
    placeCorners(tubes, s, shape, corners);
    const polygon = crossings(cut, corners, shape);
    if (polygon.length < 3) continue;
    const middle = [0, 1, 2].map((i) => polygon.reduce((sum, place) => sum + place[i]!, 0) / polygon.length) as Vector;
    const angle = (place: Vector) => Math.atan2(place[up] - middle[up], place[right] - middle[right]);
    polygon.sort((a, b) => angle(a) - angle(b));
    polygon.forEach((place, i) => found.push(...middle, ...place, ...polygon[(i + 1) % polygon.length]!));
  }
  return Float32Array.from(found);
}
