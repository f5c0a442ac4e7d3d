// What the tubes in a picture are.
import type { Result } from '../data/types.ts';
import { lengthOf } from '../data/vessels.ts';
import { cssOf } from '../picture/patch_colours.ts';
import { vesselColour } from '../picture/vessel_colour.ts';
import { element } from './elements.ts';

const rounded = (value: number, digits: number) => Number(value.toPrecision(digits));

/** 5.5 m as lines, with radii of 1.2 to 5.3 mm; nothing of a body without. */
export function vesselsInWords({ vessels }: Pick<Result, 'vessels'>): string {
  if (!vessels) return '';
  const ends = [vessels.radius.reduce((a, b) => Math.min(a, b)), vessels.radius.reduce((a, b) => Math.max(a, b))];
  return `${rounded(lengthOf(vessels), 3)} m as lines, with radii of ${[...new Set(ends.map((r) => rounded(1000 * r, 2)))].join(' to ')} mm`;
}

/** An entry of the key. @param isInSight  whether they are seen through the surface or in a cut */
export function vesselsKey(result: Result, isInSight: boolean): Node[] {
  const words = vesselsInWords(result);
  if (!words) return [];
  return [element('li', { class: 'vessels' }, element('span', { class: 'swatch vessels', style: `--colour: ${cssOf(vesselColour)}`, 'aria-hidden': 'true' }),
    `Vessels: ${words}${isInSight ? '' : '; seen in glass, or cut open'}`)];
}
