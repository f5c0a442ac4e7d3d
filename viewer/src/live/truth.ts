// What finite elements say to the round load or the needle that the springs are under: one question under way, always about the latest frame.
import { nodalVolumes } from '../data/nodal_volumes.ts';
import type { NeedleFrame } from './tool/needle/types.ts';
import type { LiveBody, LiveFrame, LiveSettings, TruthEngine } from './types.ts';
import { length, plus } from './vector.ts';

export interface Truth {
  displacement: Float32Array; // of finite elements, (N,3) [m]
  asked: Float32Array; // of the springs under these forces, (N,3) [m]
  force: number; // of the hand [N]
  springs: number; // indentation, or how far the target of a needle has moved [m]
  elements: number; // the same of finite elements; an indentation in the mean over the disc weighted with the same round load [m]
  apart: number | null; // of a needle: between the two targets [m]
  error: number; // of the displacement, weighted by volume as in the comparison of result files
  isAtRest: boolean; // the springs were
}

/** @return |u - r| / |r| in the norm that the weights give; NaN where nothing moves */
export function relativeError(u: Float32Array, r: Float32Array, weights: Float64Array): number {
  let [off, size] = [0, 0];
  weights.forEach((weight, node) => {
    for (let i = 3 * node; i < 3 * node + 3; i++) {
      off += weight * (u[i]! - r[i]!) ** 2;
      size += weight * r[i]! ** 2;
    }
  });
  return Math.sqrt(off / size);
}

/** Stiffness of the springs at the tool over that of finite elements: force over indentation, the force being the same. */
export const stiffnessRatio = ({ springs, elements }: Pick<Truth, 'springs' | 'elements'>): number => elements / springs;

/** By how much a force has to change for a hand to notice, as a part of it (Pang, Tan, Durlach 1991, Perception & Psychophysics 49). */
const noticeable = 0.07;

/** What a hand would say of the springs, or where they have the target, in a sentence. */
export function inWords(truth: Pick<Truth, 'springs' | 'elements' | 'apart'>): string {
  if (truth.apart !== null) return `The springs have the target ${(1000 * truth.apart).toFixed(2)} mm from where FEM has it.`;
  const off = stiffnessRatio(truth) - 1;
  if (!Number.isFinite(off)) return '';
  const amount = Math.round(100 * Math.abs(off));
  const how = amount === 0 ? 'as stiff as FEM here' : `${amount} % too ${off < 0 ? 'soft' : 'stiff'} here`;
  return `The springs are ${how}; a hand feels ${Math.round(100 * noticeable)} %.`;
}

/** Whether the tool does anything to the body. */
export const isLoaded = ({ loadedFacets, needle }: LiveFrame): boolean => loadedFacets.length > 0 || !!needle?.forces.some((force) => force !== 0);

/** Whether a body goes less than a fiftieth of its displacement in a second. */
export function isSlow(frame: LiveFrame, before: LiveFrame): boolean {
  const passed = frame.time - before.time;
  if (!(passed > 0)) return false;
  let [way, size] = [0, 0];
  frame.displacement.forEach((u, i) => {
    way = Math.max(way, Math.abs(u - before.displacement[i]!));
    size = Math.max(size, Math.abs(u));
  });
  return way < 0.02 * size * passed;
}

export interface Asking {
  choose(settings: LiveSettings): void;
  /** @param before  the frame before it, from which its speed is known */
  ask(frame: LiveFrame, before: LiveFrame): void;
  close(): void;
}

/** @param engine  new; it is closed with the asking */
export function startAsking(engine: TruthEngine, body: LiveBody, settings: LiveSettings, onTruth: (truth: Truth) => void, onFault: (error: unknown) => void): Asking {
  const volumes = nodalVolumes(body.points, body.tetrahedra);
  let wanted = settings;
  let chosen: LiveSettings | null = null;
  let isBusy = true;
  let latest: [LiveFrame, LiveFrame] | null = null; // that came while it was busy
  let isClosed = false;

  async function answer(frame: LiveFrame, isAtRest: boolean): Promise<void> {
    if (chosen !== wanted) await engine.choose((chosen = wanted));
    const found = frame.needle ? await pierced(frame.needle) : await pressed(frame);
    if (isClosed) return;
    onTruth({ ...found, asked: frame.displacement, error: relativeError(frame.displacement, found.displacement, volumes), isAtRest });
  }
  async function pressed(frame: LiveFrame) {
    const { displacement, work } = await engine.solve(frame);
    const force = length(frame.force);
    return { displacement, force, springs: frame.indentation, elements: work / force, apart: null };
  }
  async function pierced(needle: NeedleFrame) {
    const { displacement, targetMoved } = await engine.pierce(needle);
    const apart = length(plus(needle.targetMoved, targetMoved, -1));
    return { displacement, force: needle.force, springs: length(needle.targetMoved), elements: length(targetMoved), apart };
  }
  const fail = (error: unknown) => void (isClosed || onFault(error));
  const whenDone = (work: Promise<void>) => {
    isBusy = true;
    // After a fault nothing more is asked.
    work.then(goOn, fail);
  };
  // A body that has come to rest sends no more frames: the last one has to be asked about.
  function goOn(): void {
    isBusy = false;
    const next = latest;
    latest = null;
    if (next && !isClosed) ask(...next);
  }
  function ask(frame: LiveFrame, before: LiveFrame): void {
    if (isBusy) latest = [frame, before];
    else if (isLoaded(frame)) whenDone(answer(frame, isSlow(frame, before)));
  }
  whenDone(engine.open(body));

  return {
    choose: (next) => (wanted = next),
    ask,
    close() {
      isClosed = true;
      engine.close();
    },
  };
}
