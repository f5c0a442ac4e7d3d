// The numbers of one marker in every model, or how to choose one.
import type { Experiment } from '../data/experiment.ts';
import { components } from '../page/node_card.ts';
import { breakable, element, row } from '../page/elements.ts';
import { millimetres, short } from '../picture/scale.ts';
import { stateOf, titleOf, type ExperimentChoice } from './choice.ts';

const vectorAt = (vectors: ArrayLike<number>, k: number) => [0, 1, 2].map((axis) => vectors[3 * k + axis]!);
const length = (vector: number[]) => Math.hypot(...vector);

function markerList({ markers }: Experiment, marker: number | null, onChoose: (marker: number | null) => void): HTMLElement {
  const list = element('select', { id: 'experiment-marker', 'data-key': 'marker' }, element('option', { value: '' }, 'none'),
    ...markers.names.map((name, k) => element('option', { value: k }, name)));
  list.value = marker === null ? '' : String(marker);
  list.addEventListener('change', () => onChoose(list.value === '' ? null : Number(list.value)));
  return element('div', { class: 'pick' }, element('label', { for: 'experiment-marker' }, element('h3', {}, 'Marker')), list);
}

/** @param onChoose  called with the index of a marker, or null for none */
export function markerCard(of: Experiment, choice: ExperimentChoice, onChoose: (marker: number | null) => void): Node[] {
  const k = choice.marker;
  const list = markerList(of, k, onChoose);
  if (k === null) return [list, element('p', { class: 'hint' }, 'Click a marker to read how far each model is from it.')];
  const state = stateOf(of, choice);
  const measured = vectorAt(state.measured, k);
  const rest = vectorAt(of.markers.position, k).map((x) => short(1000 * x)).join(', ');
  const drives = of.markers.drives[k]!;
  const role = drives ? ` It drives ${drives.replaceAll('_', ' ')}, and is not compared.` : '';
  const seen = measured.every(Number.isFinite);
  const moved = seen ? `In ${state.name} it moved ${millimetres(length(measured))} mm, by (${components(measured)}) mm.` : `In ${state.name} it was not seen.`;
  const lines = of.models.map((model, m) => {
    const run = model.runs[choice.state];
    const computed = run ? vectorAt(run.computed, k) : [Number.NaN];
    const name = element('div', {}, breakable(titleOf(of, model)), element('small', {}, run && computed.every(Number.isFinite) ? `(${components(computed)})` : run?.status.replace('_', ' ') ?? 'not run'));
    const line = row('td', name, millimetres(length(computed)), millimetres(length(computed.map((x, axis) => x - (measured[axis] ?? Number.NaN)))));
    line.dataset['model'] = model.name;
    line.dataset['tetrahedra'] = String(model.tetrahedra);
    line.classList.toggle('shown', m === choice.model);
    return line;
  });
  return [
    list,
    element('p', { class: 'hint' }, `At rest at (${rest}) mm.${role} ${moved}`),
    element('p', { class: 'hint' }, 'What the models say there, in mm:'),
    element('table', {}, element('thead', {}, row('th', 'Model, and (x, y, z)', 'Moved', 'Off by')), element('tbody', {}, ...lines)),
  ];
}
