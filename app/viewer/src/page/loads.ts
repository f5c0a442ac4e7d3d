// Which part of the load is shown, in numbers and words.
import { courseOf, type Model, type Moment, type PointErrors, type Result } from '../data/types.ts';
import { short } from '../picture/scale.ts';

/** Loads are applied in parts of all that the load case prescribes. */
export const loadOf = (result: Result, moment: Moment) => (courseOf(moment) === 'path' ? result.loads[moment.point!]! : 1);

const inPercent = (part: number) => `${Number((100 * part).toPrecision(3))} %`;

/** 60 % of the load; nothing where the whole of it is meant or the body moves freely. */
export const loadName = (result: Result, moment: Moment) => (courseOf(moment) === 'path' ? `${inPercent(loadOf(result, moment))} of the load` : '');

/** For the slider: 60 %: 9.00 of 15.0 mm. */
export function loadText(result: Result, moment: Moment): string {
  const part = loadOf(result, moment);
  const way = Math.max(0, ...result.places.map((place) => Math.hypot(...place.way)));
  return way > 0 ? `${inPercent(part)}: ${short(1000 * part * way)} of ${short(1000 * way)} mm` : `${inPercent(part)} of the load`;
}

/** What a model that did not come to the point says of itself. */
export function endOfPath({ loads }: Result, { numPoints }: Model, moment: Moment): string {
  if (courseOf(moment) !== 'path' || numPoints > moment.point!) return '';
  return numPoints > 0 ? `Its path ends at ${inPercent(loads[numPoints - 1]!)} of the load` : 'No path of loads';
}

const unknown = { motionError: Number.NaN, motionLag: Number.NaN, motionReference: '' };

/** The result as it is at a point of the path; nobody looked how good the reference is there. */
export function atPoint(result: Result, moment: Moment, errors: PointErrors[]): Result {
  if (courseOf(moment) !== 'path') return result;
  const models = result.models.map((model) => {
    const found = errors.find((e) => e.model === model.name);
    return { ...model, comparison: found ? { ...unknown, ...model.comparison, ...found, reference: result.reference } : null };
  });
  return { ...result, models, referenceUncertainty: Number.NaN };
}
