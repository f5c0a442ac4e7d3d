// How many steps to ask an engine for at once, so that an answer comes soon whatever the body.

const soon = 1 / 20; // that an engine may take for one answer [s]
const mostSteps = 10000; // that an engine takes at once
const growth = 4; // of a batch over the largest that was measured

export interface Pacing {
  /** Steps that an engine bears at once: one as long as nobody knows how long it takes, then more and more. */
  bearable(): number;
  /** @param seconds  that so many steps took */
  measure(numSteps: number, seconds: number): void;
  /** Steps take another time from now on. */
  forget(): void;
}

export function createPacing(): Pacing {
  let secondsPerStep = 0;
  let largest = 0; // batch that was measured
  return {
    bearable() {
      if (largest === 0) return 1;
      return Math.max(1, Math.min(mostSteps, growth * largest, Math.floor(soon / secondsPerStep)));
    },
    measure(numSteps, seconds) {
      if (numSteps === 0) return;
      secondsPerStep = seconds / numSteps;
      largest = Math.max(largest, numSteps);
    },
    forget() {
      largest = 0;
    },
  };
}
