// Where the body that moves is cut open.
import type { Result } from '../data/types.ts';
import { byId } from '../page/elements.ts';
import { extentOf } from '../page/state.ts';
import { short } from '../picture/scale.ts';
import type { Cut } from '../picture/section.ts';
import { tell } from './readings.ts';

const select = () => byId<HTMLSelectElement>('live-cut');
const slider = () => byId<HTMLInputElement>('live-cut-place');

/** What the controls say; null for a whole body. */
export function cutOf(result: Result): Cut | null {
  const axis = Number(select().value || -1);
  byId('live-cut-row').hidden = axis < 0;
  if (axis !== 0 && axis !== 1 && axis !== 2) return null;
  const [low, high] = extentOf(result, axis);
  const place = low + ((high - low) * slider().valueAsNumber) / 100;
  tell('live-cut-at', place, `${'xyz'[axis]} = ${short(1000 * place)} mm`);
  // Seen from the front, a cut across y takes the front away.
  return { axis, place, keepsAbove: axis === 1 };
}

/** @param axis  of the control; empty for a whole body @param place  per cent of the extent */
export function setCutControls(axis: string, place: number): void {
  select().value = axis;
  slider().value = String(place);
  byId('live-cut-row').hidden = axis === '';
}

export const cutControls = () => ({ cutAxis: select().value, cutPlace: slider().valueAsNumber });

export function listenToLiveCut(change: () => void): void {
  select().addEventListener('change', change);
  slider().addEventListener('input', change);
}
