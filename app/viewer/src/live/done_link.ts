// What was done to a body as text in a link: cuts, one after the other, and the tool that is still there. Lengths in mm.
import type { CutRequest, CutTool } from './tool/blade/types.ts';
import { atRest, isHolding, type Grasp, type Holding, type ToolState } from './tool/tool_state.ts';
import type { Vector } from './vector.ts';

/** A tool that holds on. */
export interface HeldTool {
  kind: Holding;
  radius: number; // [m]
  grasp: Grasp;
}

export interface Done {
  cuts: CutRequest[];
  tool: HeldTool | null;
}

const millimetres = (values: readonly number[]) => values.map((x) => Number((1000 * x).toFixed(4)));
const digits = (values: readonly number[]) => values.map((x) => Number(x.toPrecision(7)));
const kinds = { region: 5, 'half-space': 7, blade: 14 } as const; // and how many numbers each has behind its name

function numbersOf({ tool, takesLoose }: CutRequest): (number | string)[] {
  const loose = Number(takesLoose);
  if (tool.kind === 'region') return [tool.kind, tool.region, ...millimetres([tool.margin]), Number(tool.keepsMargin), Number(tool.opens), loose];
  if (tool.kind === 'half-space') return [tool.kind, ...millimetres(tool.point), ...digits(tool.normal), loose];
  return [tool.kind, ...millimetres(tool.corners.flat()), ...millimetres([tool.thickness]), loose];
}

/** The tool that holds on; null if none does. */
export const heldTool = ({ kind, radius, grasp }: ToolState): HeldTool | null => (grasp && isHolding(kind) ? { kind, radius: radius[kind], grasp } : null);

export function writeDone(link: URLSearchParams, { cuts, tool }: Done): void {
  for (const cut of cuts) link.append('live_done', numbersOf(cut).join(','));
  if (!tool) return;
  const { point, inwards, node, moved, goal, needle } = tool.grasp;
  const values = needle?.values;
  const ofNeedle = needle && values ? [...millimetres(needle.target), ...digits([values.diameter, values.spread, values.toughness, values.friction, values.punctureForce])] : [];
  link.set('live_tool', [tool.kind, ...millimetres([tool.radius]), node, ...millimetres(point), ...digits(inwards), ...millimetres([...moved, goal]), ...ofNeedle].join(','));
}

/** The name and the numbers behind it; null if these are not numbers. */
function partsOf(text: string): [name: string, numbers: number[]] | null {
  const [name = '', ...rest] = text.split(',');
  const numbers = rest.map(Number);
  return rest.every((number) => number !== '') && numbers.every(Number.isFinite) ? [name, numbers] : null;
}

function cutOf(text: string): CutRequest | null {
  const [kind, numbers] = partsOf(text) ?? ['', []];
  if (!Object.hasOwn(kinds, kind) || numbers.length !== kinds[kind as CutTool['kind']]) return null;
  const metres = numbers.map((x) => x / 1000), vector = (from: number, of = metres) => of.slice(from, from + 3) as Vector;
  const takesLoose = numbers.at(-1) === 1;
  if (kind === 'region') return { tool: { kind, region: numbers[0]!, margin: metres[1]!, keepsMargin: numbers[2] === 1, opens: numbers[3] === 1 }, takesLoose };
  if (kind === 'half-space') return { tool: { kind, point: vector(0), normal: vector(3, numbers) }, takesLoose };
  return { tool: { kind: 'blade', corners: [vector(0), vector(3), vector(6), vector(9)], thickness: metres[12]! }, takesLoose };
}

function toolOf(text: string): HeldTool | null {
  const [kind, numbers] = partsOf(text) ?? ['', []];
  const isNeedle = kind === 'needle';
  if (!Object.hasOwn(atRest.radius, kind) || numbers.length !== (isNeedle ? 20 : 12)) return null;
  const node = numbers[1]!, metres = numbers.map((x) => x / 1000), vector = (from: number, of = metres) => of.slice(from, from + 3) as Vector;
  if (!(numbers[0]! > 0) || !Number.isInteger(node) || node < 0) return null;
  const [diameter, spread, toughness, friction, punctureForce] = numbers.slice(15) as [number, number, number, number, number];
  const needle = isNeedle ? { target: vector(12), values: { diameter, spread, toughness, friction, punctureForce } } : null;
  return { kind: kind as Holding, radius: metres[0]!, grasp: { node, point: vector(2), inwards: vector(5, numbers), moved: vector(8), depth: 0, goal: metres[11]!, needle } };
}

/** Of a link; what cannot be read counts as if it were not there. */
export function linkedDone(link: URLSearchParams): Done {
  return {
    cuts: link.getAll('live_done').map(cutOf).filter((cut) => cut !== null),
    tool: toolOf(link.get('live_tool') ?? ''),
  };
}
