// Where the colours end: it follows what is there now, or stays where the reader has put it.
import { roundedUp } from '../picture/scale.ts';

const fading = 0.5; // in which what was there loses its say [s]
const wellUsed = 0.6; // part of the colours; below it they end earlier

export interface ColourRange {
  end(): number;
  follows(): boolean;
  /** Stays, where it is or at another end. */
  fix(end?: number): void;
  follow(): void;
  /** @param now  [s] @return whether the end is another one */
  see(largest: number, now: number): boolean;
}

/**
 * @param unit   what numbers are rounded in, as 0.001 for millimetres in metres
 * @param least  where it ends at least
 */
export function createColourRange(unit: number, least: number): ColourRange {
  let end = least;
  let follows = true;
  let lately = 0; // the largest value, which fades
  let seenAt = -Infinity; // [s]
  return {
    end: () => end,
    follows: () => follows,
    fix(chosen = end) {
      end = chosen;
      follows = false;
    },
    follow() {
      follows = true;
    },
    see(largest, now) {
      if (!(largest < Infinity)) return false;
      lately = Math.max(largest, lately * Math.exp(Math.min(seenAt - now, 0) / fading));
      seenAt = now;
      if (!follows || (lately <= end && (lately >= wellUsed * end || end === least))) return false;
      const before = end;
      end = Math.max(least, unit * roundedUp(lately / unit));
      return end !== before;
    },
  };
}
