// The blade as controls and readings.
import type { Lesion } from '../../../data/types.ts';
import { byId, element } from '../../../page/elements.ts';
import { tell } from '../../readings.ts';
import { beyondStroke, bladeOf, thickness, type Stroke } from './stroke.ts';
import type { CutAnswer, CutRequest } from './types.ts';

const input = (id: string) => byId<HTMLInputElement>(`live-blade-${id}`);
const choice = (id: string) => byId<HTMLSelectElement>(`live-blade-${id}`);
const number = (value: number, digits: number) => value.toFixed(digits).replace('-', '−');

/** Offers the regions inside a body to be cut out. */
export function showRegions(lesions: readonly Lesion[]): void {
  choice('region').replaceChildren(...lesions.map(({ name, region }) => element('option', { value: region }, name.replaceAll('_', ' '))));
  byId('live-blade-out').hidden = lesions.length === 0;
}

/** Shows what belongs to a blade, and nothing of it with other tools. */
export function showBladeControls(isBlade: boolean): void {
  byId('live-blade').hidden = byId('live-blade-felt').hidden = !isBlade;
  if (isBlade) byId('live-felt').hidden = true;
  for (const id of ['live-tool-sliders', 'live-tool-pick']) byId(id).hidden = isBlade;
}

const isThrough = () => input('depth').value === input('depth').max;
const takesLoose = () => input('loose').checked;

/** The region that is chosen, with its margin. */
export function chosenRegion(): CutRequest {
  return { tool: { kind: 'region', region: Number(choice('region').value), margin: input('margin').valueAsNumber / 1000, keepsMargin: input('keeps').checked, opens: input('opens').checked }, takesLoose: takesLoose() };
}

/** @param reach  see bladeOf() [m] */
export function chosenStroke(stroke: Stroke, reach: number): CutRequest {
  const depth = isThrough() ? reach : input('depth').valueAsNumber / 1000;
  const tool = choice('stroke').value === 'side' ? beyondStroke(stroke) : bladeOf(stroke, depth, reach, choice('stroke').value === 'part' ? 0 : thickness);
  return { tool, takesLoose: takesLoose() };
}

export function listenToBlade(cut: (request: CutRequest) => void): void {
  const sliders = () => {
    for (const id of ['margin', 'depth']) tell(`live-blade-${id}-shown`, input(id).valueAsNumber / 1000, id === 'depth' && isThrough() ? 'through' : `${input(id).value} mm`);
    byId('live-blade-depth-row').hidden = choice('stroke').value === 'side';
  };
  for (const id of ['margin', 'depth']) input(id).addEventListener('input', sliders);
  choice('stroke').addEventListener('change', sliders);
  byId('live-blade-cut').addEventListener('click', () => cut(chosenRegion()));
  sliders();
}

/** What the last cut has done; nothing of a whole body. */
export function showCut(answer: CutAnswer | null): void {
  byId('live-blade-readings').hidden = answer === null;
  if (!answer) {
    for (const id of ['taken', 'kept']) tell(`live-blade-${id}`, Number.NaN, '–');
    return;
  }
  const { volume, wayVolume, snapped, jagged, margin, closed, woundArea, numPieces, numLoose, seconds } = answer;
  tell('live-blade-volume', volume, `${number(1e6 * volume, 1)} mL`);
  tell('live-blade-way', wayVolume, wayVolume > 0 ? `${number(1e6 * wayVolume, 1)} mL of it` : closed.volume > 0 ? 'none' : 'none needed');
  const left = `${number(1000 * margin, 1)} mm`;
  tell('live-blade-left', margin, Number.isNaN(margin) ? 'no lesion cut' : left);
  tell('live-blade-taken', volume, `${number(1e6 * volume, 1)} mL`);
  tell('live-blade-kept', margin, Number.isNaN(margin) ? '' : left);
  byId('live-blade-off-row').hidden = jagged.worst === 0;
  tell('live-blade-off', snapped.mean, `${number(1000 * snapped.mean, 1)} mm, at most ${number(1000 * snapped.worst, 1)} mm`);
  byId('live-blade-closed').hidden = closed.volume === 0;
  tell('live-blade-closed', closed.volume, closed.volume === 0 ? '' :
    `A closed cavity of ${number(1e6 * closed.volume, 1)} mL is left, ${number(1000 * closed.depth, 1)} mm below the capsule: nothing that was cut could come out of it. Undo, and choose “through the capsule”.`);
  tell('live-blade-area', woundArea, `${number(1e4 * woundArea, 1)} cm²`);
  const loose = numLoose === 0 ? '' : `, ${numLoose} loose taken away`;
  tell('live-blade-pieces', numPieces, `${numPieces}${loose}`);
  tell('live-blade-springs', seconds.springs, `${number(1000 * seconds.springs, 2)} ms`);
  tell('live-blade-all', seconds.all, `${number(1000 * seconds.all, 0)} ms`);
}

/** The stroke as it is drawn, in pixels of the stage; null for none. */
export function drawStroke(line: [x1: number, y1: number, x2: number, y2: number] | null): void {
  const svg = byId('live-stroke');
  svg.toggleAttribute('hidden', line === null);
  if (!line) return;
  ['x1', 'y1', 'x2', 'y2'].forEach((name, i) => svg.firstElementChild!.setAttribute(name, String(line[i])));
}
