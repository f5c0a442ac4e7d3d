// How far every model is from the markers in a state, beside the noise of the measurement and what needs no mechanics.
import type { Experiment, ExperimentModel, ExperimentState } from '../data/experiment.ts';
import { breakable, element, row } from '../page/elements.ts';
import { axisLabels, decades, dot, sayRoles } from '../page/error_dots.ts';
import { millimetres, short } from '../picture/scale.ts';
import { referenceOf, stateOf, type ExperimentChoice } from './choice.ts';

const heads = ['', '', 'Error [mm]', 'Worst [mm]', 'Tetrahedra', 'Solved in [s]', 'State'];

const rounding = 1e-9; // what is below is 0 but for it [m]

/** What a model is beside, with the error of each; what the file does not have is left out. */
const yardsticks = (state: ExperimentState): [name: string, error: number, meaning: string][] => ([
  ['Noise of the measurement', state.noise, 'Errors below it rank no models'],
  ['Uncertainty of the reference', state.referenceUncertainty, 'Change of its markers when each tetrahedron is cut into eight'],
  ['Driven places off their markers', state.fitResidual, 'Driving markers from the smooth motion that is prescribed'],
  ['Straight line between driven places', state.straightLine, 'No mechanics'],
  ['Affine map that fits best', state.affineMap, 'No mechanics'],
  ['Rigid motion that fits best', state.rigidMotion, 'No mechanics'],
  ['No motion', state.noMotion, 'No mechanics'],
] as [string, number, string][]).filter(([name, error]) => Number.isFinite(error) && !(name.startsWith('Driven') && error < rounding));

function labelled(line: HTMLTableRowElement): HTMLTableRowElement {
  line.cells[1]!.className = 'plot';
  // Where a row does not fit into one line, each number carries the name of its column.
  heads.forEach((head, i) => line.cells[i]!.textContent !== '' && line.cells[i]!.setAttribute('data-label', head));
  return line;
}

function modelRow(of: Experiment, model: ExperimentModel, choice: ExperimentChoice, range: [number, number], onChoose: (model: number) => void): HTMLElement {
  const index = of.models.indexOf(model);
  const run = model.runs[choice.state] ?? null;
  const isShown = index === choice.model;
  const name = element('button', { type: 'button', 'data-key': `${model.name} ${model.tetrahedra}`, 'aria-pressed': String(isShown) }, breakable(model.name));
  name.addEventListener('click', () => onChoose(index));
  const status = !run ? '–' : run.status !== 'ok' ? element('span', { class: 'bad', title: run.message }, run.status.replace('_', ' '))
    : index === referenceOf(of) ? 'reference' : 'ok';
  const noise = stateOf(of, choice).noise;
  const line = labelled(row('td', name, dot(range, 1000 * (run?.error ?? Number.NaN), 1000 * noise, isShown), run ? millimetres(run.error) : '–',
    run ? millimetres(run.worstError) : '–', String(model.tetrahedra), run ? short(run.seconds) : '–', status));
  line.dataset['model'] = model.name;
  line.dataset['tetrahedra'] = String(model.tetrahedra);
  line.classList.toggle('shown', isShown);
  return line;
}

/** @param onChoose  called with the index of the model whose name was clicked */
export function experimentTable(of: Experiment, choice: ExperimentChoice, onChoose: (model: number) => void): Node[] {
  const state = stateOf(of, choice);
  const beside = yardsticks(state);
  const errors = [...beside.map(([, error]) => error), ...of.models.map(({ runs }) => runs[choice.state]?.error ?? Number.NaN)];
  const range = decades(errors.filter((error) => error > rounding).map((error) => 1000 * error));
  const head = row('th', 'Model', axisLabels(range, (error) => `${Number(error.toPrecision(1))} mm`), ...heads.slice(2));
  head.cells[1]!.className = 'plot';
  head.cells[1]!.append(element('span', { class: 'unseen' }, 'Error, on a logarithmic scale'));
  const lines = beside.map(([name, error, meaning]) => {
    const line = labelled(row('td', name, dot(range, 1000 * error, 1000 * state.noise, false), millimetres(error), '', '', '', ''));
    line.title = meaning;
    line.className = 'beside';
    return line;
  });
  const table = element('table', {}, element('thead', {}, head),
    element('tbody', {}, ...lines, ...of.models.map((model) => modelRow(of, model, choice, range, onChoose))));
  sayRoles(table);
  const noise = Number.isNaN(state.noise) ? 'The noise of the measurement is not known.' : 'The shaded part is within the noise of the measurement: errors there rank no models.';
  return [
    element('h2', {}, `How far the models are from the markers: ${state.name}`),
    element('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table of errors' }, table),
    element('p', { class: 'hint' },
      `Error is the root mean square distance between computed and measured places, over the markers that drive no place and were seen; worst is the largest. ${noise} A click on a name shows that model.`),
  ];
}

const quoted = (text: string) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/** All states, in SI units with all digits; nothing where there is no number. */
export function experimentCsv(of: Experiment): string {
  const number = (value: number | undefined) => (value === undefined || Number.isNaN(value) ? '' : String(value));
  const lines = of.states.flatMap((state, s) => [
    ...yardsticks(state).map(([name, error]) => [state.name, name, '', number(error), '', '', '']),
    ...of.models.map(({ name, tetrahedra, runs }) => [state.name, name, String(tetrahedra), number(runs[s]?.error), number(runs[s]?.worstError), number(runs[s]?.seconds), runs[s]?.status ?? '']),
  ]);
  return `${['state,model,tetrahedra,error_m,worst_error_m,solve_seconds,status', ...lines.map((line) => line.map(quoted).join(','))].join('\n')}\n`;
}
