// Where the body is cut open.
import type { Result } from '../data/types.ts';
import { short } from '../picture/scale.ts';
import { byId } from './elements.ts';
import { extentOf, type Choice } from './state.ts';

const numSteps = 200; // of the slider
type Axis = 0 | 1 | 2;
const axisOf = (value: string) => ['x', 'y', 'z'].indexOf(value) as Axis | -1;
const select = () => byId<HTMLSelectElement>('cut_axis');
const slider = () => byId<HTMLInputElement>('cut_place');
const other = () => byId<HTMLInputElement>('cut_other');

/** Seen from the front, a cut across y takes the front away, and one across z the top. */
const keepsAboveFirst = (axis: Axis) => axis === 1;

export function listenToCut(result: () => Result | null, choice: () => Choice | null, change: (part: Partial<Choice>) => void): void {
  const listen = (how: () => Partial<Choice> | null) => () => {
    const part = result() && choice() ? how() : null;
    if (part) change(part);
  };
  select().addEventListener('change', listen(() => {
    const axis = axisOf(select().value);
    if (axis < 0) return { cut: null };
    const [low, high] = extentOf(result()!, axis);
    return { cut: { axis: axis as Axis, place: (low + high) / 2, keepsAbove: keepsAboveFirst(axis as Axis) } };
  }));
  slider().addEventListener('input', listen(() => {
    const { cut } = choice()!;
    if (!cut) return null;
    const [low, high] = extentOf(result()!, cut.axis);
    return { cut: { ...cut, place: low + ((high - low) * slider().valueAsNumber) / numSteps } };
  }));
  other().addEventListener('change', listen(() => {
    const { cut } = choice()!;
    return cut && { cut: { ...cut, keepsAbove: keepsAboveFirst(cut.axis) !== other().checked } };
  }));
}

export function showCut(result: Result, { cut }: Choice): void {
  const names = result.isAnatomical ? ['Left and right (x)', 'Front and back (y)', 'Head and feet (z)'] : ['Across x', 'Across y', 'Across z'];
  names.forEach((name, axis) => (select().options[axis + 1]!.textContent = name));
  select().value = cut ? 'xyz'[cut.axis]! : '';
  byId('cut_row').hidden = cut === null;
  if (!cut) return;
  const [low, high] = extentOf(result, cut.axis);
  slider().max = String(numSteps);
  slider().value = String(Math.round((numSteps * (cut.place - low)) / (high - low)));
  const words = `${'xyz'[cut.axis]} = ${short(1000 * cut.place)} mm`;
  byId('cut_at').textContent = words;
  slider().setAttribute('aria-valuetext', words);
  other().checked = cut.keepsAbove !== keepsAboveFirst(cut.axis);
}
