// Equal steps of a quantity look like equal steps of colour. The maps are viridis and magma of matplotlib (CC0), 33 colours
// each; magma runs from pale to dark and leaves out its ends, so that no error looks like nothing on the page. That of the strain has
// equal steps of lightness in OKLCH, from pale green (0.96, hue 130) to dark violet (0.28, hue 280); that of the modulus as well, from
// pale yellow (0.96, hue 95) to dark brown (0.30, hue 35).

const displacement = `
  440154 470d60 48186a 482374 472d7b 453781 424086 3e4989 3b528b 375b8d 33638d
  2f6b8e 2c728e 297a8e 26828e 23898e 21918c 1f988b 1fa088 22a785 28ae80 32b67a
  3fbc73 4ec36b 5ec962 70cf57 84d44b 98d83e addc30 c2df23 d8e219 ece51b fde725`;

const error = `
  fcf0b2 fde3a5 fed799 fecc8f febf84 feb27a fea772 fd9a6a fc8c63 fa7f5e f8745c
  f4675c ee5b5e e75263 df4a68 d5446d ca3e72 c03a76 b5367a aa337d 9e2f7f 942c80
  892881 7e2482 752181 6a1c81 5f187f 54137d 4a1079 3f0f72 331067 29115a 1e1149`;

const strain = `
  deffbe cffab8 c0f5b3 b0f0af 9febac 8de6aa 7ae1a9 66dca9 4fd6a9 33d0aa 06c9ab
  02c1ac 00b8ac 09b0ab 00a8a9 02a0a7 0198a4 0090a2 00889f 00819b 017998 007195
  006a91 00628f 005a8c 065388 164b80 1e4477 223d6d 243664 25305a 252a50 232546`;

const modulus = `
  fcf2cd f9ebbc f7e3ab f4db9a f3d388 f1cb76 f0c263 efb94d eeb032 eda709 e79f01
  e19806 db9001 d58907 cf8203 c87b08 c27405 bb6d03 b56601 af6000 a85a05 a15304
  9a4d03 944602 8d4002 863a01 803401 792e01 722800 6b2200 641d02 5d1701 561101`;

export type Colour = readonly [red: number, green: number, blue: number]; // 0 to 255
/** What solutions differ in, and what the body is made of. */
export type SolvedQuantity = 'displacement' | 'error' | 'strain';
export type Quantity = SolvedQuantity | 'modulus';
export const quantities: readonly Quantity[] = ['displacement', 'error', 'strain', 'modulus'];
/** What a surface may be coloured by: a quantity, the part that a facet is of, or what the body is made of. */
export type Colouring = Quantity | 'patches' | 'tissue';

/** What is no number, as in a model that diverged. */
export const notANumber: Colour = [150, 150, 150];

function colours(list: string): Colour[] {
  return list.trim().split(/\s+/).map((hex) => {
    const value = Number.parseInt(hex, 16);
    return [value >> 16, (value >> 8) & 255, value & 255];
  });
}

const maps: Record<Quantity, Colour[]> = { displacement: colours(displacement), error: colours(error), strain: colours(strain), modulus: colours(modulus) };

/** @param t  0 to 1; what is outside gets the colour of the nearer end */
export function colourAt(quantity: Quantity, t: number): Colour {
  if (Number.isNaN(t)) return notANumber;
  const map = maps[quantity];
  const place = Math.min(Math.max(t, 0), 1) * (map.length - 1);
  const below = Math.min(Math.floor(place), map.length - 2);
  const part = place - below;
  const [a, b] = [map[below]!, map[below + 1]!];
  const mix = (i: 0 | 1 | 2) => Math.round(a[i] * (1 - part) + b[i] * part);
  return [mix(0), mix(1), mix(2)];
}

/** Of a strip of colours, the same distances apart. @return for CSS */
export const mapColours = (quantity: Quantity): string[] => maps[quantity].map((c) => `rgb(${c.join(' ')})`);

/** Of a strip of colours for CSS, from 0 to 1. */
export function gradient(quantity: Quantity): string {
  return `linear-gradient(to right, ${mapColours(quantity).join(', ')})`;
}
