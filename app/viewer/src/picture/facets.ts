// The surface once more, with facets that share no corner: each has a colour of its own up to its edges.
import * as three from 'three';

export interface Facets {
  mesh: three.Mesh;
  /** They go where the surface is drawn now. */
  follow(): void;
  free(): void;
}

/**
 * @param outside   the surface as it is drawn
 * @param colour    (T) number of the colour of each facet
 * @param material  whose map has that many colours side by side
 */
export function createFacets(outside: three.BufferGeometry, colour: Int32Array, numColours: number, material: three.Material): Facets {
  const index = outside.getIndex()!;
  const geometry = new three.BufferGeometry();
  const uv = Float32Array.from({ length: 2 * index.count }, (_, i) =>
    (i % 2 === 1 ? 0.25 : (colour[Math.floor(i / 6)]! + 0.5) / numColours));
  geometry.setAttribute('uv', new three.BufferAttribute(uv, 2));
  for (const name of ['position', 'normal'])
    geometry.setAttribute(name, new three.BufferAttribute(new Float32Array(3 * index.count), 3));
  const mesh = new three.Mesh(geometry, material);
  mesh.frustumCulled = false;
  mesh.visible = false;
  return {
    mesh,
    follow() {
      for (const name of ['position', 'normal']) {
        const from = outside.getAttribute(name).array;
        const to = geometry.getAttribute(name);
        for (let corner = 0; corner < index.count; corner++)
          for (let i = 0; i < 3; i++) to.array[3 * corner + i] = from[3 * index.getX(corner) + i]!;
        to.needsUpdate = true;
      }
    },
    free: () => geometry.dispose(),
  };
}
