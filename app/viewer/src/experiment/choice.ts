// What the reader of an experiment has chosen, and the same as a part of an address.
import type { Experiment, ExperimentModel, ExperimentRun, ExperimentState } from '../data/experiment.ts';
import { cameraText } from '../page/link.ts';
import { exaggerations, nearestExaggeration } from '../picture/fields.ts';
import type { CameraPlace } from '../picture/camera.ts';

export type Slice = 'all' | 'x' | 'y' | 'z';

export interface ExperimentChoice {
  state: number;
  model: number; // index
  exaggeration: number; // of the differences: index into differences
  slice: Slice; // the middle of the body along an axis, or all markers
  showsDriving: boolean;
  showsSurface: boolean;
  marker: number | null;
}

/** By what differences between computed and measured places may be multiplied. */
export const differences = exaggerations.filter((factor) => factor >= 1 && factor <= 500);
export const factorOf = (choice: ExperimentChoice) => differences[choice.exaggeration] ?? 1;

export const stateOf = (of: Experiment, { state }: ExperimentChoice): ExperimentState => of.states[state]!;
export const modelOf = (of: Experiment, { model }: ExperimentChoice): ExperimentModel => of.models[model]!;
export const runOf = (of: Experiment, choice: ExperimentChoice): ExperimentRun | null => modelOf(of, choice).runs[choice.state] ?? null;
export const isCompared = ({ markers }: Experiment, marker: number) => markers.drives[marker] === '';

/** The same model twice is told apart by its mesh. */
export function titleOf(of: Experiment, model: ExperimentModel): string {
  const isTwice = of.models.filter(({ name }) => name === model.name).length > 1;
  return isTwice ? `${model.name}, ${model.tetrahedra} tetrahedra` : model.name;
}

export function extentOf(positions: ArrayLike<number>, axis: number): [low: number, high: number] {
  let [low, high] = [Infinity, -Infinity];
  for (let i = axis; i < positions.length; i += 3) [low, high] = [Math.min(low, positions[i]!), Math.max(high, positions[i]!)];
  return [low, high];
}

/** Largest extent of the body along an axis [m]. */
export const sizeOf = ({ points }: Experiment) =>
  Math.max(...[0, 1, 2].map((axis) => extentOf(points, axis)).map(([low, high]) => high - low));

/** How much differences are multiplied by for a typical one to be seen beside the body. */
function seenFactor(of: Experiment): number {
  const errors = of.models.flatMap(({ runs }) => runs).filter((run) => run?.status === 'ok' && run.error > 0).map((run) => run!.error).sort((a, b) => a - b);
  const factor = (0.03 * sizeOf(of)) / (errors[Math.floor(errors.length / 2)] ?? Number.NaN);
  return Number.isFinite(factor) ? Math.min(Math.max(factor, 1), differences.at(-1)!) : 1;
}

/** Index of the reference on its finest mesh; -1 if it is not there. */
export function referenceOf(of: Experiment): number {
  const finest = Math.max(...of.models.filter(({ name }) => name === of.reference).map(({ tetrahedra }) => tetrahedra));
  return of.models.findIndex(({ name, tetrahedra }) => name === of.reference && tetrahedra === finest);
}

/** Before the reader chooses: the last state, which is deformed most, and the reference on its finest mesh. */
export function firstChoice(of: Experiment): ExperimentChoice {
  return {
    state: of.states.length - 1,
    model: Math.max(referenceOf(of), 0),
    exaggeration: differences.indexOf(exaggerations[nearestExaggeration(seenFactor(of))]!),
    slice: 'all',
    showsDriving: true,
    showsSurface: true,
    marker: null,
  };
}

/** The markers that are drawn, among them the marked one. Those in the middle are within a tenth of the extent of all of them. */
export function shownMarkers(of: Experiment, { slice, showsDriving, marker }: ExperimentChoice): number[] {
  const { position, names } = of.markers;
  const axis = 'xyz'.indexOf(slice);
  const [low, high] = axis < 0 ? [-Infinity, Infinity] : extentOf(position, axis);
  const isIn = (k: number) => axis < 0 || Math.abs(position[3 * k + axis]! - (low + high) / 2) <= 0.1 * (high - low);
  return [...names.keys()].filter((k) => k === marker || (isIn(k) && (showsDriving || isCompared(of, k))));
}

/** @param path  in the server's list; empty for a file from elsewhere */
export function experimentLink(path: string, of: Experiment, choice: ExperimentChoice, camera: CameraPlace | null): string {
  const model = modelOf(of, choice);
  const view = new URLSearchParams({ state: stateOf(of, choice).name, model: model.name, tetrahedra: String(model.tetrahedra), times: String(factorOf(choice)) });
  if (choice.slice !== 'all') view.set('slice', choice.slice);
  if (!choice.showsDriving) view.set('driving', 'off');
  if (!choice.showsSurface) view.set('body', 'off');
  if (choice.marker !== null) view.set('marker', of.markers.names[choice.marker]!);
  if (camera) view.set('camera', cameraText(camera));
  return `#${encodeURIComponent(path)}?${view.toString().replaceAll('%2C', ',')}`;
}

/** What of a link fits to the file; the rest is as it is at first. */
export function choiceOfLink(of: Experiment, view: URLSearchParams): ExperimentChoice {
  const choice = firstChoice(of);
  const state = of.states.findIndex(({ name }) => name === view.get('state'));
  const model = of.models.findIndex(({ name, tetrahedra }) => name === view.get('model') && String(tetrahedra) === view.get('tetrahedra'));
  const factor = differences.indexOf(Number(view.get('times')));
  const marker = of.markers.names.indexOf(view.get('marker') ?? '');
  if (state >= 0) choice.state = state;
  if (model >= 0) choice.model = model;
  if (factor >= 0) choice.exaggeration = factor;
  choice.slice = (['x', 'y', 'z'] as const).find((axis) => axis === view.get('slice')) ?? 'all';
  choice.showsDriving = view.get('driving') !== 'off';
  choice.showsSurface = view.get('body') !== 'off';
  choice.marker = view.has('marker') && marker >= 0 ? marker : null;
  return choice;
}
