// What finite elements say to the tractions or the needle that the springs are under: one question under way, always about the latest frame.
// Linear elements follow the tool. Where they are off themselves, hyperelastic ones judge the springs once these are at rest.
import { nodalVolumes } from '../data/nodal_volumes.ts';
import { Fault } from '../data/types.ts';
import { millimetres } from '../picture/scale.ts';
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
  fault: string; // why hyperelastic elements do not judge where they should; empty otherwise
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

/** Indentation over the radius of the tool at which linear elements are off by 2 to 3 % themselves, and by more below (docs/studies/live.md). */
const deep = 0.1;

/** Whether linear elements are too far off to judge springs under this load. A needle spreads what it does over its way, and they judge it. */
export const isDeep = ({ needle, indentation, radius }: Pick<LiveFrame, 'needle' | 'indentation' | 'radius'>): boolean => !needle && Math.abs(indentation) > deep * radius;

/** What a hand would say of the springs at rest, or where they have the target, and what they are compared with, in one sentence or two. */
export function inWords(truth: Pick<Truth, 'springs' | 'elements' | 'apart' | 'isAtRest' | 'isJudging' | 'judge' | 'fault'> & { frame: Parameters<typeof isDeep>[0] }): string {
  if (!truth.isAtRest) return 'Still moving: the springs are compared with FEM when they are at rest.';
  if (truth.apart !== null) return `The springs have the target ${(1000 * truth.apart).toFixed(2)} mm from where linear FEM has it.`;
  const off = stiffnessRatio(truth) - 1;
  if (!Number.isFinite(off)) return '';
  const isOff = truth.judge === 'linear' && isDeep(truth.frame);
  const depth = `Deeper than ${millimetres(deep * truth.frame.radius)} mm linear elements are themselves off by more than 3 %`;
  if (isOff && truth.isJudging) return `${depth}: hyperelastic ones are being asked.`;
  const amount = Math.round(100 * Math.abs(off));
  const how = amount === 0 ? `as stiff as ${truth.judge} FEM here` : `${amount} % too ${off < 0 ? 'soft' : 'stiff'} here beside ${truth.judge} FEM`;
  return `The springs are ${how}; a hand feels ${Math.round(100 * noticeable)} %.${isOff ? ` ${depth}${truth.fault ? `, and hyperelastic ones do not judge: ${truth.fault}.` : '.'}` : ''}`;
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
  let isBusy = false;
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
    const found = frame.needle ? await pierced(frame.needle) : await pressed(frame, 'linear');
    if (latest && !isLoaded(latest)) return; // it has been let go meanwhile
    const rests = isAtRest && frame === latest;
    tell({ ...found, ...judged(frame, found.displacement, 'linear'), isAtRest: rests, isJudging: rests && isDeep(frame), fault: '' });
  }
  /** Takes hyperelastic elements in place of the linear ones. */
  async function judge(linear: Truth): Promise<void> {
    const { frame } = linear;
    let next: Truth;
    try {
      const found = await pressed(frame, 'hyperelastic');
      next = { ...linear, ...found, ...judged(frame, found.displacement, 'hyperelastic'), isJudging: false };
    } catch (error) {
      if (!(error instanceof Fault)) throw error;
      next = { ...linear, isJudging: false, fault: error.message };
    }
    // The springs may have moved on meanwhile.
    if (truth?.frame === frame) tell({ ...next, isAtRest: truth.isAtRest });
  }
  const judged = (frame: LiveFrame, displacement: Float32Array, by: Elements) =>
    ({ frame, judge: by, error: relativeError(frame.displacement, displacement, volumes) });
  async function pressed(frame: LiveFrame, elements: Elements) {
    const { displacement, work } = await engine.solve(frame, elements);
    const force = pressedWith(frame);
    return { displacement, force, springs: frame.indentation, elements: work / force, apart: null };
  }
  async function pierced(needle: NeedleFrame) {
    const { displacement, targetMoved } = await engine.pierce(needle);
    const apart = length(plus(needle.targetMoved, targetMoved, -1));
    return { displacement, force: needle.force, springs: length(needle.targetMoved), elements: length(targetMoved), apart };
  }
  /** Asks what there is to be asked, one after the other. After a fault nothing more is. */
  function goOn(): void {
    if (isBusy || isClosed) return;
    const work = next();
    if (!work) return;
    isBusy = true;
    const done = () => {
      isBusy = false;
      goOn();
    };
    work.then(done, (error) => void (isClosed || onFault(error)));
  }
  function next(): Promise<void> | null {
    if (isWaiting && latest) {
      isWaiting = false;
      return answer(latest);
    }
    return truth?.isJudging && truth.isAtRest ? judge(truth) : null;
  }
  isBusy = true;
  engine.open(body).then(() => {
    isBusy = false;
    goOn();
  }, (error) => void (isClosed || onFault(error)));

  return {
    choose: (next) => (wanted = next),
    ask(frame) {
      latest = frame;
      isWaiting = isLoaded(frame);
      if (!isWaiting) truth = null;
      goOn();
    },
    rest(rests) {
      if (rests === isAtRest) return;
      isAtRest = rests;
      if (truth && truth.frame === latest && !isWaiting) tell({ ...truth, isAtRest, isJudging: isAtRest && truth.judge === 'linear' && truth.fault === '' && isDeep(truth.frame) });
      else if (truth?.isAtRest) tell({ ...truth, isAtRest: false, isJudging: false });
      goOn();
    },
    close() {
      isClosed = true;
      engine.close();
    },
  };
}
