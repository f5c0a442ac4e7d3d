// Vessels that are lines have the blue in which atlases draw veins, lighter than that of arrows; the report and
// `livermark mesh check --picture` have the same (python/livermark/report/colours.py).
import type { Colour } from './colour_maps.ts';

export const vesselColour: Colour = [40, 120, 245];
