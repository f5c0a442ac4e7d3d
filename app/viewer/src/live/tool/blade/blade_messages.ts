// What the springs are told of a cut, and what they answer: see app/live/messages.hpp.
import type { CutAnswer, CutRequest, CutTool } from './types.ts';

function toolNumbers(tool: CutTool): number[] {
  if (tool.kind === 'region') return [0, tool.region, tool.margin, Number(tool.keepsMargin)];
  if (tool.kind === 'half-space') return [1, ...tool.point, ...tool.normal];
  return [2, ...tool.corners.flat(), tool.thickness];
}

export const cutMessage = ({ tool, takesLoose }: CutRequest): Float64Array => Float64Array.of(7, Number(takesLoose), ...toolNumbers(tool));

/** @param numbers  of the answer, from the front */
export function readCut(numbers: { number(): number; take(count: number): Float64Array }): CutAnswer {
  const [volume, woundArea, margin, numLoose, numPieces] = [numbers.number(), numbers.number(), numbers.number(), numbers.number(), numbers.number()];
  const seconds = { find: numbers.number(), check: numbers.number(), springs: numbers.number(), all: numbers.number() };
  const [numGone, numTriangles] = [numbers.number(), numbers.number()];
  const gone = Int32Array.from(numbers.take(numGone));
  const triangles = Int32Array.from(numbers.take(3 * numTriangles));
  const kinds = numbers.take(numTriangles);
  return {
    volume, woundArea, margin, numLoose, numPieces, seconds, gone, triangles,
    constrained: Uint8Array.from(kinds, (kind) => Number(kind === 1)),
    wound: Uint8Array.from(kinds, (kind) => Number(kind === 2)),
  };
}
