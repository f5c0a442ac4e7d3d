// One side of the picture: a body, what is inside, what is prescribed on it, a cut through it, and the marked node.
import * as three from 'three';
import type { Surface, Surfaces } from '../data/surface.ts';
import type { CarriedVessels } from '../data/vessels.ts';
import type { Colouring } from './colour_maps.ts';
import { createConditions, restCentres, type Conditions, type ConditionsInScene, type ConditionsShown } from './conditions.ts';
import { createCutFace } from './cut_face.ts';
import { createFacets } from './facets.ts';
import { displaced, textureCoordinates } from './fields.ts';
import { createMarks, type Marks } from './marks.ts';
import { createMaterials, mapWidth, type BodySkin } from './materials.ts';
import type { MarkedArrow } from './overlay.ts';
import type { Cut, Reach } from './section.ts';
import { createVessels } from './vessels.ts';
import { createWound } from './wound.ts';

export type { Skin } from './materials.ts';

/** What a side shows. */
export interface Look {
  displacement: Float32Array; // (N,3) m
  values: Float32Array; // (N) what is coloured
  end: number; // value at the end of the legend
  quantity: Colouring; // of patches on the outside, and of values inside
  skin: BodySkin;
  exaggeration: number;
  node: number | null; // marked
}

/** What has a name, at which node, and how far it goes from there along the axes [m]. */
export interface NodeLabel {
  name: string;
  node: number;
  reach: Reach;
}

/** A part of the surface with a name, which is written on what is seen of it. */
export interface SurfaceLabel {
  name: string;
  nodes: Int32Array; // (n)
  outwards: Float32Array; // (n,3) normals there at rest
}

/** What a body may have besides its surface. */
export interface BodyParts {
  conditions?: Conditions; // of the facets of the surface
  patches?: { patch: Int32Array; names: readonly string[] }; // named parts: (T) index into the names
  tetrahedra?: Int32Array; // (M,4), which close what is cut open
  labels?: NodeLabel[]; // what has a name inside
  surfaceLabels?: SurfaceLabel[]; // what has a name on the surface
  vessels?: CarriedVessels | null;
  firstOfWound?: number; // triangle of the outside that it and all behind it were cut, and share no vertex with others
  alsoSeen?: Float32Array; // (P,3) places around it that are in sight at first [m]
  isAnatomical?: boolean; // its axes are those of a patient (LPS)
}

export interface Body {
  scene: three.Scene;
  outside: three.Mesh; // for picking
  show(look: Look): void;
  showConditions(shown: ConditionsShown): void;
  showVessels(areShown: boolean): void;
  /** Of what is prescribed, as they are drawn. */
  arrows(): MarkedArrow[];
  cut(cut: Cut | null): void;
  /** The first node that a ray meets; null beside the body. */
  nodeAt(ray: three.Raycaster): number | null;
  /** Where a node is drawn. */
  placeOf(node: number): three.Vector3;
  mark(marks: Marks): void;
  faceLight(camera: three.Camera): void;
  free(): void;
}

function geometryOf(surface: Surface): three.BufferGeometry {
  const geometry = new three.BufferGeometry();
  geometry.setIndex(new three.BufferAttribute(surface.triangles, 1));
  geometry.setAttribute('position', new three.BufferAttribute(new Float32Array(3 * surface.nodes.length), 3));
  geometry.setAttribute('uv', new three.BufferAttribute(new Float32Array(2 * surface.nodes.length), 2));
  return geometry;
}

function update(geometry: three.BufferGeometry, surface: Surface, points: Float32Array, look: Look): void {
  const places = displaced(surface, points, look.displacement, look.exaggeration);
  geometry.getAttribute('position').array.set(places);
  geometry.getAttribute('uv').array.set(textureCoordinates(surface.nodes, look.values, look.end, mapWidth, look.quantity !== 'tissue'));
  geometry.getAttribute('position').needsUpdate = true;
  geometry.getAttribute('uv').needsUpdate = true;
  geometry.computeVertexNormals();
  geometry.computeBoundingSphere();
}

/** The corner of a triangle that is next to where it was hit. */
export function nearestVertex(mesh: three.Mesh, hit: three.Intersection): number {
  const places = mesh.geometry.getAttribute('position') as three.BufferAttribute;
  const distance = (vertex: number) => new three.Vector3().fromBufferAttribute(places, vertex).distanceTo(hit.point);
  return [hit.face!.a, hit.face!.b, hit.face!.c].reduce((best, vertex) => (distance(vertex) < distance(best) ? vertex : best));
}

function createMarker(size: number): three.Mesh {
  const marker = new three.Mesh(new three.SphereGeometry(0.011 * size, 24, 16), new three.MeshBasicMaterial({ color: 0x1c1c1c }));
  marker.add(new three.Mesh(new three.SphereGeometry(0.016 * size, 24, 16), new three.MeshBasicMaterial({ color: 0xffffff, side: three.BackSide })));
  return marker;
}

