// The needle as controls and readings.
import type { Lesion } from '../../../data/types.ts';
import { byId, element } from '../../../page/elements.ts';
import { tell } from '../../readings.ts';
import type { LiveBody, LiveFrame, Tool } from '../../types.ts';
import { placeOfLesion, straightIn, targetErrors } from './way.ts';
import type { Vector } from '../../vector.ts';

const choice = () => byId<HTMLSelectElement>('live-needle-target');
const millimetres = (metres: number) => `${(1000 * metres).toFixed(1).replace('-', '−')} mm`;
const newtons = (force: number) => `${force.toFixed(2).replace('-', '−')} N`;

/** Offers what is inside a body as a target. */
export function showTargets(lesions: readonly Lesion[]): void {
  choice().replaceChildren(
    element('option', { value: '' }, `Straight in, ${1000 * straightIn} mm`),
    ...lesions.map(({ name }, i) => element('option', { value: i }, name.replaceAll('_', ' '))));
  choice().value = lesions.length > 0 ? '0' : '';
}

/** The target that is chosen; null for straight in. */
export function chosenTarget(body: LiveBody, lesions: readonly Lesion[]): Vector | null {
  const lesion = choice().value === '' ? undefined : lesions[Number(choice().value)];
  return lesion ? placeOfLesion(body, lesion) : null;
}

export const isCapsuleWhole = () => byId<HTMLInputElement>('live-needle-capsule').checked;

/** Shows what belongs to a needle, and nothing of it with other tools. */
export function showNeedleControls(isNeedle: boolean): void {
  byId('live-needle').hidden = byId('live-needle-readings').hidden = byId('live-needle-felt').hidden = !isNeedle;
  byId('live-felt').hidden = !!isNeedle;
  byId('live-radius-name').textContent = isNeedle ? 'Forces spread over' : 'Radius';
  if (!isNeedle) return;
  for (const id of ['force', 'moved', 'tip-force', 'inside', 'left', 'surface']) tell(`live-needle-${id}`, Number.NaN, '–');
}

/** Handle force and target error, and what else there is to read. */
export function showNeedle(tool: Tool, { needle }: LiveFrame): void {
  if (tool.kind !== 'needle' || !needle) return;
  const { moved, left } = targetErrors(tool, needle);
  tell('live-needle-force', needle.force, newtons(needle.force));
  tell('live-needle-moved', moved, millimetres(moved));
  tell('live-needle-tip-force', needle.tipForce, newtons(needle.tipForce));
  tell('live-needle-inside', needle.tip, millimetres(needle.tip));
  tell('live-needle-left', left, millimetres(left));
  tell('live-needle-surface', Number(needle.isPunctured), needle.isPunctured ? 'has given way' : 'whole');
}
