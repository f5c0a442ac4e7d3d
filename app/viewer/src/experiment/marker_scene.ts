// What an experiment adds to the picture of a body: measured markers, the places where a model has them, lines between the two, and the
// edges of the surface.
import * as three from 'three';
import type { Surface } from '../data/surface.ts';

/** Colours for CSS, which differ in the dark. */
export interface MarkerColours {
  measured: string;
  driving: string;
  computed: string;
  edges: string;
}

/** Places of markers; those that are no number are not drawn. [m] */
export interface MarkersShown {
  compared: Float32Array; // (A,3) measured
  driving: Float32Array; // (B,3) measured
  computed: Float32Array; // (C,3)
  from: Float32Array; // (C,3) where the line to each computed one begins
  marked: readonly number[] | null; // a place
}

export interface MarkerScene {
  object: three.Object3D;
  radius: number; // of a measured marker [m]
  show(markers: MarkersShown): void;
  /** @param places  (N,3) of the nodes, as they are drawn [m] @param isShown  whether edges are */
  showEdges(places: Float32Array, isShown: boolean): void;
  colour(colours: MarkerColours): void;
  free(): void;
}

/** Many of one shape, for each a matrix. */
function manyOf(geometry: three.BufferGeometry, material: three.Material, count: number): three.InstancedMesh {
  const mesh = new three.InstancedMesh(geometry, material, Math.max(count, 1));
  mesh.frustumCulled = false;
  mesh.count = 0;
  return mesh;
}

const isPlace = (places: Float32Array, i: number) => [0, 1, 2].every((axis) => Number.isFinite(places[3 * i + axis]));

function place(mesh: three.InstancedMesh, places: Float32Array): void {
  const matrix = new three.Matrix4();
  mesh.count = 0;
  for (let i = 0; i < places.length / 3; i++)
    if (isPlace(places, i)) mesh.setMatrixAt(mesh.count++, matrix.makeTranslation(places[3 * i]!, places[3 * i + 1]!, places[3 * i + 2]!));
  mesh.instanceMatrix.needsUpdate = true;
}

const up = new three.Vector3(0, 1, 0);

/** Cylinders of length 1 along y become lines. */
function connect(mesh: three.InstancedMesh, from: Float32Array, to: Float32Array): void {
  const matrix = new three.Matrix4();
  const turn = new three.Quaternion();
  const [start, along] = [new three.Vector3(), new three.Vector3()];
  mesh.count = 0;
  for (let i = 0; i < to.length / 3; i++) {
    if (!isPlace(from, i) || !isPlace(to, i)) continue;
    start.fromArray(from, 3 * i);
    along.fromArray(to, 3 * i).sub(start);
    const length = along.length();
    if (length === 0) continue;
    turn.setFromUnitVectors(up, along.divideScalar(length));
    mesh.setMatrixAt(mesh.count++, matrix.compose(start, turn, new three.Vector3(1, length, 1)));
  }
  mesh.instanceMatrix.needsUpdate = true;
}

/** Of triangles each edge once: pairs of indices into the nodes of the surface. */
function edgesOf({ triangles }: Surface): number[] {
  const edges = new Map<string, [number, number]>();
  for (let t = 0; t < triangles.length; t += 3)
    for (const [a, b] of [[0, 1], [1, 2], [2, 0]] as const) {
      const [i, j] = [triangles[t + a]!, triangles[t + b]!];
      edges.set(i < j ? `${i},${j}` : `${j},${i}`, [i, j]);
    }
  return [...edges.values()].flat();
}

/** Many markers are drawn small, so that they do not hide each other. @param size  of the body [m] */
const radiusOf = (size: number, numMarkers: number) => size * Math.min(0.022, 0.06 / Math.cbrt(numMarkers));

/** @param size  of the body [m] */
export function createMarkerScene(surface: Surface, numMarkers: number, size: number): MarkerScene {
  const radius = radiusOf(size, numMarkers);
  const materials = {
    measured: new three.MeshLambertMaterial(),
    driving: new three.MeshLambertMaterial(),
    computed: new three.MeshLambertMaterial(),
    line: new three.MeshBasicMaterial({ toneMapped: false }),
    edges: new three.LineBasicMaterial({ transparent: true, opacity: 0.25 }),
    halo: new three.MeshBasicMaterial({ side: three.BackSide }),
  };
  const bead = new three.SphereGeometry(radius, 20, 14);
  const small = new three.SphereGeometry(0.6 * radius, 16, 12);
  const rod = new three.CylinderGeometry(0.22 * radius, 0.22 * radius, 1, 8).translate(0, 0.5, 0);
  const compared = manyOf(bead, materials.measured, numMarkers);
  const driving = manyOf(bead, materials.driving, numMarkers);
  const computed = manyOf(small, materials.computed, numMarkers);
  const lines = manyOf(rod, materials.line, numMarkers);
  const halo = new three.Mesh(new three.SphereGeometry(1.55 * radius, 24, 16), materials.halo);
  const wires = new three.BufferGeometry();
  wires.setAttribute('position', new three.BufferAttribute(new Float32Array(3 * surface.nodes.length), 3));
  wires.setIndex(edgesOf(surface));
  const edges = new three.LineSegments(wires, materials.edges);
  edges.frustumCulled = false;
  edges.renderOrder = 3; // after the depth of the skin: those behind the body are not drawn
  const object = new three.Group();
  object.add(compared, driving, computed, lines, halo, edges);

  return {
    object,
    radius,
    show(markers) {
      place(compared, markers.compared);
      place(driving, markers.driving);
      place(computed, markers.computed);
      connect(lines, markers.from, markers.computed);
      halo.visible = markers.marked !== null;
      if (markers.marked) halo.position.fromArray(markers.marked);
    },
    showEdges(places, isShown) {
      edges.visible = isShown;
      surface.nodes.forEach((node, vertex) => wires.getAttribute('position').setXYZ(vertex, places[3 * node]!, places[3 * node + 1]!, places[3 * node + 2]!));
      wires.getAttribute('position').needsUpdate = true;
    },
    colour(colours) {
      materials.measured.color.set(colours.measured);
      materials.driving.color.set(colours.driving);
      materials.computed.color.set(colours.computed);
      materials.line.color.set(colours.computed);
      materials.edges.color.set(colours.edges);
      materials.halo.color.set(colours.edges);
    },
    free() {
      for (const mesh of [compared, driving, computed, lines]) mesh.dispose();
      for (const geometry of [bead, small, rod, halo.geometry, wires]) geometry.dispose();
      for (const material of Object.values(materials)) material.dispose();
    },
  };
}
