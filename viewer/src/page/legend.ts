import { gradient, type Quantity } from '../picture/colour_maps.ts';
import { ticks } from '../picture/scale.ts';
import { element } from './elements.ts';

const names: Record<Quantity, string> = { displacement: 'Displacement [mm]', error: 'Error of the displacement [mm]' };

/**
 * @param end      value at the end of the strip [m]
 * @param exceeds  whether there are greater values, which all have the last colour
 */
export function legend(quantity: Quantity, end: number, exceeds: boolean, note: string): Node[] {
  const millimetres = 1000 * end;
  const numbers = ticks(millimetres).map((value) => {
    const isLast = Math.abs(value - millimetres) < 1e-9 * millimetres;
    return element('span', { style: `left: ${(100 * value) / millimetres}%` }, `${isLast && exceeds ? '≥ ' : ''}${value}`);
  });
  return [
    element('div', { class: 'what' }, names[quantity]),
    element('div', { class: 'strip', style: `background: ${gradient(quantity)}` }),
    element('div', { class: 'numbers', 'data-end-mm': millimetres }, ...numbers),
    ...(note ? [element('p', { class: 'note' }, note)] : []),
  ];
}
