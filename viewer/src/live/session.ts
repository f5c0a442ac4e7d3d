// Moves the body in real time: one request under way, and what a frame of the screen leaves over is done in the next.
import type { Chosen, Engine, LiveFrame, LiveSettings, Tool } from './types.ts';

/** What an answer took [s]. */
export interface Timing {
  simulated: number;
  elapsed: number; // since the answer before
  solver: number;
  transfer: number; // there and back
}

export interface Listener {
  /** What the hand does, so many seconds after it was asked last. */
  tool(elapsed: number): Tool;
  moved(tool: Tool, numSteps: number, frame: LiveFrame, timing: Timing): void;
  chosen(settings: LiveSettings, chosen: Chosen): void;
  wasReset(): void;
  /** The settings that stay, if the fault is about others. */
  failed(error: unknown, settings: LiveSettings | null): void;
  paused(isPaused: boolean): void;
}

export interface Session {
  choose(settings: LiveSettings): void;
  reset(): void;
  pause(isPaused: boolean): void;
  /** One step of a body that pauses. */
  step(): void;
  close(): void;
}

/** More is not made up for: a page that was hidden goes on from where it was. [s] */
const longestFrame = 1 / 20;
const shortestFrame = 1 / 60; // [s]
const mostSteps = 10000; // that an engine takes at once

const nextFrame = () => new Promise<number>((resolve) => requestAnimationFrame(resolve));

/** @param engine  that has opened a body; the session closes it */
export function startSession(engine: Engine, settings: LiveSettings, listener: Listener): Session {
  let wanted = settings;
  let current: LiveSettings | null = null;
  let refused: LiveSettings | null = null;
  let timeStep = 0;
  let secondsPerStep = 0; // that the engine needs
  let debt = 0; // of the motion behind the clock [s]
  let isPaused = false;
  let isResetting = false;
  let isClosed = false;
  let numSingle = 0; // steps that were asked for one by one

  function pause(pauses: boolean): void {
    isPaused = pauses;
    debt = 0;
    listener.paused(pauses);
  }

  async function choose(): Promise<void> {
    const asked = wanted;
    try {
      const chosen = await engine.choose(asked);
      current = asked;
      timeStep = chosen.timeStep;
      if (!isClosed) listener.chosen(asked, chosen);
    } catch (error) {
      if (wanted === asked && current) wanted = current;
      refused = asked;
      if (!isClosed) listener.failed(error, current);
    }
  }

  async function move(numSteps: number, handTime: number, elapsed: number): Promise<void> {
    const tool = listener.tool(handTime);
    const start = performance.now();
    const frame = await engine.move(tool, numSteps);
    const there = (performance.now() - start) / 1000;
    if (numSteps > 0) secondsPerStep = frame.stepSeconds / numSteps;
    const timing = { simulated: numSteps * timeStep, elapsed, solver: frame.stepSeconds, transfer: Math.max(there - frame.stepSeconds, 0) };
    if (!isClosed) listener.moved(tool, numSteps, frame, timing);
  }

  async function reset(): Promise<void> {
    isResetting = false;
    await engine.reset();
    if (!isClosed) listener.wasReset();
    // The body at rest, to be drawn.
    await move(0, 0, 0);
  }

  /** @param elapsed  since the turn before [s] */
  async function turn(elapsed: number): Promise<void> {
    if (wanted !== current && wanted !== refused) return choose();
    if (!current) return;
    if (isResetting) return reset();
    if (isPaused) {
      if (numSingle > 0) await move(numSingle, numSingle * timeStep, 0);
      numSingle = 0;
      return;
    }
    debt = Math.min(debt + elapsed, longestFrame);
    // An engine that is slower than the clock gets less at once, so that the hand is answered soon.
    const bearable = Math.max(1, Math.min(mostSteps, Math.floor(longestFrame / secondsPerStep)));
    const numSteps = Math.min(Math.floor(debt / timeStep + 1e-9), bearable);
    if (numSteps === 0) return;
    debt -= numSteps * timeStep;
    await move(numSteps, numSteps * timeStep, elapsed);
  }

  async function run(): Promise<void> {
    let last = await nextFrame();
    let took = 0; // [s]
    while (!isClosed) {
      // An engine that needs longer than a frame of the screen does not wait for the next one as well.
      const now = took > shortestFrame && !document.hidden ? performance.now() : await nextFrame();
      try {
        await turn((now - last) / 1000);
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
    choose: (next) => (wanted = next),
    reset: () => (isResetting = true),
    pause,
    step: () => numSingle++,
    close() {
      isClosed = true;
      engine.close();
    },
  };
}
