// Named parts of the surface have a colour each; the grey of what is inside is not among them. They are pale, so that the patterns of
// conditions are seen on all. These are the light colours of Tol (2021, SRON/EPS/TN/09-002), chosen to be told apart by colour-blind
// readers. `livermark mesh --picture` has the same (python/livermark/report/colours.py).
import type { Colour } from './colour_maps.ts';

const colours: readonly Colour[] = [
  [119, 170, 221], [238, 221, 136], [68, 187, 153], [238, 136, 102], [255, 170, 187], [187, 204, 51], [153, 221, 255], [170, 170, 0],
];

/** With more parts than colours these come again, darker each time. */
export function patchColour(patch: number): Colour {
  const [red, green, blue] = colours[patch % colours.length]!;
  const part = 0.65 ** Math.floor(patch / colours.length);
  return [Math.round(part * red), Math.round(part * green), Math.round(part * blue)];
}

/** For CSS. */
export const cssOf = (colour: Colour) => `rgb(${colour.join(' ')})`;
