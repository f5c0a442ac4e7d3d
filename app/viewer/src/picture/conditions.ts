// Where a body is constrained, pressed and pulled: patterns on the facets of its surface, and arrows. Any stage can show it.
import * as three from 'three';
import { createArrows, type Arrows } from './arrows.ts';
import { facetMarks, facetsIn, facetsMarked, largestOf, spreadOut, vectorOf, type Conditions, type FacetMark } from './facet_conditions.ts';

import type { MarkedArrow } from './overlay.ts';

export type { Conditions } from './facet_conditions.ts';

/** What of it is drawn: a body that moves after the release has no tractions any more. */
export interface ConditionsShown {
  constrained: boolean; // all displacements that are prescribed, and springs below facets
  loaded: boolean; // tractions
}

export interface ConditionsInScene {
  object: three.Object3D;
  show(shown: ConditionsShown): void;
  /** Arrows go where the facets are drawn now. */
  follow(): void;
  clip(planes: three.Plane[]): void;
  /** Those that are drawn. */
  arrows(): MarkedArrow[];
  free(): void;
}

const longest = 0.13; // of the arrows, as a part of the body
const spacing = 0.028; // between them
const mostArrows = 28; // of a kind
export const arrowColours = { moved: 0x1f5fd6, loaded: 0xd6281f } as const;

/** Numbers of the patterns in the shader; the key beside the picture draws the same (style.css). */
const patterns: Record<FacetMark, number> = { fixed: 0, sliding: 1, moved: 2, loaded: 3, supported: 4 };

/** The view that is being drawn: patterns begin at its corner, so that they are alike in all views. */
interface Screen {
  pixelRatio: { value: number };
  viewport: { value: three.Vector4 }; // pixels
}

/** Dark lines with a white edge, of the same width on the screen at any distance: they are seen on every colour. */
function patternMaterial(pattern: number, screen: Screen): three.MeshBasicMaterial {
  const material = new three.MeshBasicMaterial({ transparent: true, depthWrite: false, toneMapped: false, side: three.DoubleSide,
    polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -2 });
  material.onBeforeCompile = (shader) => {
    shader.uniforms['pattern'] = { value: pattern };
    shader.uniforms['pixelRatio'] = screen.pixelRatio;
    shader.uniforms['viewport'] = screen.viewport;
    shader.fragmentShader = `uniform int pattern;
      uniform float pixelRatio;
      uniform vec4 viewport;
      // Distance from the next of parallel lines [CSS pixels].
      float fromLine(float place, float period) { return abs(mod(place, period) - 0.5 * period); }
      ${shader.fragmentShader}`.replace('#include <opaque_fragment>', `
      vec2 pixel = (gl_FragCoord.xy - viewport.xy) / pixelRatio;
      float rising = (pixel.x - pixel.y) * 0.7071;
      float falling = (pixel.x + pixel.y) * 0.7071;
      float away = pattern == 0 ? fromLine(rising, 8.0)
        : pattern == 1 ? max(fromLine(pixel.y, 8.0), 2.0 - fromLine(pixel.x, 8.0))
        : pattern == 2 ? min(fromLine(rising, 10.0), fromLine(falling, 10.0))
        : pattern == 3 ? length(vec2(fromLine(pixel.x, 9.0), fromLine(pixel.y, 9.0))) - 0.6
        : 0.8 * fromLine(pixel.y + 0.75 * fromLine(pixel.x, 8.0), 9.0); // zigzags, as springs are drawn
      float dark = 1.0 - smoothstep(0.55, 1.05, away);
      float edge = 1.0 - smoothstep(1.3, 1.9, away);
      diffuseColor = vec4(vec3(1.0 - dark), max(dark, 0.75 * edge));
      outgoingLight = diffuseColor.rgb;
      #include <opaque_fragment>`);
  };
  return material;
}

/** Those facets of a geometry, with the places that the geometry has. */
function partOf(geometry: three.BufferGeometry, facets: number[]): three.BufferGeometry {
  const part = new three.BufferGeometry();
  const index = geometry.getIndex()!;
  part.setAttribute('position', geometry.getAttribute('position'));
  part.setIndex(new three.BufferAttribute(Uint32Array.from(facets.flatMap((t) => [0, 1, 2].map((i) => index.getX(3 * t + i)))), 1));
  return part;
}

interface Loads {
  facets: number[]; // that have an arrow
  arrows: Arrows;
  placed: MarkedArrow[];
  colour: string;
  largest: number;
}

