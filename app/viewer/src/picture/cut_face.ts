// The closed face of a body that is cut open: the colours of the legend, and lines around the regions inside.
import * as three from 'three';
import type { Surface } from '../data/surface.ts';
import type { Colouring } from './colour_maps.ts';
import { textureCoordinates } from './fields.ts';
import { mapWidth } from './materials.ts';
import { outlineOf, sectionOf, type Cut } from './section.ts';

export interface CutFace {
  object: three.Object3D;
  mesh: three.Mesh; // for picking
  /** @param places (N,3) of the nodes as they are drawn [m] */
  show(cut: Cut | null, places: Float32Array, look: { values: Float32Array; end: number; quantity: Colouring }): void;
  nodeOf(vertex: number): number;
  free(): void;
}

export function createCutFace(material: three.Material, outline: three.LineBasicMaterial, inside: Surface, tetrahedra: Int32Array): CutFace {
  const mesh = new three.Mesh(new three.BufferGeometry(), material);
  const lines = new three.LineSegments(new three.BufferGeometry(), outline);
  const object = new three.Group();
  object.add(mesh, lines);
  mesh.visible = lines.visible = false;
  lines.renderOrder = 3;
  let nodes: Int32Array = new Int32Array();

  function replace(part: three.Mesh | three.LineSegments, places: Float32Array): void {
    part.geometry.dispose(); // another number of vertices
    part.geometry = new three.BufferGeometry();
    part.geometry.setAttribute('position', new three.BufferAttribute(places, 3));
    part.visible = places.length > 0;
  }

  return {
    object,
    mesh,
    show(cut, places, { values, end, quantity }) {
      const section = cut ? sectionOf(cut, tetrahedra, places, values) : null;
      nodes = section?.nodes ?? new Int32Array();
      replace(mesh, section?.places ?? new Float32Array());
      replace(lines, cut ? outlineOf(cut, inside, places) : new Float32Array());
      if (!section) return;
      const vertices = Int32Array.from(section.values.keys());
      mesh.geometry.setAttribute('uv', new three.BufferAttribute(textureCoordinates(vertices, section.values, end, mapWidth, quantity !== 'tissue'), 2));
    },
    nodeOf: (vertex) => nodes[vertex]!,
    free() {
      for (const part of [mesh, lines]) part.geometry.dispose();
    },
  };
}
