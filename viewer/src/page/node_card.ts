import type { NodeValues, Result } from '../data/types.ts';
import { millimetres, short } from '../picture/scale.ts';
import { breakable, element, row } from './elements.ts';

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
function components(vector: number[]): string {
  const length = 1000 * Math.hypot(...vector);
  const decimals = length > 0 && Number.isFinite(length) ? Math.min(Math.max(2 - Math.floor(Math.log10(length)), 0), 7) : 0;
  return vector.map((metres) => (1000 * metres).toFixed(decimals).replace('-', '−').replace('NaN', '–')).join(', ');
}

function valuesTable(values: NodeValues[]): HTMLElement {
  const head = element('thead', {}, row('th', 'Model, and (x, y, z)', 'Moved', 'Error'));
  const body = values.map(({ model, displacement, error }) => {
    const name = element('div', {}, breakable(model), element('small', {}, `(${components(displacement)})`));
    const line = row('td', name, millimetres(Math.hypot(...displacement)), error ? millimetres(Math.hypot(...error)) : '–');
    line.dataset['model'] = model;
    return line;
  });
  return element('table', {}, head, element('tbody', {}, ...body));
}

/** The numbers of one node in every model, or how to choose one. */
export function nodeCard(result: Result, node: number | null, values: NodeValues[], onChoose: (node: number | null) => void): Node[] {
  const field = numberField(result, node, onChoose);
  if (node === null)
    return [field, element('p', { class: 'hint' }, 'Click the body to read what each model says there.')];
  const place = [0, 1, 2].map((i) => short(1000 * result.points[3 * node + i]!)).join(', ');
  return [field, element('p', { class: 'hint' }, `At rest at (${place}) mm. What the models say there, in mm:`), valuesTable(values)];
}
