// How far every model is from the reference: numbers, and a plot in the rows of the table.
import type { Model, Result } from '../data/types.ts';
import { millimetres, percent, short } from '../picture/scale.ts';
import { element, row } from './elements.ts';
import { axisLabels, decades, dot, sayRoles } from './error_dots.ts';

const smallestFelt = 0.07; // that fingers tell apart (Pang, Tan, Durlach 1991)

const hasTool = (result: Result) => result.models.some((model) => Number.isFinite(model.comparison?.stiffness ?? Number.NaN));

/** With its sign, and a mark where fingers feel it. */
function signedStiffness(value: number): string {
  if (Number.isNaN(value)) return '–';
  return `${value > 0 ? '+' : ''}${percent(value)}${Math.abs(value) > smallestFelt ? ' !' : ''}`;
}

/** In a sentence, in per cent with two digits. */
const rounded = (ratio: number) => String(Number((100 * Math.abs(ratio)).toPrecision(2)));

/**
 * How far a model is off and whether a hand feels it, as a sentence; empty where nobody compared.
 * @param load  a name of the part of the load at which the errors are; empty for the whole
 */
export function verdict(result: Result, name: string, load: string): string {
  const compared = result.models.find((model) => model.name === name)?.comparison;
  if (!compared || !Number.isFinite(compared.relativeL2) || name === result.reference) return '';
  const { stiffness } = compared;
  const isFelt = Math.abs(stiffness) > smallestFelt;
  const felt = Number.isNaN(stiffness) ? ''
    : ` and ${rounded(stiffness)} % too ${stiffness > 0 ? 'stiff' : 'soft'} under the tool, which a hand ${isFelt ? 'feels' : 'does not feel'} (${isFelt ? 'above' : 'below'} ${rounded(smallestFelt)} %)`;
  const judge = `${result.loads.length > 0 ? 'hyperelastic' : 'linear'} finite elements, ${result.reference}`;
  return `${name} is ${rounded(compared.relativeL2)} % off in position${felt}${load ? `, at ${load}` : ''}; judged by ${judge}.`;
}

function stateOf(model: Model, result: Result): Node | string {
  if (model.status !== 'ok') {
    const state = element('span', { class: 'bad', title: model.message }, model.status.replace('_', ' '));
    return state;
  }
  return model.name === result.reference ? 'reference' : 'ok';
}

function modelRow(model: Model, result: Result, range: [number, number], shown: string[], onChoose: (model: string) => void): HTMLElement {
  const compared = model.comparison;
  const name = element('button', { type: 'button', title: model.summary, 'data-key': model.name }, model.name);
  name.addEventListener('click', () => onChoose(model.name));
  const value = (text: (c: NonNullable<typeof compared>) => string) => (compared ? text(compared) : '–');
  const line = row('td', name,
    dot(range, compared?.relativeL2 ?? Number.NaN, result.referenceUncertainty, shown.includes(model.name)),
    value((c) => percent(c.relativeL2)), ...(hasTool(result) ? [value((c) => signedStiffness(c.stiffness))] : []), value((c) => millimetres(c.maxError)), value((c) => percent(c.energyError)),
    value((c) => percent(c.reactionError)),
    ...(result.motionReference ? [value((c) => percent(c.motionError)), value((c) => short(1000 * c.motionLag))] : []),
    short(model.solveSeconds), stateOf(model, result));
  line.cells[1]!.className = 'plot';
  // Where a row does not fit into one line, each number carries the name of its column.
  heads(result).forEach((head, i) => line.cells[i]!.setAttribute('data-label', head));
  line.dataset['model'] = model.name;
  line.classList.toggle('shown', shown.includes(model.name));
  return line;
}

const heads = (result: Result) => ['', '', 'Error [%]', ...(hasTool(result) ? ['Tool [%]'] : []), 'Largest [mm]', 'Energy [%]', 'Reaction [%]',
  ...(result.motionReference ? ['Motion [%]', 'Lag [ms]'] : []), 'Solved in [s]', 'State'];

/**
 * @param load      a name of the part of the load at which the errors are; empty for the whole
 * @param onChoose  called with the model whose name was clicked
 */
export function comparison(result: Result, shown: string[], load: string, onChoose: (model: string) => void): Node[] {
  const compared = result.models.filter((model) => model.comparison);
  const range = decades(compared.map((model) => model.comparison!.relativeL2));
  const head = row('th', 'Model', axisLabels(range, (ratio) => `${Number((100 * ratio).toPrecision(1))} %`), ...heads(result).slice(2));
  head.cells[1]!.className = 'plot';
  head.cells[1]!.append(element('span', { class: 'unseen' }, 'Error, on a logarithmic scale'));
  const rank = (model: Model) => (model.name === result.reference ? -1 : (model.comparison?.relativeL2 ?? Number.NaN));
  const ranked = [...result.models].sort((a, b) => (Number.isNaN(rank(a)) ? 1 : Number.isNaN(rank(b)) ? -1 : rank(a) - rank(b)));
  const rows = ranked.map((model) => modelRow(model, result, range, shown, onChoose));
  const table = element('table', {}, element('thead', {}, head), element('tbody', {}, ...rows));
  sayRoles(table);
  const uncertainty = result.referenceUncertainty > 0
    ? ` The shaded part is within what the reference itself is uncertain by, ${percent(result.referenceUncertainty)} %.` : '';
  const tool = hasTool(result)
    ? ` Tool is how much stiffer the model feels where the load case presses, pulls or moves it; ! marks what fingers tell apart, above ${percent(smallestFelt)} %.` : '';
  const motion = result.motionReference
    ? ` Motion and lag are those of the probes, against ${result.motionReference}.` : '';
  return [
    element('h2', {}, `How far the models are from ${result.reference}${load ? ` at ${load}` : ''}`),
    element('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of errors' },
      table),
    element('p', { class: 'hint' },
      `Error is that of the displacement in the whole body, weighted by volume, over the displacement; the plot is logarithmic.${load ? ' At parts of the load the page computes it from the displacements, energies and reactions of the file.' : ''}${uncertainty}${tool}${motion} A click on a name shows that model.`),
  ];
}
