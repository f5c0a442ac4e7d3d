// Places that ride on a mesh: each on the tetrahedron that holds it at rest, by its barycentric weights there.

/** Of each place: four nodes, and their weights, which sum to 1. */
export interface Carriers {
  nodes: Int32Array; // (P,4)
  weights: Float64Array; // (P,4)
}

type Vector = readonly [number, number, number];
const at = (values: ArrayLike<number>, row: number): Vector => [values[3 * row]!, values[3 * row + 1]!, values[3 * row + 2]!];
const between = (a: Vector, b: Vector): Vector => [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
const dot = (a: Vector, b: Vector) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const determinant = (a: Vector, b: Vector, c: Vector) =>
  a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);

const rounding = 1e-9; // of weights, and of lengths as a part of the mesh

/** Barycentric weights of a place in a tetrahedron; one is below 0 outside. */
function weightsIn(place: Vector, [a, b, c, d]: readonly [Vector, Vector, Vector, Vector]): number[] {
  const [u, v, w, p] = [between(a, b), between(a, c), between(a, d), between(a, place)];
  const whole = determinant(u, v, w);
  const others = [determinant(p, v, w) / whole, determinant(u, p, w) / whole, determinant(u, v, p) / whole];
  return [1 - others[0]! - others[1]! - others[2]!, ...others];
}

/** Weights of the corners at the point of a triangle that is nearest to a place. (Ericson 2005, Real-Time Collision Detection, 5.1.5) */
function nearestWeights(place: Vector, a: Vector, b: Vector, c: Vector): [number, number, number] {
  const [u, v] = [between(a, b), between(a, c)];
  const of = (corner: Vector) => [dot(u, between(corner, place)), dot(v, between(corner, place))] as const;
  const [[ua, va], [ub, vb], [uc, vc]] = [of(a), of(b), of(c)];
  if (ua <= 0 && va <= 0) return [1, 0, 0];
  if (ub >= 0 && vb <= ub) return [0, 1, 0];
  if (vc >= 0 && uc <= vc) return [0, 0, 1];
  const [ofC, ofB, ofA] = [ua * vb - ub * va, uc * va - ua * vc, ub * vc - uc * vb]; // areas across from the corners
  if (ofC <= 0 && ua >= 0 && ub <= 0) return [ub / (ub - ua), ua / (ua - ub), 0];
  if (ofB <= 0 && va >= 0 && vc <= 0) return [vc / (vc - va), 0, va / (va - vc)];
  if (ofA <= 0 && vb >= ub && uc >= vc) {
    const part = (vb - ub) / (vb - ub + (uc - vc));
    return [0, 1 - part, part];
  }
  const sum = ofA + ofB + ofC;
  return [ofA / sum, ofB / sum, ofC / sum];
}

/** Carriers of places in tetrahedra, and which places are in one; those of the others say nothing. */
export function holdersOf(places: ArrayLike<number>, points: ArrayLike<number>, tetrahedra: ArrayLike<number>): Carriers & { isHeld: Uint8Array } {
  const numPlaces = places.length / 3;
  const nodes = new Int32Array(4 * numPlaces);
  const weights = new Float64Array(4 * numPlaces);
  const best = new Float64Array(numPlaces).fill(-Infinity); // smallest weight in the tetrahedron that was found
  const order = Array.from({ length: numPlaces }, (_, p) => p).sort((p, q) => places[3 * p]! - places[3 * q]!);
  const alongX = Float64Array.from(order, (p) => places[3 * p]!);
  let size = 0;
  for (let i = 0; i < points.length; i++) size = Math.max(size, Math.abs(points[i]!));
  const margin = rounding * size;
  const [low, high] = [new Float64Array(3), new Float64Array(3)]; // bounds of a tetrahedron

  function firstFrom(x: number): number {
    let [begin, end] = [0, numPlaces];
    while (begin < end) {
      const middle = (begin + end) >> 1;
      if (alongX[middle]! < x) begin = middle + 1;
      else end = middle;
    }
    return begin;
  }

  for (let t = 0; t < tetrahedra.length / 4; t++) {
    low.fill(Infinity);
    high.fill(-Infinity);
    for (let corner = 4 * t; corner < 4 * t + 4; corner++)
      for (let i = 0; i < 3; i++) {
        const x = points[3 * tetrahedra[corner]! + i]!;
        low[i] = Math.min(low[i]!, x - margin);
        high[i] = Math.max(high[i]!, x + margin);
      }
    for (let k = firstFrom(low[0]!); k < numPlaces && alongX[k]! <= high[0]!; k++) {
      const p = order[k]!;
      if (places[3 * p + 1]! < low[1]! || places[3 * p + 1]! > high[1]! || places[3 * p + 2]! < low[2]! || places[3 * p + 2]! > high[2]!) continue;
      const corners = [0, 1, 2, 3].map((i) => tetrahedra[4 * t + i]!);
      const found = weightsIn(at(places, p), corners.map((node) => at(points, node)) as unknown as [Vector, Vector, Vector, Vector]);
      const least = Math.min(...found);
      if (!(least > best[p]!)) continue;
      best[p] = least;
      nodes.set(corners, 4 * p);
      weights.set(found, 4 * p);
    }
  }
  return { nodes, weights, isHeld: Uint8Array.from(best, (least) => Number(least >= -rounding)) };
}

/**
 * @param places      (P,3) m
 * @param points      (N,3) of the nodes at rest [m]
 * @param tetrahedra  (M,4)
 * @param triangles   (T,3) of the boundary: a place outside rides on the point of it that is nearest
 */
export function carriersOf(places: ArrayLike<number>, points: ArrayLike<number>, tetrahedra: ArrayLike<number>, triangles: ArrayLike<number>): Carriers {
  const { nodes, weights, isHeld } = holdersOf(places, points, tetrahedra);
  isHeld.forEach((held, p) => {
    if (held) return;
    const place = at(places, p);
    let nearest = Infinity;
    for (let t = 0; t < triangles.length / 3; t++) {
      const corners = [0, 1, 2].map((i) => triangles[3 * t + i]!);
      const [a, b, c] = corners.map((node) => at(points, node)) as [Vector, Vector, Vector];
      const found = nearestWeights(place, a, b, c);
      const way = between(place, [0, 1, 2].map((i) => found[0] * a[i]! + found[1] * b[i]! + found[2] * c[i]!) as unknown as Vector);
      if (!(dot(way, way) < nearest)) continue;
      nearest = dot(way, way);
      nodes.set([...corners, corners[0]!], 4 * p);
      weights.set([...found, 0], 4 * p);
    }
  });
  return { nodes, weights };
}

/**
 * Where places are when the nodes have moved. A node whose displacement is no number stays at rest.
 * @param places        (P,3) at rest [m]
 * @param displacement  (N,3) m
 * @param factor        that displacements are drawn by
 * @return (P,3) m
 */
export function carried(places: ArrayLike<number>, { nodes, weights }: Carriers, displacement: ArrayLike<number>, factor: number): Float32Array {
  const moved = new Float32Array(places.length);
  for (let p = 0; p < places.length / 3; p++)
    for (let i = 0; i < 3; i++) {
      let u = 0;
      for (let k = 4 * p; k < 4 * p + 4; k++) {
        const own = displacement[3 * nodes[k]! + i]!;
        if (Number.isFinite(own)) u += weights[k]! * own;
      }
      moved[3 * p + i] = places[3 * p + i]! + factor * u;
    }
  return moved;
}
