// What of the live page is in a link, as text: the springs, what the colours show, the cut, the camera. Lengths in mm, stress in kPa.
import { cameraText, placeOf } from '../page/link.ts';
import type { CameraPlace } from '../picture/camera.ts';
import type { Skin } from '../picture/materials.ts';
import { allShown, type Shown } from './shown_field.ts';
import type { LiveSettings } from './types.ts';

export interface LiveLook {
  shown: Shown;
  end: number | null; // where colours end, in the unit of the legend; null where they follow
  cutAxis: string; // value of the control; empty for a whole body
  cutPlace: number; // per cent of the extent
  skin: Skin;
  showsVessels: boolean;
  hasElements: boolean; // FEM beside the springs
  camera: CameraPlace | null;
}

const skins: [value: Skin, name: string][] = [['flat', 'exact'], ['solid', 'shaded'], ['translucent', 'glass']];

/** [name in the link, setting, what one of the unit is in SI, smallest, largest] in that unit. */
const numbers: [string, keyof LiveSettings & ('youngModulus' | 'poissonRatio' | 'massDamping' | 'stiffnessDamping'), number, number, number][] = [
  ['young', 'youngModulus', 1000, 0.001, 1e6],
  ['nu', 'poissonRatio', 1, 0, 0.49],
  ['alpha', 'massDamping', 1, 0, 1000],
  ['beta', 'stiffnessDamping', 0.001, 0, 100],
];

export function writeLiveLink(settings: LiveSettings, look: LiveLook): URLSearchParams {
  const link = new URLSearchParams({ mode: 'live', law: settings.springLaw, volume: settings.keepsVolume ? 'on' : 'off' });
  for (const [name, setting, unit] of numbers) link.set(name, String(Number((settings[setting] / unit).toPrecision(12))));
  link.set('live_colours', look.shown);
  if (look.end !== null) link.set('live_end', String(look.end));
  link.set('live_surface', skins.find(([value]) => value === look.skin)?.[1] ?? 'exact');
  if (look.cutAxis !== '') link.set('live_cut', `${'xyz'[Number(look.cutAxis)]},${look.cutPlace}`);
  if (!look.showsVessels) link.set('live_vessels', 'off');
  if (look.hasElements) link.set('fem', 'on');
  if (look.camera) link.set('live_camera', cameraText(look.camera));
  return link;
}

/** Settings of a link; what it does not say, or says wrongly, is as without it. */
export function linkedSettings(link: URLSearchParams, without: LiveSettings): LiveSettings {
  const settings = { ...without, springLaw: link.get('law') ?? without.springLaw };
  if (link.has('volume')) settings.keepsVolume = link.get('volume') !== 'off';
  for (const [name, setting, unit, smallest, largest] of numbers) {
    const value = Number(link.get(name) ?? Number.NaN);
    if (value >= smallest && value <= largest) settings[setting] = value * unit;
  }
  return settings;
}

/** @param first  what is seen without a link, which counts for what this does not say */
export function linkedLook(link: URLSearchParams, first: Pick<LiveLook, 'shown' | 'skin'>): LiveLook {
  const [axis, place] = link.get('live_cut')?.split(',') ?? [];
  const cutAxis = 'xyz'.indexOf(axis || '-');
  const cutPlace = Number(place ?? 50);
  const isCut = cutAxis >= 0 && cutPlace >= 0 && cutPlace <= 100;
  const end = Number(link.get('live_end') ?? Number.NaN);
  return {
    shown: allShown.find((shown) => shown === link.get('live_colours')) ?? first.shown,
    end: end > 0 && end < Infinity ? end : null,
    cutAxis: isCut ? String(cutAxis) : '',
    cutPlace: isCut ? cutPlace : 50,
    skin: skins.find(([, name]) => name === link.get('live_surface'))?.[0] ?? first.skin,
    showsVessels: link.get('live_vessels') !== 'off',
    hasElements: link.get('fem') === 'on',
    camera: placeOf(link.get('live_camera')),
  };
}
