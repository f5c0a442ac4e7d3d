// The settings that may be changed while the body moves.
import { byId, element } from '../page/elements.ts';
import { short } from '../picture/scale.ts';
import { largestRegion } from './surface.ts';
import { tell } from './readings.ts';
import { stepInWords } from './steps.ts';
import type { Chosen, LiveBody, LiveSettings } from './types.ts';

export type EngineKind = 'wasm' | 'native';

/** The springs that are taken first: the most accurate ones. C++ has the same name in app/live/scene.hpp. */
const usualSprings = 'nodal_neo_hookean';

/** Those of the file. */
export function settingsOf(body: LiveBody): LiveSettings {
  const region = largestRegion(body);
  return {
    springLaw: usualSprings,
    keepsVolume: true,
    youngModulus: body.youngModulus[region]!,
    poissonRatio: Math.min(Math.max(body.poissonRatio[region]!, 0), 0.49),
    massDamping: 10,
    stiffnessDamping: 0,
    timeStep: 0,
  };
}

const field = (id: string) => byId<HTMLInputElement>(`live-${id}`);

/** Numbers are shown in their own units: [id, setting, what one of the unit is in SI]. */
const numbers: [string, keyof LiveSettings & ('youngModulus' | 'poissonRatio' | 'massDamping' | 'stiffnessDamping' | 'timeStep'), number][] = [
  ['young', 'youngModulus', 1000],
  ['nu', 'poissonRatio', 1],
  ['alpha', 'massDamping', 1],
  ['beta', 'stiffnessDamping', 0.001],
  ['step-length', 'timeStep', 0.001],
];

export function showSettings(settings: LiveSettings): void {
  byId<HTMLSelectElement>('live-law').value = settings.springLaw;
  field('keeps-volume').checked = settings.keepsVolume;
  for (const [id, name, unit] of numbers) field(id).value = String(Number((settings[name] / unit).toPrecision(12)));
}

/** Springs that no law of the list names. */
const plainNames: Record<string, string> = {
  nodal_springs: 'coupled around nodes (nodal_springs)',
  nodal_neo_hookean: 'coupled around nodes, neo-Hookean (nodal_neo_hookean)',
  nodal_neo_hookean_f: 'the same with means of F, quicker (nodal_neo_hookean_f)',
  edge_neo_hookean: 'coupled around edges, neo-Hookean (edge_neo_hookean)',
  edge_neo_hookean_f: 'the same with means of F, quicker (edge_neo_hookean_f)',
};

export function showLaws(laws: string[], settings: LiveSettings): LiveSettings {
  const springLaw = laws.includes(settings.springLaw) ? settings.springLaw : (laws[0] ?? settings.springLaw);
  byId('live-law').replaceChildren(...laws.map((law) => element('option', { value: law }, plainNames[law] ?? law)));
  const known = { ...settings, springLaw };
  showSettings(known);
  return known;
}

export function showChosen(chosen: Chosen): void {
  const { timeStep, longestTimeStep, criticalTimeStep, numSprings } = chosen;
  const milliseconds = (seconds: number) => `${short(1000 * seconds)} ms`;
  tell('live-step', timeStep, milliseconds(timeStep));
  tell('live-longest', longestTimeStep, milliseconds(longestTimeStep));
  tell('live-critical', criticalTimeStep, milliseconds(criticalTimeStep));
  tell('live-springs', numSprings, String(numSprings));
  byId('live-limit').textContent = stepInWords(chosen);
  field('step-length').max = String(1000 * longestTimeStep);
}

/** What the fields say, or what is wrong with the first that cannot be used. */
function read(before: LiveSettings): LiveSettings | string {
  const settings = { ...before, springLaw: byId<HTMLSelectElement>('live-law').value, keepsVolume: field('keeps-volume').checked };
  for (const [id, name, unit] of numbers) {
    const input = field(id);
    // The longest step is the engine's to judge: it may be another one with the settings beside it.
    if (Number.isNaN(input.valueAsNumber) || input.validity.rangeUnderflow || (name !== 'timeStep' && input.validity.rangeOverflow))
      return `${input.dataset['name']} has to be ${input.max && name !== 'timeStep' ? `from ${input.min} to ${input.max}` : `${input.min} or more`}.`;
    // A number that nobody has touched stays as fine as it was.
    const shown = Number((before[name] / unit).toPrecision(12));
    if (input.valueAsNumber !== shown) settings[name] = input.valueAsNumber * unit;
  }
  return settings;
}

/** @param current  what the fields were filled from */
export function listenToSettings(current: () => LiveSettings | null, change: (settings: LiveSettings) => void, say: (sentence: string) => void): void {
  const form = byId<HTMLFormElement>('live-settings');
  form.addEventListener('submit', (event) => event.preventDefault());
  form.addEventListener('change', (event) => {
    const before = current();
    if (!before || (event.target as HTMLElement).id === 'live-engine') return;
    const asked = read(before);
    if (typeof asked !== 'string') return change(asked);
    say(asked);
    showSettings(before);
  });
}
