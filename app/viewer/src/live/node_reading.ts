// What is there at one node: of the springs, of finite elements, and how far they are apart.
import { nodalStrain, strainMesh } from '../data/strain.ts';
import { byId } from '../page/elements.ts';
import { millimetres, percent } from '../picture/scale.ts';
import { tell } from './readings.ts';
import type { Truth } from './truth.ts';
import type { LiveBody } from './types.ts';

/** The strain at one node alone, from the tetrahedra around it. */
export function strainAt(body: LiveBody, node: number): (displacement: Float32Array) => number {
  const around: number[] = [];
  for (let i = 0; i < body.tetrahedra.length; i++) if (body.tetrahedra[i] === node) around.push(i >> 2);
  const corners = around.flatMap((t) => [...body.tetrahedra.subarray(4 * t, 4 * t + 4)]);
  const nodes = [...new Set(corners)];
  const here = (values: ArrayLike<number>) => Float64Array.from(nodes.flatMap((n) => [values[3 * n]!, values[3 * n + 1]!, values[3 * n + 2]!]));
  const mesh = strainMesh(here(body.points), Int32Array.from(corners, (n) => nodes.indexOf(n)));
  const own = nodes.indexOf(node);
  return (displacement) => nodalStrain(mesh, here(displacement))[own]!;
}

/** What is less is what single precision leaves of rest [m]. */
const smallest = 1e-7;

const lengthAt = (u: Float32Array, node: number) => Math.hypot(u[3 * node]!, u[3 * node + 1]!, u[3 * node + 2]!);

export interface NodeReading {
  /** @param node  null for none */
  read(body: LiveBody, node: number | null): void;
  /** @param truth  null where finite elements have said nothing  @param isUnloaded  they are at rest, because nothing acts on the body */
  show(displacement: Float32Array, truth: Truth | null, isUnloaded: boolean): void;
}

export function createNodeReading(): NodeReading {
  let node: number | null = null;
  let strain: (displacement: Float32Array) => number = () => 0;
  return {
    read(body, chosen) {
      node = chosen;
      byId('live-at-node').hidden = node === null;
      if (node === null) return;
      strain = strainAt(body, node);
      const place = [0, 1, 2].map((i) => (1000 * body.points[3 * node! + i]!).toFixed(1).replace('-', '−'));
      byId('live-at-name').textContent = `Node ${node}, at rest at (${place.join(', ')}) mm`;
    },
    show(displacement, truth, isUnloaded) {
      if (node === null) return;
      const mm = (id: string, metres: number, more = '') => tell(id, metres, Number.isNaN(metres) ? '–' : `${metres < smallest ? '0' : millimetres(metres)} mm${more}`);
      const elements = truth?.displacement;
      mm('live-at-springs', lengthAt(displacement, node));
      mm('live-at-elements', elements ? lengthAt(elements, node) : isUnloaded ? 0 : Number.NaN);
      const off = truth && [0, 1, 2].map((i) => truth.frame.displacement[3 * node! + i]! - truth.displacement[3 * node! + i]!);
      mm('live-at-off', off ? Math.hypot(...off) : Number.NaN, truth?.isAtRest ? '' : ', still moving');
      const now = strain(displacement);
      tell('live-at-strain', now, `${percent(now)} %`);
    },
  };
}
