// Vessels in a body: tubes that are seen through glass, and where the body is cut open.
import * as three from 'three';
import { carried } from '../data/carriers.ts';
import type { CarriedVessels } from '../data/vessels.ts';
import type { Cut } from './section.ts';
import { placeTubes, tubeSections, tubeShape, type Tubes } from './tubes.ts';
import { vesselColour } from './vessel_colour.ts';

export interface VesselsInScene {
  object: three.Object3D;
  show(isShown: boolean): void;
  /** They go where the body is drawn now. @param displacement (N,3) m */
  follow(displacement: Float32Array, exaggeration: number): void;
  cut(cut: Cut | null, planes: three.Plane[]): void;
  free(): void;
}

const shape = tubeShape(12, 3);

/** Each tube is an instance of the shape, which its shader draws out between both ends. */
function tubeMaterial(colour: three.Color): three.MeshStandardMaterial {
  const material = new three.MeshStandardMaterial({ color: colour, emissive: colour, emissiveIntensity: 0.25, roughness: 0.5 });
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = `attribute vec4 begin;
      attribute vec4 end;
      attribute float along;
      ${shader.vertexShader}`
      .replace('#include <beginnormal_vertex>', `
      vec3 way = end.xyz - begin.xyz;
      vec3 axis = way / max(length(way), 1e-12);
      vec3 side = normalize(cross(axis, abs(axis.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
      vec3 objectNormal = position.x * side + position.y * cross(axis, side) + position.z * axis;`)
      .replace('#include <begin_vertex>', 'vec3 transformed = mix(begin.xyz, end.xyz, along) + mix(begin.w, end.w, along) * objectNormal;');
  };
  material.customProgramCacheKey = () => 'tubes';
  return material;
}

export function createVessels({ points, radius, segments, carriers }: CarriedVessels): VesselsInScene {
  const tubes: Tubes = { begin: new Float32Array(2 * segments.length), end: new Float32Array(2 * segments.length) };
  const colour = new three.Color().setRGB(...(vesselColour.map((x) => x / 255) as [number, number, number]), three.SRGBColorSpace);
  const geometry = new three.InstancedBufferGeometry();
  const outwards = new three.BufferAttribute(shape.outwards, 3);
  geometry.setIndex(new three.BufferAttribute(shape.triangles, 1));
  geometry.setAttribute('position', outwards);
  geometry.setAttribute('normal', outwards);
  geometry.setAttribute('along', new three.BufferAttribute(shape.along, 1));
  for (const name of ['begin', 'end'] as const)
    geometry.setAttribute(name, new three.InstancedBufferAttribute(tubes[name], 4).setUsage(three.DynamicDrawUsage));
  geometry.instanceCount = segments.length / 2;
  const walls = new three.Mesh(geometry, tubeMaterial(colour));
  // In the plane of a cut, before the face of the body there.
  const flat = new three.MeshBasicMaterial({ color: colour, side: three.DoubleSide, toneMapped: false, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -2 });
  const sections = new three.Mesh(new three.BufferGeometry(), flat);
  const object = new three.Group();
  object.add(walls, sections);
  walls.frustumCulled = sections.frustumCulled = false; // their bounds are not those of what is drawn
  walls.renderOrder = 0; // like all that is inside
  sections.renderOrder = 3;
  let shown: Cut | null = null;

  function drawSections(): void {
    const places = shown ? tubeSections(shown, tubes, shape) : new Float32Array();
    sections.geometry.dispose(); // another number of vertices
    sections.geometry = new three.BufferGeometry();
    sections.geometry.setAttribute('position', new three.BufferAttribute(places, 3));
    sections.visible = places.length > 0;
  }

  return {
    object,
    show: (isShown) => (object.visible = isShown),
    follow(displacement, exaggeration) {
      placeTubes(carried(points, carriers, displacement, exaggeration), radius, segments, tubes);
      for (const name of ['begin', 'end']) geometry.getAttribute(name).needsUpdate = true;
      if (shown) drawSections();
    },
    cut(next, planes) {
      shown = next;
      walls.material.clippingPlanes = planes;
      drawSections();
    },
    free() {
      for (const part of [walls, sections]) part.geometry.dispose();
      for (const material of [walls.material, flat]) material.dispose();
    },
  };
}
