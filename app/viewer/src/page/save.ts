// The picture as PNG and the table as CSV, as files of the reader's.
import { courseOf, type Result } from '../data/types.ts';
import { mapColours, type Quantity } from '../picture/colour_maps.ts';
import { pageColours } from '../picture/page_colours.ts';
import { ticks } from '../picture/scale.ts';
import type { Stage } from '../picture/stage.ts';
import { byId } from './elements.ts';
import { scales } from './legend.ts';
import { loadName, loadOf } from './loads.ts';
import { patchEntries, tissueEntries, type ColourEntry } from './patch_legend.ts';
import type { Choice } from './state.ts';

const times = 2; // as many pixels as on the screen, each way
const head = 40; // above the picture, for the title [CSS pixels]
const foot = 64; // below it, for the legend [CSS pixels]

export function offer(name: string, content: Blob): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

const escaped = (text: string) => text.replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('"', '&quot;');

interface ScaleLegend {
  name: string;
  end: number; // in the unit of the name
  quantity: Quantity;
}

/** What is written around a picture. */
export interface PictureFrame {
  file: string; // name, without its ending
  title: string;
  sides: string[]; // above each view
  legend: ScaleLegend | ColourEntry[];
  more?: string; // SVG over the picture [CSS pixels]
}

type Write = (x: number, y: number, content: string, more?: string) => string;

/** @param top  of the strip [CSS pixels] */
function scaleBelow({ name, end, quantity }: ScaleLegend, width: number, top: number, text: Write): string {
  const [left, strip] = [0.36 * width, 0.56 * width];
  const numbers = ticks(end).map((value) => text(left + (strip * value) / end, top + 32, String(value), 'text-anchor="middle"'));
  const colours = mapColours(quantity);
  const stops = colours.map((colour, i) => `<stop offset="${i / (colours.length - 1)}" stop-color="${colour}"/>`).join('');
  return `<defs><linearGradient id="map">${stops}</linearGradient></defs>${text(left - 12, top + 12, name, 'text-anchor="end"')}
    <rect x="${left}" y="${top}" width="${strip}" height="14" fill="url(#map)"/>${numbers.join('')}`;
}

/** In two rows. */
function entriesBelow(entries: ColourEntry[], width: number, top: number, text: Write): string {
  const columns = Math.ceil(entries.length / 2);
  return entries.map(({ name, colour }, i) => {
    const [x, y] = [14 + ((i % columns) * (width - 28)) / columns, top + 26 * Math.floor(i / columns)];
    return `<rect x="${x}" y="${y}" width="22" height="14" fill="${colour}"/>${text(x + 30, y + 12, name)}`;
  }).join('');
}

/** As SVG around what is written over the picture. [CSS pixels] */
function frameOf(host: HTMLElement, { title, sides, legend, more }: PictureFrame, overlay: string, size: { width: number; height: number }): string {
  const { stage, ink } = pageColours(host);
  const { width, height } = size;
  const text: Write = (x, y, content, more = '') => `<text x="${x}" y="${y}" fill="${ink}" font-size="14" ${more}>${escaped(content)}</text>`;
  const canvas = host.getBoundingClientRect();
  const boxes = [...host.querySelectorAll('.side')].map((side) => side.getBoundingClientRect());
  const names = sides.map((name, side) =>
    text(boxes[side]!.left - canvas.left + 2, head + boxes[side]!.top - canvas.top + 20, name, 'font-weight="600"'));
  const top = head + height + 14;
  const below = Array.isArray(legend) ? entriesBelow(legend, width, top, text) : scaleBelow(legend, width, top, text);
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${head + height + foot}" font-family="system-ui, sans-serif">
    <rect width="${width}" height="${head}" fill="${stage}"/><rect y="${head + height}" width="${width}" height="${foot}" fill="${stage}"/>
    ${text(14, 26, title, 'font-weight="600"')}
    ${names.join('')}${below}
    <g transform="translate(0 ${head})">${overlay}${more ?? ''}</g></svg>`;
}

/** As on the screen, with title, names, scale and legend, and so many times the pixels. @param host  with the canvas of the stage in it */
export async function savePicture(stage: Stage, host: HTMLElement, frame: PictureFrame): Promise<void> {
  const { clientWidth: width, clientHeight: height } = host.querySelector('canvas')!;
  const { image, overlay } = stage.picture(times);
  const ratio = image.width / width;
  const whole = document.createElement('canvas');
  [whole.width, whole.height] = [image.width, Math.round(ratio * (head + height + foot))];
  const around = new Image();
  around.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(frameOf(host, frame, overlay, { width, height }))}`;
  await around.decode();
  const context = whole.getContext('2d')!;
  context.drawImage(image, 0, ratio * head);
  context.drawImage(around, 0, 0, whole.width, whole.height);
  const blob = await new Promise<Blob | null>((done) => whole.toBlob(done, 'image/png'));
  if (blob) offer(`${frame.file}.png`, blob);
}

/** Of two models. */
export function comparedFrame(result: Result, choice: Choice): PictureFrame {
  const end = Number(document.querySelector<HTMLElement>('#legend .numbers')?.dataset['endMm']);
  const load = loadName(result, choice);
  const time = choice.frame === null ? (load ? `, ${load}` : '') : `, ${result.frameTimes[choice.frame]!.toFixed(3)} s after the release`;
  return {
    file: `${result.body}_${result.loadCase}`,
    title: `${result.body}: ${result.loadCase}${time}. Displacements drawn ${byId('factor').textContent}`,
    sides: choice.models,
    legend: choice.quantity === 'patches' ? patchEntries(result) : choice.quantity === 'tissue' ? tissueEntries(result) : { name: scales[choice.quantity].name, end, quantity: choice.quantity },
  };
}

const quoted = (text: string) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/** The table with all digits: SI units, ratios as ratios, and nothing where the file has none. @param load  part of the load that is shown */
export function csvOf(result: Result, load: number): string {
  const hasPath = result.loads.length > 0;
  const columns = 'model,reference,relative_l2,stiffness_at_tool,max_error_m,energy_error,reaction_error,history_relative_l2,history_lag_s,solve_seconds,status' + (hasPath ? ',part_of_load' : '');
  const number = (value: number | undefined) => (value === undefined || Number.isNaN(value) ? '' : String(value));
  const lines = result.models.map(({ name, status, solveSeconds, comparison: c }) => [
    name, c?.reference ?? '', number(c?.relativeL2), number(c?.stiffness), number(c?.maxError), number(c?.energyError), number(c?.reactionError),
    number(c?.motionError), number(c?.motionLag), number(solveSeconds), status, ...(hasPath ? [String(load)] : []),
  ].map(quoted).join(','));
  return `${[columns, ...lines].join('\n')}\n`;
}

/** @param result  as it is at the moment of the choice */
export function saveTable(result: Result, choice: Choice): void {
  const load = loadOf(result, choice);
  const name = courseOf(choice) === 'path' ? `_load_${Number(load.toFixed(6))}` : '';
  offer(`${result.body}_${result.loadCase}${name}.csv`, new Blob([csvOf(result, load)], { type: 'text/csv' }));
}
