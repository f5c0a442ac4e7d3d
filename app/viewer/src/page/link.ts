// A view as text behind the # of the address: the file, what is shown of it, and from where. Lengths in mm, times in s.
import { courseOf, type Result } from '../data/types.ts';
import type { CameraPlace } from '../picture/camera.ts';
import { quantities } from '../picture/colour_maps.ts';
import { exaggerations } from '../picture/fields.ts';
import type { Skin } from '../picture/materials.ts';
import { exaggerationOf, shownModels, validQuantity, type Choice } from './state.ts';

export interface Link {
  path: string; // in the server's list; empty if the address names none
  view: URLSearchParams;
}

const skins: Record<Skin, string> = { flat: 'exact', solid: 'shaded', translucent: 'glass' };
const axes = ['x', 'y', 'z'];
const rounded = (metres: number) => Number((1000 * metres).toFixed(3));

/** What cannot be read counts as if it were not there. */
export function readLink(fragment: string): Link {
  const [path, view] = fragment.replace(/^#/, '').split(/\?(.*)/s);
  let decoded = '';
  try {
    decoded = decodeURIComponent(path ?? '');
  } catch {
    // A per cent sign that begins nothing.
  }
  return { path: decoded, view: new URLSearchParams(view ?? '') };
}

/** @param path  in the server's list; empty for a file from elsewhere, which the reader of the link has to open as well */
export function linkTo(path: string, result: Result, choice: Choice, camera: CameraPlace | null): string {
  const view = new URLSearchParams({ left: choice.models[0], right: choice.models[1], colours: choice.quantity, surface: skins[choice.skin] });
  view.set('times', String(exaggerationOf(choice)));
  if (choice.frame !== null) view.set('time', String(Number(result.frameTimes[choice.frame]!.toFixed(6))));
  if (courseOf(choice) === 'path') view.set('load', String(Number(result.loads[choice.point!]!.toFixed(6))));
  if (choice.node !== null) view.set('node', String(choice.node));
  if (choice.cut) view.set('cut', [axes[choice.cut.axis], rounded(choice.cut.place), choice.cut.keepsAbove ? 'above' : 'below'].join(','));
  if (!choice.showsConditions) view.set('conditions', 'off');
  if (!choice.showsNames) view.set('names', 'off');
  if (!choice.showsVessels) view.set('vessels', 'off');
  if (camera) view.set('camera', cameraText(camera));
  return `#${encodeURIComponent(path)}?${view.toString().replaceAll('%2C', ',')}`;
}

/** Where a camera is and what it looks at [mm]. */
export const cameraText = ({ position, target }: CameraPlace) => [...position, ...target].map(rounded).join(',');

/** Numbers with commas between them; null for anything else. */
export function numbersOf(text: string | null, count: number): number[] | null {
  const numbers = text?.split(',').map(Number) ?? [];
  return numbers.length === count && numbers.every(Number.isFinite) ? numbers : null;
}

function cutOf(text: string | null): Choice['cut'] {
  const [axis, place, half] = text?.split(',') ?? [];
  const index = axes.indexOf(axis ?? '');
  if (index < 0 || place === undefined || !Number.isFinite(Number(place))) return null;
  return { axis: index as 0 | 1 | 2, place: Number(place) / 1000, keepsAbove: half === 'above' };
}

/** Of ascending numbers the one that is next to what a view says; null if it says nothing. */
function nearest(numbers: number[], text: string | null): number | null {
  const wanted = Number(text ?? Number.NaN);
  if (!Number.isFinite(wanted) || numbers.length === 0) return null;
  const distances = numbers.map((number) => Math.abs(number - wanted));
  return distances.indexOf(Math.min(...distances));
}

/** What of a view fits to a file; the rest stays as it would be without the link. */
export function choiceOf(view: URLSearchParams, result: Result): Partial<Choice> {
  const choice: Partial<Choice> = {};
  const frame = nearest(result.frameTimes, view.get('time'));
  const point = nearest(result.loads, view.get('load'));
  if (frame !== null) choice.frame = frame;
  else if (point !== null && point < result.loads.length - 1) choice.point = point;
  const models = [view.get('left'), view.get('right')];
  const known = shownModels(result, courseOf({ frame: choice.frame ?? null, point: choice.point ?? null }));
  if (models.every((name) => name !== null && known.includes(name))) choice.models = models as [string, string];
  const quantity = ([...quantities, 'patches', 'tissue'] as const).find((q) => q === view.get('colours'));
  if (quantity) choice.quantity = validQuantity(result, quantity);
  const skin = (Object.keys(skins) as Skin[]).find((s) => skins[s] === view.get('surface'));
  if (skin) choice.skin = skin;
  const factor = exaggerations.indexOf(Number(view.get('times') ?? Number.NaN));
  if (factor >= 0) choice.exaggeration = factor;
  const node = Number(view.get('node') ?? Number.NaN);
  if (Number.isInteger(node) && node >= 0 && node < result.points.length / 3) choice.node = node;
  choice.cut = cutOf(view.get('cut'));
  choice.showsConditions = view.get('conditions') !== 'off';
  choice.showsNames = view.get('names') !== 'off';
  choice.showsVessels = view.get('vessels') !== 'off';
  return choice;
}

/** The inverse of cameraText(); null for anything else. */
export function placeOf(text: string | null): CameraPlace | null {
  const numbers = numbersOf(text, 6)?.map((mm) => mm / 1000);
  return numbers ? { position: numbers.slice(0, 3) as CameraPlace['position'], target: numbers.slice(3) as CameraPlace['target'] } : null;
}
