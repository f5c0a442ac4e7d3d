// One side of the picture: a body, what is inside, and the marked node.
import * as three from 'three';
import type { Surface, Surfaces } from '../data/surface.ts';
import { colourAt, notANumber, type Quantity } from './colour_maps.ts';
import { displaced, textureCoordinates } from './fields.ts';
import { createMarks, type Marks } from './marks.ts';

export type Skin = 'translucent' | 'solid' | 'flat';

/** What a side shows. */
export interface Look {
  displacement: Float32Array; // (N,3) m
  values: Float32Array; // (N) what is coloured
  end: number; // value at the end of the legend
  quantity: Quantity;
  skin: Skin;
  exaggeration: number;
  node: number | null; // marked
}

export interface Body {
  scene: three.Scene;
  outside: three.Mesh; // for picking
  show(look: Look): void;
  mark(marks: Marks): void;
  faceLight(camera: three.Camera): void;
  free(): void;
}

const mapWidth = 256;

function mapTexture(quantity: Quantity): three.DataTexture {
  const map = Array.from({ length: mapWidth }, (_, i) => [...colourAt(quantity, i / (mapWidth - 1)), 255]);
  const unknown = Array.from({ length: mapWidth }, () => [...notANumber, 255]);
  const texture = new three.DataTexture(new Uint8Array([...map, ...unknown].flat()), mapWidth, 2);
  texture.colorSpace = three.SRGBColorSpace;
  texture.magFilter = three.LinearFilter;
  texture.minFilter = three.LinearFilter;
  texture.needsUpdate = true;
  return texture;
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
  geometry.getAttribute('uv').array.set(textureCoordinates(surface, look.values, look.end, mapWidth));
  geometry.getAttribute('position').needsUpdate = true;
  geometry.getAttribute('uv').needsUpdate = true;
  geometry.computeVertexNormals();
  geometry.computeBoundingSphere();
}

/** Glass that is thicker where it is seen from the side, so that the shape of the body can be read. */
function glassMaterial(): three.MeshStandardMaterial {
  const glass = new three.MeshStandardMaterial({ roughness: 0.6, transparent: true, depthWrite: false });
  glass.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace('#include <opaque_fragment>', `
      float facing = abs(dot(normal, normalize(vViewPosition)));
      diffuseColor.a = mix(0.9, 0.5, smoothstep(0.0, 0.75, facing));
      #include <opaque_fragment>`);
  };
  return glass;
}

/** @param size  of the body [m] */
export function createBody(points: Float32Array, surfaces: Surfaces, size: number): Body {
  const textures = { displacement: mapTexture('displacement'), error: mapTexture('error') };
  const lit = new three.MeshStandardMaterial({ roughness: 0.75, side: three.DoubleSide });
  const glass = glassMaterial();
  // Without light, so that the colour on the screen is the colour of the legend.
  const flat = new three.MeshBasicMaterial({ side: three.DoubleSide, toneMapped: false });
  // Glass shows its front only: this writes how far that is, so that the far side does not shine through.
  const depth = new three.MeshBasicMaterial({ colorWrite: false });

  // A map from the start: to get one later, a material would have to be compiled again.
  for (const material of [lit, glass, flat]) material.map = textures.displacement;

  const outside: three.Mesh = new three.Mesh(geometryOf(surfaces.outside), lit);
  const front = new three.Mesh(outside.geometry, depth);
  const inside = new three.Mesh(geometryOf(surfaces.inside), lit);
  const marker = new three.Mesh(new three.SphereGeometry(0.011 * size, 24, 16), new three.MeshBasicMaterial({ color: 0x1c1c1c }));
  const halo = new three.Mesh(new three.SphereGeometry(0.016 * size, 24, 16),
    new three.MeshBasicMaterial({ color: 0xffffff, side: three.BackSide }));
  marker.add(halo);
  inside.renderOrder = 0;
  front.renderOrder = 1;
  outside.renderOrder = 2;
  marker.renderOrder = 3;

  const marks = createMarks(size);
  marks.show({ probe: null, grip: null, arrow: null });

  const light = new three.DirectionalLight(0xffffff, 2.2);
  const scene = new three.Scene();
  scene.add(new three.HemisphereLight(0xffffff, 0xb8b2aa, 1.7), light, light.target, inside, front, outside, marker, marks.object);

  return {
    scene,
    outside,
    show(look) {
      for (const material of [lit, glass, flat]) material.map = textures[look.quantity];
      const hasInside = surfaces.inside.nodes.length > 0;
      outside.material = { translucent: glass, solid: lit, flat }[look.skin];
      front.visible = look.skin === 'translucent';
      inside.visible = hasInside && look.skin === 'translucent';
      update(outside.geometry, surfaces.outside, points, look);
      if (hasInside) update(inside.geometry, surfaces.inside, points, look);
      marker.visible = look.node !== null;
      if (look.node !== null) {
        const one = { nodes: Int32Array.of(look.node), triangles: new Uint32Array() };
        marker.position.fromArray(displaced(one, points, look.displacement, look.exaggeration));
      }
    },
    mark: marks.show,
    faceLight(camera) {
      light.position.copy(camera.position).addScaledVector(camera.up, 0.5 * size);
    },
    free() {
      marks.free();
      for (const part of [outside, inside, marker, halo]) part.geometry.dispose();
      for (const material of [lit, glass, flat, depth]) material.dispose();
      for (const texture of Object.values(textures)) texture.dispose();
    },
  };
}
