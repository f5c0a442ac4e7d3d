// Models beside an experiment: the reader chooses state and model, and sees where the model has the markers that were measured.
import type { OpenExperiment } from '../data/client.ts';
import type { Experiment } from '../data/experiment.ts';
import { listenToKeys } from '../page/controls.ts';
import { byId, element, refill, showInside } from '../page/elements.ts';
import { placeOf } from '../page/link.ts';
import { offer, savePicture } from '../page/save.ts';
import { displaced } from '../picture/fields.ts';
import { watchPageColours } from '../picture/page_colours.ts';
import { millimetres } from '../picture/scale.ts';
import { createStage, type Stage } from '../picture/stage.ts';
import { choiceOfLink, differences, experimentLink, factorOf, isCompared, modelOf, referenceOf, runOf, shownMarkers, sizeOf, stateOf, titleOf, type ExperimentChoice, type Slice } from './choice.ts';
import { markerCard } from './marker_card.ts';
import { createMarkerScene, type MarkerScene } from './marker_scene.ts';
import { experimentCsv, experimentTable } from './table.ts';

export interface ExperimentView {
  show(opened: OpenExperiment, view: URLSearchParams): void;
  hide(): void;
  /** The address of the view; null while none is shown. */
  link(path: string): string | null;
}

export interface ExperimentHooks {
  complain(name: string, error: unknown): void;
  /** Another view is drawn. */
  changed(): void;
}

type Colour = 'measured' | 'driving' | 'computed';
const colours: Record<Colour, string> = { measured: 'var(--line-2)', driving: 'var(--line-5)', computed: 'var(--line-1)' };
const part = (name: string) => byId(`experiment-${name}`);

/** Of the markers of a list, their places in a state: measured, and computed with the difference multiplied. [m] */
function placesOf(of: Experiment, choice: ExperimentChoice, markers: number[]): { measured: Float32Array; computed: Float32Array } {
  const { position } = of.markers;
  const { measured } = stateOf(of, choice);
  const computed = runOf(of, choice)?.computed;
  const factor = factorOf(choice);
  const each = (place: (i: number) => number) => Float32Array.from({ length: 3 * markers.length }, (_, j) => place(3 * markers[Math.floor(j / 3)]! + (j % 3)));
  return {
    measured: each((i) => position[i]! + measured[i]!),
    computed: each((i) => position[i]! + measured[i]! + factor * ((computed?.[i] ?? Number.NaN) - measured[i]!)),
  };
}

