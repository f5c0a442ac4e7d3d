// What an engine is told, and what it answers, as numbers in a row: see app/live/messages.hpp.
import { Fault } from '../../data/types.ts';
import { readCut } from '../tool/blade/blade_messages.ts';
import type { CutAnswer } from '../tool/blade/types.ts';
import { graspMessage, readGrasp } from '../tool/jaws/jaws_messages.ts';
import { needleMessage, readNeedle } from '../tool/needle/needle_messages.ts';
import type { Chosen, LiveBody, LiveFrame, LiveSettings, Tool } from '../types.ts';
import type { Vector } from '../vector.ts';

function capsuleParts({ capsule }: LiveBody): ArrayLike<number>[] {
  return capsule ? [[1, capsule.thickness, capsule.youngModulus], capsule.covered] : [[0]];
}

function vesselParts({ vessels }: LiveBody): ArrayLike<number>[] {
  if (!vessels || vessels.segments.length === 0) return [[0]];
  const { points, radius, segments, wallRatio, wallModulus } = vessels;
  return [[radius.length, segments.length / 2], points, radius, segments, [wallRatio, wallModulus]];
}

function foundationParts({ foundation }: LiveBody): ArrayLike<number>[] {
  return foundation ? [[foundation.facets.length], foundation.facets, foundation.stiffness, foundation.normalOnly] : [[0]];
}

export function bodyMessage(body: LiveBody): Float64Array {
  const parts = [
    [body.points.length / 3, body.tetrahedra.length / 4, body.density.length, body.triangles.length / 3],
    body.points, body.tetrahedra, body.region, body.density, body.youngModulus, body.poissonRatio, body.triangles, body.constrained,
    [body.modulusFactor.length], body.modulusFactor, ...capsuleParts(body), ...vesselParts(body), ...foundationParts(body),
  ];
  const message = new Float64Array(parts.reduce((length, part) => length + part.length, 0));
  let length = 0;
  for (const part of parts) {
    message.set(part, length);
    length += part.length;
  }
  return message;
}

export function chooseMessage(settings: LiveSettings, springLaws: string[]): Float64Array {
  return Float64Array.of(
    1, springLaws.indexOf(settings.springLaw), Number(settings.keepsVolume), settings.youngModulus, settings.poissonRatio,
    settings.massDamping, settings.stiffnessDamping, settings.timeStep);
}

const kinds = { none: 0, probe: 1, pull: 2 };

export function moveMessage(tool: Tool, numSteps: number): Float64Array {
  if (tool.kind === 'needle') return needleMessage(tool, numSteps);
  if (tool.kind === 'grasp') return graspMessage(tool, numSteps);
  if (tool.kind === 'plate') return Float64Array.of(9, ...tool.target, ...tool.inwards, tool.radius, numSteps);
  const target: Vector = tool.kind === 'none' ? [0, 0, 0] : tool.target;
  const radius = tool.kind === 'none' ? 0 : tool.radius;
  return Float64Array.of(2, kinds[tool.kind], ...target, radius, tool.kind === 'pull' ? tool.node : 0, numSteps);
}

export const resetMessage = (): Float64Array => Float64Array.of(3);
export const keepMessage = (): Float64Array => Float64Array.of(4);
export const restoreMessage = (): Float64Array => Float64Array.of(5);

/** Takes numbers from the front of an answer. */
class Numbers {
  #offset = 0;
  constructor(private readonly bytes: ArrayBuffer) {}

  take(count: number): Float64Array {
    const begin = this.#offset;
    this.#offset += count * Float64Array.BYTES_PER_ELEMENT;
    if (this.#offset > this.bytes.byteLength) throw new Fault('An answer ends too early. Load the page again.');
    return new Float64Array(this.bytes, begin, count);
  }
  number(): number {
    return this.take(1)[0]!;
  }
  vector(): Vector {
    return [this.number(), this.number(), this.number()];
  }
  /** What is left, which is shorter numbers. */
  rest(): Float32Array {
    return new Float32Array(this.bytes, this.#offset);
  }
}

/** In the order of app/live/scene.hpp. */
const limits = ['rest', 'pressed', 'hand'] as const;

export function readChosen(bytes: ArrayBuffer): Chosen {
  const numbers = new Numbers(bytes);
  return {
    timeStep: numbers.number(),
    longestTimeStep: numbers.number(),
    criticalTimeStep: numbers.number(),
    pressedTimeStep: numbers.number(),
    numSprings: numbers.number(),
    unscaledTimeStep: numbers.number(),
    limit: limits[numbers.number()]!,
  };
}

export const readCutAnswer = (bytes: ArrayBuffer): CutAnswer => readCut(new Numbers(bytes));

/** @param tool  that was asked for */
export function readFrame(bytes: ArrayBuffer, tool: Tool): LiveFrame {
  const numbers = new Numbers(bytes);
  const needle = tool.kind === 'needle' ? readNeedle(numbers, tool) : null;
  const grasp = tool.kind === 'grasp' ? readGrasp(numbers) : null;
  const state = {
    time: numbers.number(),
    tool: numbers.vector(),
    force: numbers.vector(),
    radius: tool.kind === 'none' || tool.kind === 'needle' ? 0 : tool.radius,
    disc: { middle: numbers.vector(), radius: numbers.number() },
    indentation: numbers.number(),
    smallestVolume: numbers.number(),
    largestSpeed: numbers.number(),
    restarts: numbers.number(),
    stepSeconds: numbers.number(),
    numEvaluations: numbers.number(),
  };
  const numNodes = numbers.number(), numLoaded = numbers.number(), numFacets = numbers.number();
  const frame = {
    ...state,
    loadedNodes: Int32Array.from(numbers.take(numLoaded)),
    nodalForces: numbers.take(3 * numLoaded),
    loadedFacets: Int32Array.from(numbers.take(numFacets)),
    tractions: numbers.take(3 * numFacets),
    displacement: numbers.rest(),
    needle,
    grasp,
  };
  if (frame.displacement.length !== 3 * numNodes) throw new Fault('An answer is of another body. Load the page again.');
  return frame;
}