/**
 * @param outside     the surface as it is drawn; its facets are those of the conditions
 * @param conditions  of each facet, with values
 * @param rest        (T,3) centres of the facets at rest, which decide where arrows stand [m]
 * @param size        of the body [m]
 */
export function createConditions(outside: three.BufferGeometry, conditions: Conditions, rest: Float32Array, size: number): ConditionsInScene {
  const object = new three.Group();
  const screen: Screen = { pixelRatio: { value: 1 }, viewport: { value: new three.Vector4() } };
  const parts = facetMarks.map((mark) => {
    const part = new three.Mesh(partOf(outside, facetsMarked(conditions, mark)), patternMaterial(patterns[mark], screen));
    part.frustumCulled = false;
    part.renderOrder = 3;
    part.onBeforeRender = (renderer) => {
      screen.pixelRatio.value = renderer.getPixelRatio();
      renderer.getCurrentViewport(screen.viewport.value);
    };
    object.add(part);
    return { mark, part };
  });
  const loadsOf = (state: 'moved' | 'loaded'): Loads => {
    const arrows = createArrows(mostArrows, arrowColours[state], size);
    object.add(arrows.object);
    return { facets: spreadOut(facetsIn(conditions, state), rest, spacing * size, mostArrows), arrows, placed: [], colour: `#${arrowColours[state].toString(16).padStart(6, '0')}`, largest: largestOf(conditions, state) };
  };
  const loads = { moved: loadsOf('moved'), loaded: loadsOf('loaded') };

  function arrowAt(facet: number, { largest, colour }: Loads, corners: three.Vector3[]): MarkedArrow {
    const places = outside.getAttribute('position') as three.BufferAttribute;
    const index = outside.getIndex()!;
    corners.forEach((corner, i) => corner.fromBufferAttribute(places, index.getX(3 * facet + i)));
    const [a, b, c] = corners as [three.Vector3, three.Vector3, three.Vector3];
    const centre = a.clone().add(b).add(c).divideScalar(3);
    const normal = b.clone().sub(a).cross(c.clone().sub(a));
    const along = new three.Vector3(...vectorOf(conditions, facet)).multiplyScalar((longest * size) / largest);
    // What presses ends at the surface, what pulls begins there: neither is hidden in the body.
    return { from: along.dot(normal) < 0 ? centre.sub(along) : centre, along, outwards: normal, colour };
  }

  return {
    object,
    show(shown) {
      for (const { mark, part } of parts) part.visible = mark === 'loaded' ? shown.loaded : shown.constrained;
      loads.moved.arrows.object.visible = shown.constrained;
      loads.loaded.arrows.object.visible = shown.loaded;
    },
    follow() {
      const corners = [new three.Vector3(), new three.Vector3(), new three.Vector3()];
      for (const kind of Object.values(loads)) {
        kind.placed = kind.facets.map((facet) => arrowAt(facet, kind, corners));
        kind.arrows.place(kind.placed);
      }
    },
    arrows: () => Object.values(loads).flatMap(({ arrows, placed }) => (arrows.object.visible ? placed : [])),
    clip(planes) {
      for (const { part } of parts) part.material.clippingPlanes = planes;
      for (const { arrows } of Object.values(loads)) arrows.clip(planes);
    },
    free() {
      for (const { part } of parts) {
        part.geometry.deleteAttribute('position'); // is the body's
        part.geometry.dispose();
        part.material.dispose();
      }
      for (const { arrows } of Object.values(loads)) arrows.free();
    },
  };
}

/** Centres of the facets of a surface at rest. @param points (N,3) @return (T,3) */
export function restCentres(surface: { nodes: Int32Array; triangles: Uint32Array }, points: Float32Array): Float32Array {
  const { nodes, triangles } = surface;
  return Float32Array.from(triangles, (_, j) =>
    [0, 1, 2].reduce((sum, corner) => sum + points[3 * nodes[triangles[j - (j % 3) + corner]!]! + (j % 3)]! / 3, 0));
}

/** Both ends of the arrows that may be there at rest, which the whole picture has to show. @return (E,3) m */
export function endsOfArrows(surface: { nodes: Int32Array; triangles: Uint32Array }, points: Float32Array, conditions: Conditions, size: number): Float32Array {
  const centres = restCentres(surface, points);
  return Float32Array.from((['moved', 'loaded'] as const).flatMap((state) => {
    const scale = (longest * size) / largestOf(conditions, state);
    return facetsIn(conditions, state).flatMap((facet) =>
      [-scale, scale].flatMap((s) => vectorOf(conditions, facet).map((x, i) => centres[3 * facet + i]! + s * x)));
  }));
}
