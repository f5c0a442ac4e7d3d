// Three slices of the label image that the body was made of, folded below the picture until the reader asks for them.
import { fetchLabelImage, voxelParts, type LabelImage, type VoxelPart } from '../data/label_image.ts';
import { Fault, type Field, type Result } from '../data/types.ts';
import { displaced } from '../picture/fields.ts';
import { cssOf } from '../picture/patch_colours.ts';
import { drawSlice, partColours, scaleFor, voxelAt, type Panel, type SliceShape } from '../picture/slice_panel.ts';
import { insideImage, placeOfVoxel, sliceViews, turnOf, voxelsOf, type SliceView, type Voxel } from '../picture/slices.ts';
import { short } from '../picture/scale.ts';
import { byId, element } from './elements.ts';
import { numbersOf } from './link.ts';
import { comparedFrame, offer } from './save.ts';
import { exaggerationOf, type Choice } from './state.ts';

export interface Slices {
  /** Another file is shown. @param path  in the server's list; empty for one from elsewhere @param view  of the link that it was opened with */
  open(result: Result, path: string, view: URLSearchParams): void;
  /** Draws the bodies as they are drawn above. */
  show(result: Result, choice: Choice, fields: readonly Field[]): void;
  /** What a link says of them; null while they are folded. */
  link(): string | null;
}

/** What is drawn above. */
interface Shown {
  result: Result;
  choice: Choice;
  fields: readonly Field[];
}

const colours = { rest: '#ffffff', models: ['#6fc3ff', '#ffd23f'] } as const;
const below = 0.01; // from where the body moves most to where the slices are at first [m]
const notHere = 'The image is not in this file. Start livermark view where the image is that the body was made of, and open the file from its list.';
const spoken: Record<VoxelPart, string> = { outside: 'outside', liver: 'liver', lesion: 'lesion', vessel: 'vessel', other: 'other labels' };
const isTurned = (image: LabelImage) => turnOf(image) > 1;
const panelTimes = 2; // as many pixels as on the screen in what is saved

/** A little below the node that moves most, towards the middle of the body. */
function firstPlace({ result, fields }: Shown): number[] {
  const { points } = result, u = fields[0]!.displacement;
  const middle = [0, 0, 0];
  let [most, node] = [-1, 0];
  for (let i = 0; i < points.length; i += 3) {
    for (let a = 0; a < 3; a++) middle[a]! += (3 * points[i + a]!) / points.length;
    const length = Math.hypot(u[i]!, u[i + 1]!, u[i + 2]!);
    if (length > most) [most, node] = [length, i];
  }
  const way = middle.map((x, a) => x - points[node + a]!), part = Math.min(1, below / (Math.hypot(...way) || 1));
  return way.map((x, a) => points[node + a]! + part * x);
}

interface ViewOnPage {
  view: SliceView;
  canvas: HTMLCanvasElement;
  slider: HTMLInputElement;
  output: HTMLOutputElement;
}

