import type { NodeValues, Result } from '../data/types.ts';
import { millimetres, short } from '../picture/scale.ts';
import { conditionsAt } from './conditions_key.ts';
import { breakable, element, row } from './elements.ts';
import { loadName, loadOf } from './loads.ts';
import type { Choice } from './state.ts';

function numberField(result: Result, node: number | null, onChoose: (node: number | null) => void): HTMLElement {
  const numNodes = result.points.length / 3;
  const input = element('input', { type: 'number', min: 0, max: numNodes - 1, step: 1, id: 'node_number', 'data-key': 'node', placeholder: 'number' });
  if (node !== null) input.value = String(node);
  input.addEventListener('change', () => {
    const wanted = input.valueAsNumber;
    onChoose(Number.isInteger(wanted) && wanted >= 0 && wanted < numNodes ? wanted : null);
  });
  return element('div', { class: 'pick' }, element('label', { for: 'node_number' }, element('h3', {}, 'Node')), input);
}

/** In millimetres, all as fine as the length of the vector is to be read. */
export function components(vector: number[]): string {
  const length = 1000 * Math.hypot(...vector);
  const decimals = length > 0 && Number.isFinite(length) ? Math.min(Math.max(2 - Math.floor(Math.log10(length)), 0), 7) : 0;
  return vector.map((metres) => (1000 * metres).toFixed(decimals).replace('-', '−').replace('NaN', '–')).join(', ');
}

function valuesTable(values: NodeValues[], strains: Map<string, number>): HTMLElement {
  const strainOf = (model: string) => (strains.size === 0 ? [] : [strains.has(model) ? short(100 * strains.get(model)!) : '–']);
  const head = element('thead', {}, row('th', 'Model, and (x, y, z)', 'Moved', 'Error', ...(strains.size > 0 ? ['Strain [%]'] : [])));
  const body = values.map(({ model, displacement, error }) => {
    const name = element('div', {}, breakable(model), element('small', {}, `(${components(displacement)})`));
    const line = row('td', name, millimetres(Math.hypot(...displacement)), error ? millimetres(Math.hypot(...error)) : '–', ...strainOf(model));
    line.dataset['model'] = model;
    return line;
  });
  return element('table', {}, head, element('tbody', {}, ...body));
}

/**
 * The numbers of one node in every model, or how to choose one.
 * @param strains  of the models that are shown, if the strain is
 */
export function nodeCard(result: Result, choice: Choice, values: NodeValues[], strains: Map<string, number>, onChoose: (node: number | null) => void): Node[] {
  const { node } = choice;
  const field = numberField(result, node, onChoose);
  if (node === null)
    return [field, element('p', { class: 'hint' }, 'Click the body to read what each model says there, and what is prescribed there.')];
  const place = [0, 1, 2].map((i) => short(1000 * result.points[3 * node + i]!)).join(', ');
  const prescribed = conditionsAt(result, node, loadOf(result, choice));
  const load = loadName(result, choice);
  return [
    field,
    element('p', { class: 'hint' }, `At rest at (${place}) mm${prescribed.length > 0 ? '' : ', inside'}.`),
    ...(prescribed.length > 0 ? [element('p', { class: 'prescribed' }, `Prescribed around it: ${prescribed.join('; ')}.`)] : []),
    element('p', { class: 'hint' }, `What the models say there${load ? ` at ${load}` : ''}, in mm:`),
    valuesTable(values, strains),
  ];
}