export function createExperimentView({ complain, changed }: ExperimentHooks): ExperimentView {
  const canvas = document.querySelector<HTMLCanvasElement>('#experiment-stage canvas')!;
  let stage: Stage | null = null; // once there is an experiment
  let scene: MarkerScene | null = null;
  let of: Experiment | null = null;
  let choice: ExperimentChoice | null = null;
  let numDrawn = 0;

  function colour(): void {
    const swatch = (name: Colour) => getComputedStyle(part('legend').querySelector(`[data-colour=${name}]`)!).backgroundColor;
    if (!scene || part('legend').childElementCount === 0) return;
    scene.colour({ measured: swatch('measured'), driving: swatch('driving'), computed: swatch('computed'), edges: getComputedStyle(part('stage')).color });
    stage!.redraw();
  }

  function drawBody(shown: Experiment, chosen: ExperimentChoice): void {
    const { deformed } = stateOf(shown, chosen);
    const all = Int32Array.from({ length: shown.points.length / 3 }, (_, i) => i);
    const values = new Float32Array(all.length);
    // A body that is not shown has all its nodes in one place.
    const displacement = chosen.showsSurface ? deformed : shown.points.map((x) => -x);
    stage!.show(0, { displacement, values, end: 1, quantity: 'displacement', skin: 'veil', exaggeration: 1, node: null });
    scene!.showEdges(displaced({ nodes: all }, shown.points, deformed, 1), chosen.showsSurface);
  }

  function drawMarkers(shown: Experiment, chosen: ExperimentChoice): void {
    const markers = shownMarkers(shown, chosen);
    const measuredOf = (list: number[]) => placesOf(shown, chosen, list).measured;
    const compared = markers.filter((k) => isCompared(shown, k));
    const { measured, computed } = placesOf(shown, chosen, compared);
    const marked = chosen.marker === null ? null : [...measuredOf([chosen.marker])];
    scene!.show({
      compared: measured,
      driving: measuredOf(markers.filter((k) => !isCompared(shown, k))),
      computed,
      from: measured,
      marked: marked?.every(Number.isFinite) ? marked : null,
    });
  }

  function legendEntries(shown: Experiment, chosen: ExperimentChoice): { colour: Colour; name: string }[] {
    const factor = factorOf(chosen);
    const times = factor === 1 ? '' : `, differences ${factor} times as large`;
    const drives = [...new Set(shown.markers.drives.filter(Boolean))].map((name) => name.replaceAll('_', ' ')).join(', ');
    return [
      { colour: 'measured', name: 'Measured' },
      { colour: 'driving', name: drives ? `Measured, drives ${drives}` : '' },
      { colour: 'computed', name: `Computed by ${modelOf(shown, chosen).name}${times}` },
    ];
  }

  function drawLegend(shown: Experiment, chosen: ExperimentChoice): void {
    const items = legendEntries(shown, chosen).map(({ colour: name, name: words }) => {
      const swatch = element('span', { class: name === 'computed' ? 'bead small' : 'bead', 'data-colour': name, style: `--colour: ${colours[name]}`, 'aria-hidden': 'true' });
      const item = element('li', {}, swatch, words);
      item.hidden = words === '';
      return item;
    });
    const surface = element('li', {}, `Surface: the body as ${shown.reference} deforms it`);
    surface.hidden = !chosen.showsSurface;
    part('legend').replaceChildren(...items, surface);
  }

  /** In words: how far the model is. */
  function aboutRun(shown: Experiment, chosen: ExperimentChoice): string {
    const run = runOf(shown, chosen);
    if (!run) return 'It was not run in this state.';
    const fault = run.status === 'ok' ? '' : `${run.status.replace('_', ' ')}${run.message ? `: ${run.message}` : ''}. `;
    return `${fault}${chosen.model === referenceOf(shown) ? 'Reference. ' : ''}Error ${millimetres(run.error)} mm, worst ${millimetres(run.worstError)} mm.`;
  }

  function showControls(shown: Experiment, chosen: ExperimentChoice): void {
    for (const input of part('states').querySelectorAll('input')) input.checked = input.value === String(chosen.state);
    byId<HTMLSelectElement>('experiment-model').value = String(chosen.model);
    part('model-about').textContent = part('model-about').title = aboutRun(shown, chosen);
    const slider = byId<HTMLInputElement>('experiment-differences');
    slider.value = String(chosen.exaggeration);
    const words = factorOf(chosen) === 1 ? 'as they are' : `${factorOf(chosen)} times as large`;
    part('factor').textContent = words;
    slider.setAttribute('aria-valuetext', words);
    byId<HTMLSelectElement>('experiment-slice').value = chosen.slice;
    const box = (name: string) => part('controls').querySelector<HTMLInputElement>(`[name=${name}]`)!;
    box('driving').checked = chosen.showsDriving;
    box('surface').checked = chosen.showsSurface;
    part('driving-row').hidden = shown.markers.drives.every((patch) => patch === '');
  }

  function draw(): void {
    if (!of || !choice) return;
    drawBody(of, choice);
    drawMarkers(of, choice);
    drawLegend(of, choice);
    colour();
    showControls(of, choice);
    refill(part('card'), markerCard(of, choice, (marker) => apply({ marker })));
    refill(part('table'), experimentTable(of, choice, (model) => apply({ model })));
    part('stage').dataset['drawn'] = String(++numDrawn);
    changed();
  }

  function apply(next: Partial<ExperimentChoice>): void {
    if (!choice) return;
    const marked = choice.marker;
    choice = { ...choice, ...next };
    draw();
    if (choice.marker !== null && choice.marker !== marked) showInside(part('card'));
  }

  /** The marker at a place of the canvas, of several the one in front. */
  function pick(x: number, y: number): void {
    if (!of || !choice || !stage) return;
    const markers = shownMarkers(of, choice);
    const { measured, computed } = placesOf(of, choice, markers);
    let [found, depth]: [number | null, number] = [null, Infinity];
    for (const places of [measured, computed]) {
      const seen = stage.onCanvas(places);
      markers.forEach((marker, j) => {
        if (places === computed && !isCompared(of!, marker)) return; // it is not drawn
        const reach = Math.max(scene!.radius / stage!.screenAt([...places.slice(3 * j, 3 * j + 3)]).metresPerPixel, 7);
        if (Math.hypot(seen[3 * j]! - x, seen[3 * j + 1]! - y) <= reach && seen[3 * j + 2]! < depth) [found, depth] = [marker, seen[3 * j + 2]!];
      });
    }
    apply({ marker: found });
  }

  function describe(shown: Experiment): void {
    document.title = `${shown.name} – Livermark`;
    part('title').textContent = shown.name.replaceAll('_', ' ');
    part('subtitle').textContent = shown.title;
    const compared = shown.markers.drives.filter((patch) => patch === '').length;
    const swings = shown.numRingDowns > 0 ? ' It also rang down, which livermark report shows.' : '';
    const assumed = shown.assumptions.length > 0 ? ` Assumed: ${shown.assumptions.join('; ')}.` : '';
    part('about').textContent = `${shown.file}: ${shown.markers.names.length} markers, of which ${compared} are compared.${swings} Source: ${shown.source}.${assumed} Keys on the picture: arrows turn, + and − zoom, R resets the view, Esc unmarks the marker.`;
    part('states').replaceChildren(part('states').querySelector('legend')!, ...shown.states.map(({ name }, s) =>
      element('label', {}, element('input', { type: 'radio', name: 'state', value: s }), ` ${name}`)));
    byId('experiment-model').replaceChildren(...shown.models.map((model, m) => element('option', { value: m }, titleOf(shown, model))));
    byId<HTMLInputElement>('experiment-differences').max = String(differences.length - 1);
  }

  function listen(): void {
    part('controls').addEventListener('submit', (event) => event.preventDefault());
    part('controls').addEventListener('change', (event) => {
      const { name, value, checked } = event.target as HTMLInputElement;
      if (name === 'state') apply({ state: Number(value) });
      if (name === 'driving') apply({ showsDriving: checked });
      if (name === 'surface') apply({ showsSurface: checked });
    });
    part('slice').addEventListener('change', (event) => apply({ slice: (event.target as HTMLSelectElement).value as Slice }));
    part('differences').addEventListener('input', (event) => apply({ exaggeration: (event.target as HTMLInputElement).valueAsNumber }));
    part('model').addEventListener('change', (event) => apply({ model: Number((event.target as HTMLSelectElement).value) }));
    part('reset').addEventListener('click', () => stage?.resetView());
    part('save-table').addEventListener('click', () => of && offer(`${of.name}.csv`, new Blob([experimentCsv(of)], { type: 'text/csv' })));
    part('save-picture').addEventListener('click', () => of && choice && void save(of, choice).catch((error) => complain('The picture', error)));
    watchPageColours(colour);
  }

  function save(shown: Experiment, chosen: ExperimentChoice): Promise<void> {
    const legend = legendEntries(shown, chosen).filter(({ name }) => name !== '').map(({ colour: key, name }) => ({
      name, size: '', colour: getComputedStyle(part('legend').querySelector(`[data-colour=${key}]`)!).backgroundColor }));
    return savePicture(stage!, part('stage'), { file: shown.name, title: `${shown.name}: ${stateOf(shown, chosen).name}`, sides: [titleOf(shown, modelOf(shown, chosen))], legend });
  }

  function startStage(): Stage {
    const made = createStage(canvas, { onClick: pick, onTurned: changed });
    made.setViews(1);
    listenToKeys(canvas, made, () => apply({ marker: null }));
    return made;
  }

  listen();
  return {
    show({ experiment }, view) {
      byId('experiment').hidden = false;
      stage ??= startStage();
      of = experiment;
      choice = choiceOfLink(of, view);
      describe(of);
      const none = { nodes: new Int32Array(), triangles: new Uint32Array() };
      const alsoSeen = Float32Array.from(of.states.flatMap(({ deformed }) => [...deformed.map((u, i) => (Number.isFinite(u) ? u : 0) + of!.points[i]!)]));
      stage.setBody(of.points, { outside: of.surface, inside: none }, { alsoSeen });
      scene?.free();
      scene = createMarkerScene(of.surface, of.markers.names.length, sizeOf(of));
      stage.add(0, scene.object);
      const camera = placeOf(view.get('camera'));
      if (camera) stage.setCameraPlace(camera);
      draw();
    },
    hide() {
      byId('experiment').hidden = true;
      of = choice = null;
    },
    link: (path) => (of && choice ? experimentLink(path, of, choice, stage!.cameraPlace()) : null),
  };
}
