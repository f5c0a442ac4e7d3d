// Where a tool touches or holds, and what is said of it.
import { byId } from '../../page/elements.ts';
import { tell } from '../readings.ts';
import type { LiveBody, LiveFrame, Tool } from '../types.ts';
import { length, plus, type Vector } from '../vector.ts';

const pointOf = ({ points }: Pick<LiveBody, 'points'>, node: number): Vector => [points[3 * node]!, points[3 * node + 1]!, points[3 * node + 2]!];

/** Mean length at rest of the edges of some triangles, those between two of them twice [m]; NaN of none. */
export function edgeLength(body: Pick<LiveBody, 'points' | 'triangles'>, facets: ArrayLike<number>): number {
  let sum = 0;
  for (let k = 0; k < facets.length; k++) {
    const corners = [0, 1, 2].map((i) => pointOf(body, body.triangles[3 * facets[k]! + i]!));
    corners.forEach((corner, i) => (sum += length(plus(corner, corners[(i + 1) % 3]!, -1))));
  }
  return sum / (3 * facets.length);
}

const millimetres = (metres: number) => Number((1000 * metres).toFixed(1));

/** One sentence where the mesh is too coarse for the tool, else none. @param radius  or half a side of a plate [m] @param edge [m] */
export function coarseness(radius: number, edge: number, kind: Tool['kind']): string {
  if (!(radius < edge)) return '';
  return `The tool is smaller than an edge: ${kind === 'plate' ? 'half a side' : 'its radius'} is ${millimetres(radius)} mm, the edges there are ${millimetres(edge)} mm long, and neither springs nor FEM resolve what happens under it.`;
}

/** Says where the tool touches or holds, as a load case would: the ball or plate of a touch, or disc = { point, radius, profile = "round" }. */
export function showDisc(body: LiveBody, { kind }: Tool, { disc, loadedFacets, radius, tool, grasp }: LiveFrame): void {
  const isLoaded = loadedFacets.length > 0;
  const isDisc = disc.radius > 0;
  const middle = isDisc ? disc.middle : tool;
  const number = (x: number) => (1000 * x).toFixed(1).replace('-', '−');
  tell('live-disc', isLoaded ? radius : Number.NaN, isLoaded ? `${number(radius)} mm` : '–');
  const said = (place: Vector) => `(${place.map(number).join(', ')})`;
  const where = grasp ? `centres of the jaws are at ${said(tool)} and ${said(grasp.other)}` : `${isDisc ? 'disc is around' : kind === 'plate' ? 'centre of the plate is at' : 'centre of the ball is at'} ${said(middle)}`;
  byId('live-disc-middle').textContent = isLoaded ? `The ${where} mm.` : '';
  byId('live-disc').dataset['middle'] = isLoaded ? middle.join() : '';
  const sentence = isLoaded ? coarseness(radius, edgeLength(body, loadedFacets), kind) : '';
  const line = byId('live-coarse');
  if (line.textContent !== sentence) line.textContent = sentence;
  line.hidden = sentence === '';
}
