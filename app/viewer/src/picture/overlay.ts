// What is written over the picture: which way the body lies, how long a millimetre is, names of what is inside.
import * as three from 'three';
import type { View } from './camera.ts';
import type { PageColours } from './page_colours.ts';

export interface Label {
  name: string;
  place: three.Vector3; // [m]
}

export interface Written {
  views: View[];
  camera: three.Camera;
  metresPerPixel: number; // at the middle of the body
  isAnatomical: boolean;
  labels: Label[][]; // of each view
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
  const axisLength = view.width < 400 ? 20 : 30; // [CSS pixels]
  const room = 38; // for the name of an axis that points to the left [CSS pixels]
  const [x, y] = [view.x + room + 1.15 * axisLength, view.y + view.height - 18 - 1.1 * axisLength];
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
  const [left, y] = [view.x + 136, view.y + view.height - 20]; // beside the axes
  const right = left + pixels;
  const path = `M${left} ${y - 5}V${y}H${right}V${y - 5}`;
  const millimetres = Number((1000 * metres).toPrecision(3));
  return [
    svg('path', { d: path, fill: 'none', stroke: colours.stage, 'stroke-width': 5 }),
    svg('path', { d: path, fill: 'none', stroke: colours.ink, 'stroke-width': 2, 'data-mm': millimetres, 'data-px': pixels }),
    text((left + right) / 2, y - 8, 'middle', `${millimetres} mm`, colours),
  ];
}

function names({ views, camera, labels, colours }: Written): SVGElement[] {
  return views.flatMap((view, side) => (labels[side] ?? []).flatMap(({ name, place }) => {
    const { x, y, z } = place.clone().project(camera);
    if (z > 1 || Math.abs(x) > 1 || Math.abs(y) > 1) return [];
    const [left, top] = [view.x + ((x + 1) / 2) * view.width, view.y + ((1 - y) / 2) * view.height];
    return [
      svg('circle', { cx: left, cy: top, r: 2.5, fill: colours.ink, stroke: colours.stage, 'stroke-width': 1.5 }),
      text(left + 7, top + 4, 'start', name, colours),
    ];
  }));
}

/** Replaces what is written in an element of SVG that covers the canvas. */
export function write(into: SVGElement, written: Written): void {
  written.camera.updateMatrixWorld();
  into.replaceChildren(...names(written), ...axes(written), ...scaleBar(written));
}

export function createOverlay(canvas: HTMLCanvasElement): SVGElement {
  const overlay = svg('svg', { class: 'overlay', 'aria-hidden': 'true' });
  canvas.after(overlay);
  return overlay;
}
