// What the colours of the live page may show.
import { nodalStrain, type StrainMesh } from '../data/strain.ts';
import type { Colouring, Quantity } from '../picture/colour_maps.ts';
import { lengths } from '../picture/fields.ts';

export type ShownQuantity = 'displacement' | 'difference' | 'strain';
/** A quantity, or what the body is made of. */
export type Shown = ShownQuantity | 'tissue';
export const allShown: readonly Shown[] = ['tissue', 'displacement', 'strain', 'difference'];

export interface ShownField {
  name: string;
  quantity: Quantity; // whose colours it has
  unit: string;
  inUnit: number; // what one of the unit is in SI
  least: number; // where the colours end at least, in SI
}

export const shownFields: Record<ShownQuantity, ShownField> = {
  displacement: { name: 'Displacement', quantity: 'displacement', unit: 'mm', inUnit: 0.001, least: 0.001 },
  difference: { name: 'Springs beside FEM', quantity: 'error', unit: 'mm', inUnit: 0.001, least: 0.0001 },
  strain: { name: 'Largest principal strain', quantity: 'strain', unit: '%', inUnit: 0.01, least: 0.01 },
};

/** Whose colours it has. */
export const colouringOf = (shown: Shown): Colouring => (shown === 'tissue' ? 'tissue' : shownFields[shown].quantity);

/** @return (N) |a - b| [m] */
export function differences(a: Float32Array, b: Float32Array): Float32Array {
  return lengths(a.map((x, i) => x - b[i]!));
}

/** @param difference  (N), or null where FEM has not answered @return (N) */
export function shownValues(shown: ShownQuantity, displacement: Float32Array, difference: Float32Array | null, mesh: () => StrainMesh): Float32Array {
  if (shown === 'displacement') return lengths(displacement);
  if (shown === 'strain') return nodalStrain(mesh(), displacement);
  return difference ?? new Float32Array(displacement.length / 3).fill(Number.NaN);
}
