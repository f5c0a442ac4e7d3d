// The choices of the reader, and the keys.
import { courseOf, type Result } from '../data/types.ts';
import type { Skin } from '../picture/body.ts';
import type { Colouring } from '../picture/colour_maps.ts';
import { exaggerations } from '../picture/fields.ts';
import type { Stage } from '../picture/stage.ts';
import { listenToCut, showCut } from './cut_controls.ts';
import { byId, element } from './elements.ts';
import { loadText } from './loads.ts';
import { exaggerationOf, lookOf, shownModels, type Choice } from './state.ts';

/** Changes of the choice. What moves needs another frame, and a part of the load models that have a path: these are changes of their own. */
export interface Changes {
  change(part: Partial<Choice>): void;
  setMoving(isMoving: boolean): void;
  /** @param point  of the path of loads; the last one is the whole load */
  setPoint(point: number): void;
}

const form = () => byId<HTMLFormElement>('controls');
const radio = (name: string) => form().elements.namedItem(name) as RadioNodeList;

export function listen({ change, setMoving, setPoint }: Changes, stage: Stage, result: () => Result | null, choice: () => Choice | null): void {
  form().addEventListener('submit', (event) => event.preventDefault());
  form().addEventListener('change', (event) => {
    const { name, value, checked } = event.target as HTMLInputElement;
    if (name === 'quantity') change(lookOf(value as Colouring, choice()!));
    if (name === 'skin') change({ skin: value as Skin });
    if (name === 'moment') setMoving(value === 'motion');
    if (name === 'conditions') change({ showsConditions: checked });
    if (name === 'names') change({ showsNames: checked });
    if (name === 'vessels') change({ showsVessels: checked });
  });
  byId('exaggeration').addEventListener('input', (event) =>
    change({ exaggeration: (event.target as HTMLInputElement).valueAsNumber }));
  byId('frame').addEventListener('input', (event) => change({ frame: (event.target as HTMLInputElement).valueAsNumber }));
  byId('point').addEventListener('input', (event) => setPoint((event.target as HTMLInputElement).valueAsNumber));
  byId('reset').addEventListener('click', () => stage.resetView());
  for (const [side, id] of ['left', 'right'].entries())
    byId(id).addEventListener('change', (event) => {
      const models = [...choice()!.models] as Choice['models'];
      models[side] = (event.target as HTMLSelectElement).value;
      change({ models });
    });
  listenToCut(result, choice, change);
  listenToKeys(document.querySelector<HTMLCanvasElement>('#stage canvas')!, stage, () => change({ node: null }));
}

/** Keys on a picture: they turn it, and Esc deselects. */
export function listenToKeys(canvas: HTMLCanvasElement, stage: Stage, deselect: () => void): void {
  const step = Math.PI / 18;
  const keys: Record<string, () => void> = {
    ArrowLeft: () => stage.turn(-step, 0),
    ArrowRight: () => stage.turn(step, 0),
    ArrowUp: () => stage.turn(0, step),
    ArrowDown: () => stage.turn(0, -step),
    '+': () => stage.zoom(0.9),
    '=': () => stage.zoom(0.9),
    '-': () => stage.zoom(1 / 0.9),
    r: () => stage.resetView(),
    R: () => stage.resetView(),
    Escape: deselect,
  };
  canvas.addEventListener('keydown', (event) => {
    const action = keys[event.key];
    if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    action();
  });
}

/** Makes the controls say what is chosen. */
export function showChoice(result: Result, choice: Choice): void {
  const isMoving = choice.frame !== null;
  radio('quantity').value = choice.quantity;
  byId('modulus_row').hidden = result.modulus === null;
  radio('skin').value = choice.skin;
  radio('moment').value = isMoving ? 'motion' : 'static';
  for (const [name, isOn] of [['conditions', choice.showsConditions], ['names', choice.showsNames], ['vessels', choice.showsVessels]] as const)
    (form().elements.namedItem(name) as HTMLInputElement).checked = isOn;
  byId('names_row').hidden = result.lesions.length === 0 && choice.quantity !== 'patches';
  byId('vessels_row').hidden = result.vessels === null;
  showCut(result, choice);
  byId('moment').hidden = result.frameTimes.length === 0;
  const names = shownModels(result, courseOf(choice));
  for (const [side, id] of ['left', 'right'].entries()) {
    const list = byId<HTMLSelectElement>(id);
    list.replaceChildren(...names.map((name) => element('option', { value: name }, name)));
    list.value = choice.models[side]!;
  }
  const slider = byId<HTMLInputElement>('exaggeration');
  slider.max = String(exaggerations.length - 1);
  slider.value = String(choice.exaggeration);
  const factor = exaggerationOf(choice);
  const words = factor === 0 ? 'not at all' : factor === 1 ? 'as it is' : `${factor} times as large`;
  byId('factor').textContent = words;
  slider.setAttribute('aria-valuetext', words);
  byId('time').hidden = !isMoving;
  const frame = byId<HTMLInputElement>('frame');
  frame.max = String(result.frameTimes.length - 1);
  frame.value = String(choice.frame ?? 0);
  const time = isMoving ? `${result.frameTimes[choice.frame!]!.toFixed(3)} s` : '';
  byId('now').textContent = time;
  frame.setAttribute('aria-valuetext', time);
  byId('load').hidden = isMoving || result.loads.length === 0;
  const point = byId<HTMLInputElement>('point');
  point.max = String(Math.max(0, result.loads.length - 1));
  point.value = String(choice.point ?? result.loads.length - 1);
  const load = loadText(result, choice);
  byId('load_now').textContent = load;
  point.setAttribute('aria-valuetext', load);
}
