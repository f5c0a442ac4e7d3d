// What tests of the springs call in an empty page: the engine of the live page, many moves at once.
import type { LiveBody, LiveFrame, LiveSettings, Tool } from '../src/live/types.ts';
import type { CutAnswer, CutRequest } from '../src/live/tool/blade/types.ts';
import { bodyAfter } from '../src/live/tool/blade/cut_body.ts';
import { wasmEngine } from '../src/live/engines/wasm_engine.ts';

export type Row =
  | { kind: 'choose'; settings: LiveSettings }
  | { kind: 'move'; tool: Tool; numSteps: number }
  | { kind: 'cut'; request: CutRequest }
  | { kind: 'reset' | 'keep' | 'undo' };
/** Of arrays of numbers, so that it can be said across processes. */
type Plain<T> = { [K in keyof T]: T[K] extends string | number ? T[K] : T[K] extends ArrayLike<number> ? number[] : Plain<T[K]> };
type PlainBody = Plain<Omit<LiveBody, 'cuts'>>;

const engine = wasmEngine();

const bodyOf = (body: PlainBody): LiveBody => ({
  file: '',
  points: Float64Array.from(body.points),
  tetrahedra: Int32Array.from(body.tetrahedra),
  region: Int32Array.from(body.region),
  density: Float64Array.from(body.density),
  youngModulus: Float64Array.from(body.youngModulus),
  poissonRatio: Float64Array.from(body.poissonRatio),
  triangles: Int32Array.from(body.triangles),
  constrained: Uint8Array.from(body.constrained),
  modulusFactor: Float64Array.from(body.modulusFactor),
  capsule: body.capsule && { ...body.capsule, covered: Uint8Array.from(body.capsule.covered) },
  vessels: body.vessels && {
    ...body.vessels,
    points: Float64Array.from(body.vessels.points),
    radius: Float64Array.from(body.vessels.radius),
    segments: Int32Array.from(body.vessels.segments),
  },
  foundation: body.foundation && {
    facets: Int32Array.from(body.foundation.facets),
    stiffness: Float64Array.from(body.foundation.stiffness),
    normalOnly: Uint8Array.from(body.foundation.normalOnly),
  },
});

const open = async (body: PlainBody): Promise<string[]> => (await engine.open(bodyOf(body))).springLaws;

/** The foundation of what a cut has left, as the page marks it. */
function foundationLeft(body: PlainBody, { gone, triangles, constrained, wound, ...numbers }: Plain<Omit<CutAnswer, 'parted'>>): unknown {
  const parted = { nodes: new Int32Array(), places: new Float64Array(), parents: new Int32Array(), tetrahedra: new Int32Array() };
  const answer = { ...numbers, parted, gone: Int32Array.from(gone), triangles: Int32Array.from(triangles), constrained: Uint8Array.from(constrained), wound: Uint8Array.from(wound) };
  const left = bodyAfter(bodyOf(body), answer as CutAnswer).foundation;
  return left && { facets: [...left.facets], stiffness: [...left.stiffness], normalOnly: [...left.normalOnly] };
}

const numbersOf = ({ displacement, loadedNodes, nodalForces, loadedFacets, tractions, tool, force, needle, ...numbers }: LiveFrame) => ({
  ...numbers,
  needle: needle && { ...needle, forces: Array.from(needle.forces) },
  tool,
  force,
  displacement: Array.from(displacement),
  loadedNodes: Array.from(loadedNodes),
  nodalForces: Array.from(nodalForces),
  loadedFacets: Array.from(loadedFacets),
  tractions: Array.from(tractions),
});

/** Numbers of a cut, without how long it took. */
const plain = ({ seconds: _, gone, parted: __, triangles, constrained, wound, ...numbers }: CutAnswer) => ({
  ...numbers, gone: [...gone], triangles: [...triangles], constrained: [...constrained], wound: [...wound],
});

/** @return of each row what it answered; of moves all numbers, or those that tell whether the body is sound */
async function play(rows: Row[], whole: boolean): Promise<unknown[]> {
  const answers = [];
  for (const row of rows) {
    if (row.kind === 'choose') answers.push(await engine.choose(row.settings));
    else if (row.kind === 'reset') answers.push(await engine.reset());
    else if (row.kind === 'keep') answers.push(await engine.keep());
    else if (row.kind === 'undo') answers.push(await engine.restore());
    else if (row.kind === 'cut') answers.push(await engine.cut(row.request).then(plain, (error: Error) => ({ fault: error.message })));
    else {
      const frame = await engine.move(row.tool, row.numSteps);
      const { time, force, indentation, smallestVolume, restarts, displacement, grasp } = frame;
      answers.push(whole ? numbersOf(frame) : { time, force, indentation, smallestVolume, restarts, grasp, finite: displacement.every(Number.isFinite) });
    }
  }
  return answers;
}

Object.assign(globalThis, { springs: { open, play, foundationLeft } });
