// Moves the body in real time: one request under way, and what a frame of the screen leaves over is done in the next.
// At rest, or while it pauses, it sleeps: it does nothing until it is woken.
import { createPacing } from './pacing.ts';
import { createRest } from './rest.ts';
import type { CutAnswer, CutRequest } from './tool/blade/types.ts';
import type { Chosen, Engine, LiveFrame, LiveSettings, Tool } from './types.ts';

/** What an answer took [s]. */
export interface Timing {
  simulated: number;
  elapsed: number; // since the answer before
  solver: number;
  transfer: number; // there and back
  numSteps: number;
  numEvaluations: number; // of forces
}

export interface Listener {
  /** What the tool does, so many seconds after it was asked last. */
  tool(elapsed: number): Tool;
  moved(tool: Tool, numSteps: number, frame: LiveFrame, timing: Timing): void;
  chosen(settings: LiveSettings, chosen: Chosen): void;
  wasReset(): void;
  wasKept(): void;
  /** It is where it was kept last. */
  wasRestored(): void;
  /** What it was before is kept. */
  wasCut(request: CutRequest, answer: CutAnswer): void;
  /** A cut was refused, and nothing has changed. */
  notCut(error: unknown): void;
  /** The settings that stay, if the fault is about others. */
  failed(error: unknown, settings: LiveSettings | null): void;
  paused(isPaused: boolean): void;
  /** @param isAsleep  nothing is asked of the engine, and nothing is under way @param isAtRest  and nothing moves */
  slept(isAsleep: boolean, isAtRest: boolean): void;
}

export interface Session {
  choose(settings: LiveSettings): void;
  reset(): void;
  /** Keeps the state of now, before anything else is asked of the engine. */
  keep(): void;
  restore(): void;
  cut(request: CutRequest): void;
  pause(isPaused: boolean): void;
  /** One step of a body that pauses. */
  step(): void;
  /** The tool does something else. */
  wake(): void;
  close(): void;
}

/** More is not made up for: a page that was hidden goes on from where it was. [s] */
const longestFrame = 1 / 20;
const shortestFrame = 1 / 60; // [s]

const nextFrame = () => new Promise<number>((resolve) => requestAnimationFrame(resolve));

/**
 * @param engine  that has opened a body; the session closes it
 * @param size    of the body [m]
 */
export function startSession(engine: Engine, size: number, settings: LiveSettings, listener: Listener): Session {
  const pacing = createPacing();
  const rest = createRest(size);
  const tasks: (() => Promise<void>)[] = []; // beside moving, in order
  let wanted = settings;
  let current: LiveSettings | null = null;
  let refused: LiveSettings | null = null;
  let timeStep = 0; // of what was chosen
  let debt = 0; // of the motion behind the clock [s]
  let isPaused = false;
  let isClosed = false;
  let numSingle = 0; // steps that were asked for one by one
  let wakeUp: (() => void) | null = null; // while it sleeps

  function wake(): void {
    rest.disturb();
    wakeUp?.();
  }

  function pause(pauses: boolean): void {
    isPaused = pauses;
    debt = 0;
    listener.paused(pauses);
    wakeUp?.(); // a body at rest stays there
  }

  async function choose(): Promise<void> {
    const asked = wanted;
    try {
      const chosen = await engine.choose(asked);
      current = asked;
      timeStep = chosen.timeStep;
      pacing.forget();
      rest.disturb();
      if (!isClosed) listener.chosen(asked, chosen);
    } catch (error) {
      if (wanted === asked && current) wanted = current;
      refused = asked;
      if (!isClosed) listener.failed(error, current);
    }
  }

  async function move(numSteps: number, toolTime: number, elapsed: number): Promise<void> {
    const tool = listener.tool(toolTime);
    const start = performance.now();
    const frame = await engine.move(tool, numSteps);
    const there = (performance.now() - start) / 1000;
    pacing.measure(numSteps, frame.stepSeconds);
    rest.see(frame, tool);
    const timing = { simulated: numSteps * timeStep, elapsed, solver: frame.stepSeconds, transfer: Math.max(there - frame.stepSeconds, 0), numSteps, numEvaluations: frame.numEvaluations };
    if (!isClosed) listener.moved(tool, numSteps, frame, timing);
  }

  /** Does something to the state, and has it drawn. */
  function change(act: () => Promise<void>, tell: () => void): void {
    tasks.push(async () => {
      await act();
      if (isClosed) return;
      tell();
      await move(0, 0, 0);
    });
    wake();
  }

  /** @param elapsed  since the turn before [s] */
  async function turn(elapsed: number): Promise<void> {
    if (wanted !== current && wanted !== refused) return choose();
    if (!current) return;
    const task = tasks.shift();
    if (task) return task();
    if (isPaused) {
      if (numSingle > 0) await move(numSingle, numSingle * timeStep, 0);
      numSingle = 0;
      return;
    }
    debt = Math.min(debt + elapsed, longestFrame);
    // An engine that is slower than the clock gets less at once, so that a tool has its force soon.
    const numSteps = Math.min(Math.floor(debt / timeStep + 1e-9), pacing.bearable());
    if (numSteps === 0) return;
    debt -= numSteps * timeStep;
    await move(numSteps, numSteps * timeStep, elapsed);
  }

  const hasNothingToDo = () =>
    (wanted === current || wanted === refused) && tasks.length === 0 && numSingle === 0 && (isPaused || !current || rest.isReached());

  /** Until it is woken. @return when that was [ms] */
  async function sleep(): Promise<number> {
    listener.slept(true, rest.isReached());
    await new Promise<void>((resolve) => (wakeUp = resolve));
    wakeUp = null;
    debt = 0;
    if (!isClosed) listener.slept(false, false);
    return performance.now();
  }

  async function run(): Promise<void> {
    let last = await nextFrame();
    let took = 0; // [s]
    while (!isClosed) {
      if (hasNothingToDo()) last = await sleep();
      // An engine that needs longer than a frame of the screen does not wait for the next one as well.
      const now = took > shortestFrame && !document.hidden ? performance.now() : await nextFrame();
      try {
        if (!isClosed) await turn(Math.max(now - last, 0) / 1000);
      } catch (error) {
        // The same would come again in each frame.
        if (!isClosed) {
          pause(true);
          listener.failed(error, null);
        }
      }
      last = now;
      took = (performance.now() - now) / 1000;
    }
  }
  void run();

  return {
    choose(next) {
      wanted = next;
      wake();
    },
    reset: () => change(() => engine.reset(), listener.wasReset),
    keep() {
      tasks.push(async () => {
        await engine.keep();
        if (!isClosed) listener.wasKept();
      });
      wake();
    },
    restore: () => change(() => engine.restore(), listener.wasRestored),
    cut(request) {
      tasks.push(async () => {
        let answer: CutAnswer;
        try {
          answer = await engine.cut(request);
        } catch (error) {
          if (!isClosed) listener.notCut(error);
          return;
        }
        pacing.forget();
        if (isClosed) return;
        listener.wasCut(request, answer);
        await move(0, 0, 0);
      });
      wake();
    },
    pause,
    step() {
      numSingle++;
      wake();
    },
    wake,
    close() {
      isClosed = true;
      engine.close();
      wake();
    },
  };
}