/** @param changed  a link would be another one now */
export function createSlices(changed: () => void): Slices {
  const details = byId<HTMLDetailsElement>('slices');
  let shown: Shown | null = null;
  let path = '';
  let place: number[] | null = null; // that the slices go through [m]
  let image: LabelImage | null = null;
  let asked: string | null = null; // path of the file whose image is asked for
  let hasFailed = false; // and is asked for again when the slices are unfolded again
  let views: ViewOnPage[] = [];
  let parts: VoxelPart[] = []; // that the image has
  let shapes: SliceShape[] = [];

  const say = (sentence: string) => (byId('slices-note').textContent = sentence);
  const through = (of: LabelImage): Voxel => insideImage(of, voxelsOf(of, place!) as unknown as number[]);
  const surfaces = () => [shown!.result.surfaces.outside, shown!.result.surfaces.inside];
  const panelOf = ({ canvas }: ViewOnPage, of: LabelImage): Panel => {
    const { clientWidth: width, clientHeight: height } = canvas;
    return { x: 0, y: 0, width, height, perMetre: scaleFor(of, views.map(({ view }) => view), width, height) };
  };

  async function ask(): Promise<void> {
    if (path === '') return void say(notHere);
    if (asked === path || hasFailed) return;
    asked = path;
    say('The server reads the image…');
    try {
      const found = await fetchLabelImage(path);
      if (asked !== path) return;
      image = found;
      parts = voxelParts.filter((part, index) => partColours[part] && found.part.includes(index));
      say('');
      makeViews(found);
      draw();
    } catch (error) {
      if (asked !== path) return;
      asked = null;
      hasFailed = true;
      say(error instanceof Fault ? error.message : `It cannot be shown (${String(error)}).`);
    }
  }

  function goThrough(of: LabelImage, voxel: Voxel): void {
    place = placeOfVoxel(of, voxel);
    drawViews();
    changed();
  }

  function makeViews(of: LabelImage): void {
    views = sliceViews(of).map((view) => {
      const { left, right, top, bottom } = view.ends, num = of.size[view.axis];
      const canvas = element('canvas', { role: 'img', 'aria-label': `${view.name} slice of the image with contours of the mesh: ${left} on the left, ${right} on the right, ${top} above, ${bottom} below. A click moves the other two slices there.` });
      const id = `slices-${view.name.toLowerCase()}`;
      const slider = element('input', { id, type: 'range', min: 1, max: num, step: 1 }), output = element('output', { for: id });
      const made = { view, canvas, slider, output };
      slider.addEventListener('input', () => {
        const voxel = through(of);
        voxel[view.axis] = view.isAcrossBack ? num - slider.valueAsNumber : slider.valueAsNumber - 1;
        goThrough(of, voxel);
      });
      canvas.addEventListener('click', ({ offsetX, offsetY }) => goThrough(of, voxelAt(of, view, through(of), panelOf(made, of), offsetX, offsetY)));
      return made;
    });
    byId('slices-views').replaceChildren(...views.map(({ view, canvas, slider, output }) =>
      element('figure', {}, canvas, element('label', { class: 'slider', for: slider.id }, element('span', {}, `${view.name} slice `, output), slider))));
    byId('slices-shown').hidden = false;
  }

  function makeShapes(of: LabelImage, { result, choice, fields }: Shown): void {
    const nodes = Int32Array.from({ length: result.points.length / 3 }, (_, node) => node);
    const moved = fields.map(({ displacement }, side) => ({
      name: choice.models[side]!, colour: colours.models[side]!, width: side === 0 ? 3 : 1.3,
      voxels: voxelsOf(of, displaced({ nodes }, result.points, displacement, exaggerationOf(choice))),
    }));
    shapes = [{ name: 'mesh at rest', colour: colours.rest, width: 1, voxels: voxelsOf(of, result.points) }, ...moved];
  }

  function drawViews(): void {
    if (!image || !shown) return;
    const of = image, voxel = through(of);
    place = placeOfVoxel(of, voxel); // which is seen
    for (const made of views) {
      const { view, canvas, slider, output } = made;
      if (canvas.clientWidth === 0) return; // hidden
      [canvas.width, canvas.height] = [canvas.clientWidth, canvas.clientHeight].map((length) => Math.round(length * devicePixelRatio)) as [number, number];
      const context = canvas.getContext('2d')!;
      context.scale(devicePixelRatio, devicePixelRatio);
      drawSlice(context, of, view, voxel, surfaces(), shapes, panelOf(made, of));
      const num = of.size[view.axis], number = view.isAcrossBack ? num - voxel[view.axis] : voxel[view.axis] + 1;
      slider.value = String(number);
      output.textContent = isTurned(of) ? `${number} of ${num}` : `${'xyz'[view.across]} = ${short(1000 * place![view.across]!)} mm`;
      slider.setAttribute('aria-valuetext', output.textContent);
    }
    details.dataset['drawn'] = String(Number(details.dataset['drawn'] ?? 0) + 1);
  }

  function draw(): void {
    if (!details.open || !shown) return;
    place ??= firstPlace(shown);
    if (!image) return void ask();
    makeShapes(image, shown);
    drawViews();
    byId('slices-legend').replaceChildren(
      ...shapes.map(({ name, colour }) => element('li', {}, element('span', { class: 'swatch line', style: `--colour: ${colour}`, 'aria-hidden': 'true' }), name)),
      ...parts.map((part) => element('li', {}, element('span', { class: 'swatch', style: `background: ${cssOf(partColours[part]!)}`, 'aria-hidden': 'true' }), spoken[part])));
    byId('slices-about').textContent = `Displacement drawn ${byId('factor').textContent}. ${sidesIn(image)}`;
  }

  function sidesIn(of: LabelImage): string {
    const turned = isTurned(of) ? ` The image is turned by ${turnOf(of).toFixed(0)}° against the axes of the patient, so letters name the nearest side.` : '';
    return `R, L, A, P, I and S are the patient’s right, left, front, back, feet and head.${turned}`;
  }

  async function save(): Promise<void> {
    if (!image || !shown) return;
    const of = image, { result, choice } = shown, [foot, gap] = [58, 8];
    const { file, title } = comparedFrame(result, choice);
    const panels = views.map((made) => panelOf(made, of)), width = panels.reduce((sum, panel) => sum + panel.width + gap, gap), height = panels[0]!.height;
    const whole = element('canvas', { width: Math.round(panelTimes * width), height: Math.round(panelTimes * (height + 2 * gap + foot)) });
    const context = whole.getContext('2d')!;
    context.scale(panelTimes, panelTimes);
    context.fillStyle = '#101418';
    context.fillRect(0, 0, width + 1, height + 2 * gap + foot + 1);
    views.forEach(({ view }, i) => drawSlice(context, of, view, through(of), surfaces(), shapes, { ...panels[i]!, x: gap + panels.slice(0, i).reduce((sum, panel) => sum + panel.width + gap, 0), y: gap }));
    context.font = '13px system-ui, sans-serif';
    let x = gap;
    for (const { name, colour } of shapes) {
      context.fillStyle = colour;
      context.fillRect(x, height + 3 * gap + 3, 22, 2);
      context.fillText(name, x + 28, height + 3 * gap + 8);
      x += 28 + context.measureText(name).width + 20;
    }
    context.fillStyle = '#d5dade';
    context.fillText(`${title}. ${sidesIn(of)}`, gap, height + 3 * gap + 32, width - 2 * gap);
    const blob = await new Promise<Blob | null>((done) => whole.toBlob(done, 'image/png'));
    if (blob) offer(`${file}_slices.png`, blob);
  }

  details.addEventListener('toggle', () => {
    hasFailed = false;
    draw();
    changed();
  });
  byId('slices-save').addEventListener('click', () => void save());
  new ResizeObserver(drawViews).observe(byId('slices-views'));

  return {
    open(result, next, view) {
      [shown, path, image, asked, views, shapes] = [null, next, null, null, [], []];
      place = numbersOf(view.get('slices'), 3)?.map((mm) => mm / 1000) ?? null;
      hasFailed = false;
      details.hidden = !result.isOfImage;
      details.open = place !== null;
      byId('slices-shown').hidden = true;
      say('');
    },
    show(result, choice, fields) {
      shown = { result, choice, fields };
      draw();
    },
    link: () => (details.open && !details.hidden && place ? place.map((x) => Number((1000 * x).toFixed(3))).join(',') : null),
  };
}
