// The steps that springs take, in words: how long they are, what decides, and why motion is slower than real time. Values in, values out.
import { short } from '../picture/scale.ts';
import type { Chosen } from './types.ts';

const milliseconds = (seconds: number) => `${short(1000 * seconds)} ms`;

const limits: Record<Chosen['limit'], (chosen: Chosen) => string> = {
  rest: () => 'the body at rest decides',
  pressed: ({ longestTimeStep, pressedTimeStep }) =>
    `a pressed body decides, which bears ${milliseconds(pressedTimeStep)}: while something is pressed a step goes in ${Math.ceil(longestTimeStep / pressedTimeStep - 1e-6)} parts`,
  hand: () => 'the mass between the body and the hand bears no more',
};

/** Factor by which a step is shorter than the longest that is safe. */
const shorterBy = ({ timeStep, longestTimeStep }: Chosen): number => longestTimeStep / timeStep;

/** Whether stiff parts have lighter masses than those of longer steps would have, because of the step that was asked for. */
const mayBeScaled = (chosen: Chosen): boolean => shorterBy(chosen) > 1.05 && chosen.timeStep <= 1.000001 * chosen.unscaledTimeStep && chosen.unscaledTimeStep < 0.95 * chosen.longestTimeStep;

/** How long a step is beside the critical one, and what decides. */
export function stepInWords(chosen: Chosen): string {
  const { timeStep, longestTimeStep, criticalTimeStep } = chosen;
  const part = `A step of ${milliseconds(timeStep)} is ${short(timeStep / criticalTimeStep)} of the critical one at rest, ${milliseconds(criticalTimeStep)}`;
  if (mayBeScaled(chosen)) return `${part}. With scaled masses of stiff tumours it may be ${milliseconds(longestTimeStep)}.`;
  if (shorterBy(chosen) > 1.000001) return `${part}. It may be ${milliseconds(longestTimeStep)}.`;
  return `${part}: ${limits[chosen.limit](chosen)}.`;
}

/** What a slow motion is explained by. */
export interface Circumstances {
  chosen: Chosen;
  numTetrahedra: number;
  hasNeedle: boolean;
  isOfGlass: boolean; // which takes longer to draw
  mayBeNative: boolean; // and is not
}

/** Things that make motion faster: a button each. */
export type Remedy = 'native' | 'longest' | 'opaque';

export interface Slowness {
  why: string;
  remedies: Remedy[];
}

/**
 * @param solving  seconds that steps took for a second of motion
 * @param parts    of a step in the mean, because some were divided
 * @param isDrawn  whether something else than steps takes the time
 */
export function whySlow({ chosen, numTetrahedra, hasNeedle, isOfGlass, mayBeNative }: Circumstances, solving: number, parts: number, isDrawn: boolean): Slowness {
  if (isDrawn) return { why: 'drawing takes the time', remedies: isOfGlass ? ['opaque'] : [] };
  const native: Remedy[] = mayBeNative ? ['native'] : [];
  const times = (factor: number) => `${Number(factor.toPrecision(2))} times the steps`;
  // Steps that are much shorter than tumours need are short because somebody asked for it.
  const isAsNeeded = chosen.timeStep > chosen.unscaledTimeStep / 1.5;
  if (mayBeScaled(chosen) && isAsNeeded) return { why: `stiff tumours need ${times(shorterBy(chosen))} while their masses are not scaled`, remedies: ['longest', ...native] };
  if (shorterBy(chosen) > 1.05) return { why: `steps of ${milliseconds(chosen.timeStep)} are ${times(shorterBy(chosen))} that are needed`, remedies: ['longest', ...native] };
  const unscaled = chosen.longestTimeStep / chosen.unscaledTimeStep;
  if (hasNeedle && unscaled > 1.05) return { why: `stiff tumours need ${times(Math.ceil(unscaled))} while a needle is in`, remedies: native };
  const divided = parts > 1.05 ? `, divided into ${parts.toFixed(1)} parts where it is pressed,` : '';
  const each = `each of its ${Math.round(1 / chosen.timeStep)} steps${divided} takes ${short(1000 * solving * chosen.timeStep)} ms for ${numTetrahedra} tetrahedra`;
  return { why: each, remedies: native };
}
