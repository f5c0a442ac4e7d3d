// What finite elements say to the tractions or the needle that the springs are under, always about the latest frame.
// Linear elements follow the tool. Hyperelastic ones judge the springs once these are at rest, until another question interrupts them.
import { nodalVolumes } from '../data/nodal_volumes.ts';
import { Fault } from '../data/types.ts';
import { pressedWith } from './tool/jaws/jaws_panel.ts';
import type { NeedleFrame } from './tool/needle/types.ts';
import type { Elements, LiveBody, LiveFrame, LiveSettings, TruthEngine } from './types.ts';
import { length, plus } from './vector.ts';

export interface Truth {
  displacement: Float32Array; // of finite elements, (N,3) [m]
  frame: LiveFrame; // of the springs under these forces
  judge: Elements; // that have answered
  force: number; // of the hand [N]
  springs: number; // indentation, or how far the target of a needle has moved [m]
  elements: number; // the same of finite elements; an indentation in the mean weighted with the same tractions [m]
  apart: number | null; // of a needle: between the two targets [m]
  error: number; // of the displacement, weighted by volume as in the comparison of result files
  isAtRest: boolean; // whether the springs rest there
  isJudging: boolean; // whether hyperelastic elements are being asked about the same forces
  fault: string; // why hyperelastic elements do not judge; empty otherwise
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

/** Whether springs at rest are compared with the elements that judge them. */
export const isCompared = ({ isAtRest, isJudging }: Pick<Truth, 'isAtRest' | 'isJudging'>): boolean => isAtRest && !isJudging;

/** What a hand would say of the springs at rest, or where they have the target, and what they are compared with, in one sentence or two. */
export function inWords(truth: Pick<Truth, 'springs' | 'elements' | 'apart' | 'isAtRest' | 'isJudging' | 'judge' | 'fault'>): string {
  if (!truth.isAtRest) return 'Still moving: the springs are compared with FEM when they are at rest.';
  if (truth.isJudging) return 'At rest: hyperelastic FEM is being asked.';
  const why = truth.fault && ` Linear elements are too stiff themselves, and hyperelastic ones do not judge: ${truth.fault}.`;
  if (truth.apart !== null) return `The springs have the target ${(1000 * truth.apart).toFixed(2)} mm from where ${truth.judge} FEM has it.${why}`;
  const off = stiffnessRatio(truth) - 1;
  if (!Number.isFinite(off)) return '';
  const amount = Math.round(100 * Math.abs(off));
  const how = amount === 0 ? `as stiff as ${truth.judge} FEM here` : `${amount} % too ${off < 0 ? 'soft' : 'stiff'} here beside ${truth.judge} FEM`;
  return `The springs are ${how}; a hand feels ${Math.round(100 * noticeable)} %.${why}`;
}

/** Whether the tool does anything to the body. */
export const isLoaded = ({ loadedFacets, needle }: LiveFrame): boolean => loadedFacets.length > 0 || !!needle?.forces.some((force) => force !== 0);

export interface Asking {
  choose(settings: LiveSettings): void;
  ask(frame: LiveFrame): void;
  /** Whether the springs rest where the frame has them that was asked about last. */
  rest(isAtRest: boolean): void;
  close(): void;
}

/** @param engine  new; it is closed with the asking @param onTruth  told an answer, and again when more is known of it */
export function startAsking(engine: TruthEngine, body: LiveBody, settings: LiveSettings, onTruth: (truth: Truth) => void, onFault: (error: unknown) => void): Asking {
  const volumes = nodalVolumes(body.points, body.tetrahedra);
  let wanted = settings;
  let chosen: LiveSettings | null = null;
  let isAnswering = false; // or it is not open yet
  let isJudging = false; // even where nobody waits for it any longer
  let latest: LiveFrame | null = null;
  let isWaiting = false; // for an answer about it
  let isAtRest = false; // there
  let truth: Truth | null = null;
  let isClosed = false;

  function tell(next: Truth): void {
    truth = next;
    if (!isClosed) onTruth(next);
  }
  async function answer(frame: LiveFrame): Promise<void> {
    if (chosen !== wanted) await engine.choose((chosen = wanted));
    const found = await said(frame, 'linear');
    if (!found) return void (isWaiting ||= frame === latest);
    if (latest && !isLoaded(latest)) return; // it has been let go meanwhile
    const rests = isAtRest && frame === latest;
    tell({ ...found, isAtRest: rests, isJudging: rests, fault: '' });
  }
  /** Takes hyperelastic elements in place of the linear ones. */
  async function judge(linear: Truth): Promise<void> {
    const { frame } = linear;
    let next: Omit<Truth, 'isAtRest'>;
    try {
      const found = await said(frame, 'hyperelastic');
      if (!found) return;
      next = { ...found, isJudging: false, fault: '' };
    } catch (error) {
      if (!(error instanceof Fault)) throw error;
      next = { ...linear, isJudging: false, fault: error.message };
    }
    // The springs may have moved on meanwhile.
    if (truth?.frame === frame) tell({ ...next, isAtRest: truth.isAtRest });
  }
  /** @return null where another question has interrupted it */
  async function said(frame: LiveFrame, elements: Elements) {
    const found = await (frame.needle ? pierced(frame.needle, elements) : pressed(frame, elements));
    return found && { ...found, frame, judge: elements, error: relativeError(frame.displacement, found.displacement, volumes) };
  }
  async function pressed(frame: LiveFrame, elements: Elements) {
    const found = await engine.solve(frame, elements);
    const force = pressedWith(frame);
    return found && { displacement: found.displacement, force, springs: frame.indentation, elements: found.work / force, apart: null };
  }
  async function pierced(needle: NeedleFrame, elements: Elements) {
    const found = await engine.pierce(needle, elements);
    if (!found) return null;
    const apart = length(plus(needle.targetMoved, found.targetMoved, -1));
    return { displacement: found.displacement, force: needle.force, springs: length(needle.targetMoved), elements: length(found.targetMoved), apart };
  }
  /** Asks what there is to be asked: linear elements do not wait for hyperelastic ones, which they interrupt. After a fault nothing more is. */
  function goOn(): void {
    if (isAnswering || isClosed) return;
    const stop = (error: unknown) => void (isClosed || onFault(error));
    if (isWaiting && latest) {
      isWaiting = false;
      isAnswering = true;
      answer(latest).then(() => {
        isAnswering = false;
        goOn();
      }, stop);
    } else if (truth?.isJudging && truth.isAtRest && !isJudging) {
      isJudging = true;
      judge(truth).then(() => {
        isJudging = false;
        goOn();
      }, stop);
    }
  }
  isAnswering = true;
  engine.open(body).then(() => {
    isAnswering = false;
    goOn();
  }, (error) => void (isClosed || onFault(error)));

  return {
    choose: (next) => (wanted = next),
    ask(frame) {
      latest = frame;
      isWaiting = isLoaded(frame);
      if (!isWaiting) {
        truth = null;
        if (isJudging) engine.interrupt();
      }
      goOn();
    },
    rest(rests) {
      if (rests === isAtRest) return;
      isAtRest = rests;
      if (truth && truth.frame === latest && !isWaiting) tell({ ...truth, isAtRest, isJudging: isAtRest && truth.judge === 'linear' && truth.fault === '' });
      else if (truth?.isAtRest) tell({ ...truth, isAtRest: false, isJudging: false });
      goOn();
    },
    close() {
      isClosed = true;
      engine.close();
    },
  };
}