/** @param size  of the body [m] */
export function createBody(points: Float32Array, surfaces: Surfaces, size: number, parts: BodyParts = {}): Body {
  const materials = createMaterials(parts.patches?.names.length ?? 0);
  const outside: three.Mesh = new three.Mesh(geometryOf(surfaces.outside), materials.skins.solid);
  const wound = createWound(outside.geometry, parts.firstOfWound ?? -1, materials.wound, materials.unseen);
  const front = new three.Mesh(outside.geometry, materials.depth);
  const inside = new three.Mesh(geometryOf(surfaces.inside), materials.skins.solid);
  const face = createCutFace(materials.section, materials.outline, surfaces.inside, parts.tetrahedra ?? new Int32Array());
  const facets = createFacets(outside.geometry, parts.patches?.patch ?? new Int32Array(surfaces.outside.triangles.length / 3),
    Math.max(parts.patches?.names.length ?? 0, 1), materials.skins.solid);
  const marker = createMarker(size);
  inside.renderOrder = 0;
  front.renderOrder = 1;
  outside.renderOrder = facets.mesh.renderOrder = 2;
  marker.renderOrder = 3;
  const conditions: ConditionsInScene | null = parts.conditions
    ? createConditions(outside.geometry, parts.conditions, restCentres(surfaces.outside, points), size) : null;
  const vessels = parts.vessels ? createVessels(parts.vessels) : null;
  const marks = createMarks(size);
  marks.show({ probe: null, grip: null, arrow: null, needle: null });

  const light = new three.DirectionalLight(0xffffff, 2.2);
  const scene = new three.Scene();
  scene.add(new three.HemisphereLight(0xffffff, 0xb8b2aa, 1.7), light, light.target, inside, front, outside, facets.mesh, face.object, marker, marks.object);
  if (conditions) scene.add(conditions.object);
  if (vessels) scene.add(vessels.object);
  if (wound.mesh) scene.add(wound.mesh);

  const hasInside = surfaces.inside.nodes.length > 0;
  let look: Look | null = null;
  let places = points; // of all nodes, as they are drawn
  let cut: Cut | null = null;
  const planes: three.Plane[] = []; // of the cut

  return {
    scene,
    outside,
    show(next) {
      look = next;
      places = displaced({ nodes: Int32Array.from({ length: points.length / 3 }, (_, i) => i) }, points, look.displacement, look.exaggeration);
      materials.use(look.quantity);
      facets.mesh.material = materials.skins[look.skin];
      outside.material = wound.outside(materials.skins[look.skin]);
      facets.mesh.visible = look.quantity === 'patches';
      outside.visible = !facets.mesh.visible; // a ray meets it all the same
      front.visible = look.skin === 'translucent' || look.skin === 'veil';
      inside.visible = hasInside && look.skin === 'translucent';
      update(outside.geometry, surfaces.outside, points, look);
      wound.follow();
      if (facets.mesh.visible) facets.follow();
      if (hasInside) update(inside.geometry, surfaces.inside, points, look);
      face.show(cut, places, look);
      vessels?.follow(look.displacement, look.exaggeration);
      conditions?.follow();
      marker.visible = look.node !== null;
      if (look.node !== null) marker.position.fromArray(places, 3 * look.node);
    },
    showConditions: (shown) => conditions?.show(shown),
    showVessels: (areShown) => vessels?.show(areShown),
    arrows: () => conditions?.arrows() ?? [],
    cut(next) {
      cut = next;
      const sign = cut?.keepsAbove ? 1 : -1;
      planes.splice(0, planes.length, ...(cut ? [new three.Plane(new three.Vector3().setComponent(cut.axis, sign), -sign * cut.place)] : []));
      materials.clip([...planes]);
      conditions?.clip([...planes]);
      vessels?.cut(cut, [...planes]);
      if (look) face.show(cut, places, look);
    },
    nodeAt(ray) {
      const isThere = (hit: three.Intersection) => hit.object === face.mesh || planes.every((plane) => plane.distanceToPoint(hit.point) >= 0);
      const hit = ray.intersectObjects([outside, face.mesh], false).find(isThere);
      if (!hit) return null;
      return hit.object === outside ? surfaces.outside.nodes[nearestVertex(outside, hit)]! : face.nodeOf(nearestVertex(face.mesh, hit));
    },
    placeOf: (node) => new three.Vector3().fromArray(places, 3 * node),
    mark: marks.show,
    faceLight(camera) {
      light.position.copy(camera.position).addScaledVector(camera.up, 0.5 * size);
    },
    free() {
      marks.free();
      conditions?.free();
      vessels?.free();
      face.free();
      facets.free();
      for (const part of [outside, inside, marker, ...marker.children] as three.Mesh[]) part.geometry.dispose();
      for (const part of [marker, ...marker.children] as three.Mesh[]) (part.material as three.Material).dispose();
      materials.free();
    },
  };
}
