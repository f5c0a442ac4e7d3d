// What the springs are told of a cut, and what they answer: see app/live/messages.hpp.
import type { CutAnswer, CutRequest, CutTool } from './types.ts';

function toolNumbers(tool: CutTool): number[] {
  if (tool.kind === 'region') return [0, tool.region, tool.margin, Number(tool.keepsMargin), Number(tool.opens)];
  if (tool.kind === 'half-space') return [1, ...tool.point, ...tool.normal];
  return [2, ...tool.corners.flat(), tool.thickness];
}

export const cutMessage = ({ tool, takesLoose }: CutRequest): Float64Array => Float64Array.of(7, Number(takesLoose), ...toolNumbers(tool));

/** @param numbers  of the answer, from the front */
export function readCut(numbers: { number(): number; take(count: number): Float64Array }): CutAnswer {
  const [volume, wayVolume, woundArea, margin] = [numbers.number(), numbers.number(), numbers.number(), numbers.number()];
  const closed = { volume: numbers.number(), depth: numbers.number() };
  const jagged = { mean: numbers.number(), worst: numbers.number() };
  const snapped = { mean: numbers.number(), worst: numbers.number() };
  const [numLoose, numPieces] = [numbers.number(), numbers.number()];
  const seconds = { find: numbers.number(), check: numbers.number(), springs: numbers.number(), all: numbers.number() };
  const [numGone, numTriangles, numNodes, numParted] = [numbers.number(), numbers.number(), numbers.number(), numbers.number()];
  const gone = Int32Array.from(numbers.take(numGone));
  const triangles = Int32Array.from(numbers.take(3 * numTriangles));
  const kinds = numbers.take(numTriangles);
  const moved = numbers.take(5 * numNodes);
  const column = (c: number) => moved.filter((_, i) => i % 5 === c);
  const parted = { nodes: Int32Array.from(column(0)), places: moved.filter((_, i) => i % 5 > 0 && i % 5 < 4), parents: Int32Array.from(column(4)), tetrahedra: Int32Array.from(numbers.take(5 * numParted)) };
  return {
    volume, wayVolume, woundArea, margin, closed, jagged, snapped, parted, numLoose, numPieces, seconds, gone, triangles,
    constrained: Uint8Array.from(kinds, (kind) => Number(kind === 1)),
    wound: Uint8Array.from(kinds, (kind) => Number(kind === 2)),
  };
}
