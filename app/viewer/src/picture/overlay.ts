// What is written over the picture and below it: names of what is there, arrows that point at the reader or away, which way the
// body lies, and how long a millimetre is.
import * as three from 'three';
import type { Arrow } from './arrows.ts';
import { footHeight, type View } from './camera.ts';
import type { PageColours } from './page_colours.ts';

export interface Label {
  name: string;
  place: three.Vector3; // [m]
}

/** An arrow on the surface. */
export interface MarkedArrow extends Arrow {
  outwards: three.Vector3; // normal of the surface there
  colour: string;
}

export interface Written {
  views: View[];
  camera: three.Camera;
  metresPerPixel: number; // at the middle of the body
  isAnatomical: boolean;
  labels: Label[][]; // of each view
  arrows: MarkedArrow[][]; // of each view
  colours: PageColours;
}

const namespace = 'http://www.w3.org/2000/svg';
const axisColours = ['#c8402f', '#2f8f4e', '#3b74d1'];
const patient = ['left', 'back', 'head']; // LPS
const longestBar = 110; // [CSS pixels]

function svg(name: string, attributes: Record<string, string | number>, content = ''): SVGElement {
  const made = document.createElementNS(namespace, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  made.textContent = content;
  return made;
}

/** Legible on everything. */
function text(x: number, y: number, anchor: 'start' | 'middle' | 'end', content: string, colours: PageColours): SVGElement {
  const style = `font-size: 12px; fill: ${colours.ink}; stroke: ${colours.stage}; stroke-width: 3.5px; stroke-linejoin: round; paint-order: stroke`;
  return svg('text', { x, y, 'text-anchor': anchor, style }, content);
}

function axes({ camera, views, isAnatomical, colours }: Written): SVGElement[] {
  const view = views[0]!;
  const axisLength = 20; // [CSS pixels]
  const room = 38; // for the name of an axis that points to the left [CSS pixels]
  const [x, y] = [view.x + room + 1.15 * axisLength, view.y + view.height + footHeight - 18];
  const toCamera = camera.matrixWorldInverse;
  const drawn = [0, 1, 2].map((axis) => {
    const along = new three.Vector3().setComponent(axis, 1).transformDirection(toCamera);
    return { axis, along, name: isAnatomical ? patient[axis]! : 'xyz'[axis]! };
  });
  // The one that points away is drawn first.
  return drawn.sort((a, b) => a.along.z - b.along.z).flatMap(({ axis, along, name }) => {
    const [dx, dy] = [axisLength * along.x, -axisLength * along.y];
    const length = Math.hypot(dx, dy);
    const line = svg('line', { x1: x - 0.35 * dx, y1: y - 0.35 * dy, x2: x + dx, y2: y + dy, stroke: axisColours[axis]!, 'stroke-width': 2.5, 'stroke-linecap': 'round' });
    if (length < 0.3 * axisLength) return [line]; // points at the reader, or away
    const anchor = Math.abs(dx) < 0.5 * length ? 'middle' : dx > 0 ? 'start' : 'end';
    const beside = (length + 5) / length;
    return [line, text(x + beside * dx, y + beside * dy + (Math.abs(dx) < 0.5 * length ? (dy < 0 ? -1 : 10) : 4), anchor, name, colours)];
  });
}

/** The longest of 1, 2, 5 times a power of ten that fits. [m] */
export function barLength(metresPerPixel: number): number {
  const room = longestBar * metresPerPixel;
  const power = 10 ** Math.floor(Math.log10(room));
  return ([5, 2, 1].find((digit) => digit * power <= room) ?? 1) * power;
}

function scaleBar({ views, metresPerPixel, colours }: Written): SVGElement[] {
  const view = views[0]!;
  const metres = barLength(metresPerPixel);
  const pixels = metres / metresPerPixel;
  const [left, y] = [view.x + 136, view.y + view.height + footHeight - 14]; // beside the axes
  const right = left + pixels;
  const path = `M${left} ${y - 5}V${y}H${right}V${y - 5}`;
  const millimetres = Number((1000 * metres).toPrecision(3));
  return [
    svg('path', { d: path, fill: 'none', stroke: colours.stage, 'stroke-width': 5 }),
    svg('path', { d: path, fill: 'none', stroke: colours.ink, 'stroke-width': 2, 'data-mm': millimetres, 'data-px': pixels }),
    text((left + right) / 2, y - 8, 'middle', `${millimetres} mm`, colours),
  ];
}

interface Box {
  left: number;
  top: number;
  right: number;
  bottom: number;
}

const meet = (a: Box, b: Box) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
const isWithin = (box: Box, view: View) => box.left >= view.x && box.right <= view.x + view.width && box.top >= view.y && box.bottom <= view.y + view.height;

/** Where a place is in a view; null if it is not there. */
function pixelOf(place: three.Vector3, view: View, camera: three.Camera): { left: number; top: number } | null {
  const { x, y, z } = place.clone().project(camera);
  if (z > 1 || Math.abs(x) > 1 || Math.abs(y) > 1) return null;
  return { left: view.x + ((x + 1) / 2) * view.width, top: view.y + ((1 - y) / 2) * view.height };
}

/** Where a name may stand beside its dot: to the right if nothing is there, then to the left, below, above and further off. */
function placesFor(name: string, left: number, top: number): { x: number; y: number; anchor: 'start' | 'middle' | 'end'; box: Box }[] {
  const width = 7.2 * name.length, height = 15; // of letters of 12 pixels
  const at = (x: number, y: number, anchor: 'start' | 'middle' | 'end') => {
    const begin = anchor === 'start' ? x : anchor === 'end' ? x - width : x - width / 2;
    return { x, y, anchor, box: { left: begin, top: y - height + 3, right: begin + width, bottom: y + 3 } };
  };
  return [at(left + 7, top + 4, 'start'), at(left - 7, top + 4, 'end'), at(left, top + 18, 'middle'), at(left, top - 8, 'middle'),
    at(left + 7, top + 20, 'start'), at(left + 7, top - 12, 'start'), at(left - 7, top + 20, 'end'), at(left - 7, top - 12, 'end')];
}

/** Names beside their dots, none over another or over an arrow as long as there is room. */
function names({ views, camera, labels, arrows, colours }: Written): SVGElement[] {
  return views.flatMap((view, side) => {
    const dots = (labels[side] ?? []).flatMap(({ name, place }) => {
      const at = pixelOf(place, view, camera);
      return at ? [{ name, ...at }] : [];
    });
    const taken: Box[] = dots.map(({ left, top }) => ({ left: left - 3, top: top - 3, right: left + 3, bottom: top + 3 }));
    const ofArrows = (arrows[side] ?? []).flatMap(({ from, along }) => {
      const [a, b] = [pixelOf(from, view, camera), pixelOf(from.clone().add(along), view, camera)];
      return a && b ? [{ left: Math.min(a.left, b.left) - 3, top: Math.min(a.top, b.top) - 3, right: Math.max(a.left, b.left) + 3, bottom: Math.max(a.top, b.top) + 3 }] : [];
    });
    return dots.flatMap(({ name, left, top }) => {
      const all = placesFor(name, left, top).filter(({ box }) => isWithin(box, view));
      const free = all.filter(({ box }) => !taken.some((other) => meet(box, other)));
      const best = free.find(({ box }) => !ofArrows.some((other) => meet(box, other))) ?? free[0] ?? all[0];
      if (best) taken.push(best.box);
      return [
        svg('circle', { cx: left, cy: top, r: 2.5, fill: colours.ink, stroke: colours.stage, 'stroke-width': 1.5 }),
        ...(best ? [text(best.x, best.y, best.anchor, name, colours)] : []),
      ];
    });
  });
}

/** Cosine between an arrow and the line of sight above which its length is not seen. */
const alongSight = 0.9;
const signRadius = 6; // [CSS pixels]

/** As in drawings of currents: a dot in a circle is the tip of an arrow that comes, a cross the feathers of one that goes. */
function signs({ views, camera, arrows, colours }: Written): SVGElement[] {
  return views.flatMap((view, side) => {
    const taken: Box[] = [];
    return (arrows[side] ?? []).flatMap(({ from, along, outwards, colour }) => {
      const place = from.clone().addScaledVector(along, 0.5), sight = place.clone().sub(camera.position).normalize();
      const cosine = along.dot(sight) / (along.length() || 1), at = pixelOf(place, view, camera);
      if (!at || Math.abs(cosine) < alongSight || outwards.dot(sight) > 0) return [];
      const { left, top } = at, box = { left: left - signRadius - 2, top: top - signRadius - 2, right: left + signRadius + 2, bottom: top + signRadius + 2 };
      if (taken.some((other) => meet(box, other))) return [];
      taken.push(box);
      const arm = 0.7 * signRadius;
      return [
        svg('circle', { cx: left, cy: top, r: signRadius, fill: colours.stage, stroke: colour, 'stroke-width': 2, 'data-sign': cosine < 0 ? 'comes' : 'goes' }),
        cosine < 0 ? svg('circle', { cx: left, cy: top, r: 2.2, fill: colour })
          : svg('path', { d: `M${left - arm} ${top - arm}L${left + arm} ${top + arm}M${left + arm} ${top - arm}L${left - arm} ${top + arm}`, stroke: colour, 'stroke-width': 2 }),
      ];
    });
  });
}

/** Replaces what is written in an element of SVG that covers the canvas. */
export function write(into: SVGElement, written: Written): void {
  written.camera.updateMatrixWorld();
  into.replaceChildren(...signs(written), ...names(written), ...axes(written), ...scaleBar(written));
}

export function createOverlay(canvas: HTMLCanvasElement): SVGElement {
  const overlay = svg('svg', { class: 'overlay', 'aria-hidden': 'true' });
  canvas.after(overlay);
  return overlay;
}
