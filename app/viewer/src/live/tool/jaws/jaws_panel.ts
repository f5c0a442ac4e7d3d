// What is read of a grasp, and what of it other readings take.
import { byId } from '../../../page/elements.ts';
import { tell } from '../../readings.ts';
import type { LiveFrame } from '../../types.ts';
import { length, plus } from '../../vector.ts';

const newtons = (force: number) => `${force.toFixed(2).replace('-', '−')} N`;
const millimetres = (metres: number) => `${(1000 * metres).toFixed(2).replace('-', '−')} mm`;

/** Shows what belongs to a grasp, and nothing of it with other tools. */
export function showGraspReadings(isGrasp: boolean): void {
  if (byId('live-grasp-felt').hidden !== isGrasp) return;
  byId('live-grasp-felt').hidden = byId('live-grasp-readings').hidden = !isGrasp;
  for (const id of ['closing', 'hand', 'depth']) tell(`live-grasp-${id}`, Number.NaN, '–');
}

export function showGrasp({ grasp, force }: LiveFrame): void {
  if (byId('live-grasp-felt').hidden) return;
  tell('live-grasp-closing', grasp?.closing ?? 0, newtons(grasp?.closing ?? 0));
  tell('live-grasp-hand', length(force), newtons(length(force)));
  tell('live-grasp-depth', grasp?.depth ?? Number.NaN, grasp ? millimetres(grasp.depth) : '–');
}

/** Size of what the tool exerts [N]: of two jaws the sum of both. */
export function pressedWith({ force, grasp }: Pick<LiveFrame, 'force' | 'grasp'>): number {
  return grasp ? length(plus(force, grasp.otherForce, -1)) + length(grasp.otherForce) : length(force);
}
