import { gradient, type Quantity } from '../picture/colour_maps.ts';
import { ticks } from '../picture/scale.ts';
import { element } from './elements.ts';

/** What the colours mean, and by what a value is multiplied to be read in that unit. */
export const scales: Record<Quantity, { name: string; factor: number }> = {
  displacement: { name: 'Displacement [mm]', factor: 1000 },
  error: { name: 'Error of the displacement [mm]', factor: 1000 },
  strain: { name: 'Largest principal Green strain [%]', factor: 100 },
  modulus: { name: 'Young’s modulus [kPa]', factor: 0.001 },
};

/**
 * @param end      value at the end of the strip [m; the strain: 1; the modulus: Pa]
 * @param exceeds  whether there are greater values, which all have the last colour
 */
export function legend(quantity: Quantity, end: number, exceeds: boolean, note: string): Node[] {
  const { name, factor } = scales[quantity];
  const last = factor * end;
  const numbers = ticks(last).map((value) => {
    const isLast = Math.abs(value - last) < 1e-9 * last;
    return element('span', { style: `left: ${(100 * value) / last}%` }, `${isLast && exceeds ? '≥ ' : ''}${value}`);
  });
  return [
    element('div', { class: 'what' }, name),
    element('div', { class: 'strip', style: `background: ${gradient(quantity)}` }),
    element('div', { class: 'numbers', 'data-end-mm': last }, ...numbers),
    ...(note ? [element('p', { class: 'note' }, note)] : []),
  ];
}
