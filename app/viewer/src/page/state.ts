// What the reader has chosen, and what follows from it.
import type { Course, Field, Frame, Largest, Result } from '../data/types.ts';
import type { BodyParts, Skin } from '../picture/body.ts';
import type { Colouring, SolvedQuantity } from '../picture/colour_maps.ts';
import { exaggerations, lengths } from '../picture/fields.ts';
import { roundedUp } from '../picture/scale.ts';
import { patchLabels } from './patch_legend.ts';
import { defaultSkin } from '../picture/materials.ts';
import type { Cut } from '../picture/section.ts';

export interface Choice {
  models: [left: string, right: string];
  quantity: Colouring;
  skin: Skin;
  exaggeration: number; // index into exaggerations
  frame: Frame;
  point: number | null; // of the path of loads; null for the whole load
  node: number | null;
  cut: Cut | null;
  showsConditions: boolean;
  showsNames: boolean; // of lesions
  showsVessels: boolean; // that are lines
}

/** What a stage draws of a file besides the surface. */
export function partsOf(result: Result): BodyParts {
  const labels = result.lesions.map(({ name, node, reach }) => ({ name: name.replaceAll('_', ' '), node, reach }));
  return { conditions: result.conditions, patches: result.patches, tetrahedra: result.tetrahedra, labels, surfaceLabels: patchLabels(result), vessels: result.vessels, isAnatomical: result.isAnatomical };
}

/** Between these a body lies along an axis, at rest. [m] */
export function extentOf(result: Result, axis: number): [low: number, high: number] {
  let [low, high] = [Infinity, -Infinity];
  for (let i = axis; i < result.points.length; i += 3) {
    low = Math.min(low, result.points[i]!);
    high = Math.max(high, result.points[i]!);
  }
  return [low, high];
}

/** Names of the models that can be shown: in motion those that move, at a part of the load those with a path. */
export function shownModels(result: Result, course: Course): string[] {
  const canShow = { load: () => true, motion: (m: Result['models'][number]) => m.moves, path: (m: Result['models'][number]) => m.numPoints > 0 };
  return result.models.filter(canShow[course]).map((model) => model.name);
}

/** What errors are measured by: motion may have another reference than the static answer. */
export function referenceOf(result: Result, isMoving: boolean): string {
  return isMoving && result.motionReference ? result.motionReference : result.reference;
}

/** Of those, the springs that are nearest to the reference: what a reader has come to see. */
function nearestSprings(result: Result, names: string[]): string | undefined {
  const errorOf = (name: string) => {
    const model = result.models.find((m) => m.name === name);
    const error = model?.status === 'ok' ? model.comparison?.relativeL2 : undefined;
    return error !== undefined && Number.isFinite(error) ? error : Infinity;
  };
  return names.filter((name) => !name.startsWith('fem_')).sort((a, b) => errorOf(a) - errorOf(b) || 0)[0];
}

/** Keeps what was chosen where it can be shown; else the reference, and beside it the nearest springs. */
export function validModels(result: Result, course: Course, wanted: [string, string]): [string, string] {
  const known = shownModels(result, course);
  const reference = referenceOf(result, course === 'motion');
  const wasReference = wanted[0] === result.reference || wanted[0] === result.motionReference;
  const left = known.includes(wanted[0]) && !wasReference ? wanted[0] : known.includes(reference) ? reference : known[0]!;
  const others = known.filter((name) => name !== left);
  const right = known.includes(wanted[1]) ? wanted[1] : (nearestSprings(result, others) ?? others[0] ?? left);
  return [left, right];
}

/** The choice at a point of the path of loads, of which the last one is the whole load. */
export function atLoad(result: Result, choice: Choice, chosen: number): Partial<Choice> {
  const point = chosen < result.loads.length - 1 ? chosen : null;
  return { frame: null, point, models: validModels(result, point === null ? 'load' : 'path', choice.models) };
}

/** What a file can be coloured by: what was wanted, if it has that. */
export const validQuantity = (result: Result, wanted: Colouring): Colouring => (wanted === 'modulus' && !result.modulus ? 'displacement' : wanted);

/** What is shown of a body that nobody has chosen anything for: a liver looks like one, and one sees through it. */
export const firstLook = ({ isAnatomical }: Result): Pick<Choice, 'quantity' | 'skin'> =>
  isAnatomical ? { quantity: 'tissue', skin: 'translucent' } : { quantity: 'displacement', skin: defaultSkin };

/** Tissue is seen in glass, and numbers in exact colours, unless the reader has chosen something else. */
export function lookOf(quantity: Colouring, { quantity: before, skin }: Pick<Choice, 'quantity' | 'skin'>): Partial<Choice> {
  if (quantity === 'tissue' && skin === defaultSkin) return { quantity, skin: 'translucent' };
  if (before === 'tissue' && skin === 'translucent') return { quantity, skin: defaultSkin };
  return { quantity };
}

/** What is coloured [m, or 1 for the strain]; a patch is no number. What errors are measured from has none, nor has a model that nobody compared. */
export function colouredValues(field: Field, quantity: SolvedQuantity | 'patches' | 'tissue'): Float32Array {
  const none = () => new Float32Array(field.displacement.length / 3).fill(Number.NaN);
  if (quantity === 'patches' || quantity === 'tissue') return none();
  if (quantity === 'strain') return field.strain ?? none();
  if (quantity === 'displacement') return lengths(field.displacement);
  return field.error ? lengths(field.error) : none();
}

/** The end of the legend [m, or 1 for the strain]: the same for both sides. A model that diverged does not decide, if there is another. */
export function legendEnd(result: Result, models: string[], largest: Largest[], quantity: SolvedQuantity): number {
  const all = largest.map((l) => l[quantity]);
  const sound = all.filter((value, i) => value > 0 && result.models.find((m) => m.name === models[i])?.status === 'ok');
  return roundedUp(1000 * Math.max(...(sound.length > 0 ? sound : all))) / 1000;
}

/** The same of the modulus [Pa]. */
export const modulusEnd = (modulus: Float32Array): number => roundedUp(modulus.reduce((a, b) => Math.max(a, b), 0));

export const exaggerationOf = (choice: Choice) => exaggerations[choice.exaggeration] ?? 1;
