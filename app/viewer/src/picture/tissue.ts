// What a body is made of, in the colours of an atlas.
import type { Colour } from './colour_maps.ts';
import { vesselColour } from './vessel_colour.ts';

export const tissues = ['lesion', 'parenchyma', 'vessel'] as const;
export type Tissue = (typeof tissues)[number];

/** Liver is dark red, and lesions are pale. */
export const tissueColours: Record<Tissue, Colour> = { lesion: [236, 214, 160], parenchyma: [152, 62, 46], vessel: vesselColour };

/** Where a colour map has a tissue, 0 to 1: lesions and vessels are apart, so that no border shows a third colour. */
export const placeOfTissue = (tissue: Tissue): number => tissues.indexOf(tissue) / (tissues.length - 1);

export const colourOfPlace = (t: number): Colour => tissueColours[tissues[Math.min(Math.floor(t * tissues.length), tissues.length - 1)]!];

/** Places from those of others towards parenchyma at which a border is: just inside the first and the last third. */
const border: Record<Tissue, number> = { lesion: 0.325, parenchyma: 0.5, vessel: 0.675 };

/** Places of the nodes of a body in the map (N). A cut is coloured up to the borders of regions, whose nodes are theirs. @param region  (M) */
export function tissueOfNodes(numNodes: number, tetrahedra: ArrayLike<number>, region: ArrayLike<number>, names: readonly string[]): Float32Array {
  const kinds = names.map((name, i) => (i === 0 ? 'parenchyma' : tissueOfRegion(name)));
  const isParenchyma = new Uint8Array(numNodes);
  for (let t = 0; t < region.length; t++) if (region[t] === 0) for (let i = 0; i < 4; i++) isParenchyma[tetrahedra[4 * t + i]!] = 1;
  const nodes = new Float32Array(numNodes).fill(placeOfTissue('parenchyma'));
  for (let t = 0; t < region.length; t++) {
    const kind = kinds[region[t]!]!;
    if (region[t]! > 0) for (let i = 0; i < 4; i++) nodes[tetrahedra[4 * t + i]!] = isParenchyma[tetrahedra[4 * t + i]!] ? border[kind] : placeOfTissue(kind);
  }
  return nodes;
}

/** By its name, as those of label images are (livermark mesh --labels). */
export const tissueOfRegion = (name: string): Tissue => (/vein|vessel|vena|portal|arter/i.test(name) ? 'vessel' : 'lesion');
