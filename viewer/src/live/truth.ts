// What finite elements say to the forces that the springs are under: one question under way, always about the latest frame.
import { nodalVolumes } from '../data/nodal_volumes.ts';
import type { LiveBody, LiveFrame, LiveSettings, TruthEngine } from './types.ts';

export interface Truth {
  displacement: Float32Array; // of finite elements, (N,3) [m]
  asked: Float32Array; // of the springs under these forces, (N,3) [m]
  springs: number; // indentation [m]
  elements: number; // the same forces over the displacements of finite elements [m]
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

/** sum of f_i . u_i / |sum of f_i| [m] */
export function indentation({ loadedNodes, nodalForces }: LiveFrame, displacement: Float32Array): number {
  let work = 0;
  const sum = [0, 0, 0];
  loadedNodes.forEach((node, k) => {
    for (let i = 0; i < 3; i++) {
      work += nodalForces[3 * k + i]! * displacement[3 * node + i]!;
      sum[i]! += nodalForces[3 * k + i]!;
    }
  });
  const force = Math.hypot(...sum);
  return force > 0 ? work / force : 0;
}

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
    const displacement = await engine.solve(frame.loadedFacets, frame.tractions);
    if (isClosed) return;
    onTruth({
      displacement,
      asked: frame.displacement,
      springs: frame.indentation,
      elements: indentation(frame, displacement),
      error: relativeError(frame.displacement, displacement, volumes),
      isAtRest,
    });
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
    else if (frame.loadedFacets.length > 0) whenDone(answer(frame, isSlow(frame, before)));
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
