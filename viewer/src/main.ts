// The page: a result file is opened, the reader chooses, and what follows from the choice is read and drawn.
import './style.css';
import { ask } from './data/client.ts';
import { Fault, type Result } from './data/types.ts';
import { goodExaggeration, nearestExaggeration } from './picture/fields.ts';
import { createStage, type Side, type Stage } from './picture/stage.ts';
import { createModes } from './modes.ts';
import { comparison } from './page/comparison.ts';
import { listen, showChoice } from './page/controls.ts';
import { byId, refill } from './page/elements.ts';
import { acceptFiles, fetchFile, fillList, listedFiles } from './page/files.ts';
import { legend } from './page/legend.ts';
import { motionPlot } from './page/motion_plot.ts';
import { nodeCard } from './page/node_card.ts';
import { createPlayer } from './page/player.ts';
import { colouredValues, exaggerationOf, legendEnd, referenceOf, validModels, type Choice } from './page/state.ts';

let result: Result | null = null;
let choice: Choice | null = null;
let numChanges = 0;
let numOpened = 0;

const canvas = document.querySelector<HTMLCanvasElement>('#stage canvas')!;
const stage = startStage();
const modes = createModes(say, complain);
const player = createPlayer(() => result?.frameTimes ?? [], () => choice?.frame ?? 0, (frame) => apply({ frame }));

function startStage(): Stage {
  try {
    return createStage(canvas, { onPick: (node) => change({ node }) });
  } catch (error) {
    say('This browser cannot draw in three dimensions: switch on WebGL 2 in its settings, or open the page in another.');
    throw error;
  }
}

function say(sentence: string): void {
  byId('message').textContent = sentence;
  byId('message').hidden = sentence === '';
}

/** What a reader sees of a side besides the body. */
function note(file: Result, name: string, reference: string): string {
  const model = file.models.find((m) => m.name === name)!;
  const role = name === reference ? 'Reference' : model.comparison ? '' : 'Not compared';
  const state = model.status === 'ok' ? '' : `${model.status.replace('_', ' ')}${model.message ? `: ${model.message}` : ''}`;
  return [role, model.summary, state].filter(Boolean).join(' – ');
}

/** Reads what the choice needs and draws it, unless the choice has changed meanwhile. */
async function draw(file: Result, chosen: Choice): Promise<void> {
  const mine = ++numChanges;
  const isMoving = chosen.frame !== null;
  const reference = referenceOf(file, isMoving);
  const [fields, largest, values] = await Promise.all([
    Promise.all(chosen.models.map((model) => ask('field', { model, frame: chosen.frame }))),
    Promise.all(chosen.models.map((model) => ask('largest', { model, moving: isMoving }))),
    chosen.node === null ? [] : ask('node', { node: chosen.node, frame: chosen.frame }),
  ]);
  if (mine !== numChanges) return;
  const end = legendEnd(file, chosen.models, largest, chosen.quantity);
  for (const side of [0, 1] as Side[]) {
    const { displacement } = fields[side]!;
    const coloured = colouredValues(fields[side]!, chosen.quantity, chosen.models[side] === reference);
    stage.show(side, { ...chosen, displacement, values: coloured, end, exaggeration: exaggerationOf(chosen) });
    const about = document.querySelectorAll<HTMLElement>('#stage .side p')[side]!;
    about.textContent = about.title = note(file, chosen.models[side]!, reference);
  }
  const exceeds = largest.some((l) => l[chosen.quantity] > end);
  const shade = chosen.skin === 'flat' ? '' : 'Light and glass shift colours; “Exact colours” shows them as here.';
  byId('legend').replaceChildren(...legend(chosen.quantity, end, exceeds, shade));
  refill(byId('node'), nodeCard(file, chosen.node, values, (node) => change({ node })));
  showChoice(file, chosen);
  byId('stage').dataset['drawn'] = String(mine);
}

async function drawMotion(file: Result, chosen: Choice): Promise<void> {
  byId('motion').hidden = file.frameTimes.length === 0 || file.probes.length === 0;
  if (byId('motion').hidden) return;
  const motions = await ask('motion', { probe: 0, reference: file.motionReference });
  const shown = [...new Set(chosen.models)].flatMap((model) => motions.filter((m) => m.model === model));
  const now = chosen.frame === null ? null : file.frameTimes[chosen.frame]!;
  byId('motion').replaceChildren(...motionPlot(file.probes[0]!, shown.length > 0 ? shown : motions.slice(0, 1), now));
}

async function apply(part: Partial<Choice>): Promise<void> {
  if (!result || !choice) return;
  choice = { ...choice, ...part };
  const [file, chosen] = [result, choice];
  try {
    await draw(file, chosen);
    await drawMotion(file, chosen);
    if (part.models)
      refill(byId('comparison'), comparison(file, chosen.models, showOnTheRight));
  } catch (error) {
    complain(file.file, error);
  }
}

const change = (part: Partial<Choice>) => void apply(part);

function showOnTheRight(model: string): void {
  if (!result || !choice) return;
  // A model that does not move is shown at rest.
  const canMove = result.models.find((m) => m.name === model)?.moves;
  change({ models: [choice.models[0], model], ...(canMove ? {} : { frame: null }) });
}

function setMoving(isMoving: boolean): void {
  if (!result || !choice) return;
  player.stop();
  change({ frame: isMoving ? 0 : null, models: validModels(result, isMoving, choice.models) });
}

function complain(name: string, error: unknown): void {
  const sentence = error instanceof Fault ? error.message : `It cannot be shown (${String(error)}).`;
  say(`${name}: ${sentence}`);
}

function describe(file: Result): void {
  document.title = `${file.body}, ${file.loadCase} – Livermark`;
  byId('title').textContent = byId('live-title').textContent = `${file.body}: ${file.loadCase}`;
  byId('subtitle').textContent = file.title;
  const inside = file.tumours.length > 0 ? `, ${file.tumours.length} tumour${file.tumours.length > 1 ? 's' : ''} inside` : '';
  byId('about').textContent = `${file.file}: ${file.points.length / 3} nodes, ${file.surfaces.outside.triangles.length / 3} triangles on the surface${inside}. Keys on the picture: arrows turn, + and − zoom, R resets the view, Esc unmarks the node.`;
}

/** @param path  in the server's list; empty for a file from elsewhere */
async function open(name: string, path: string, load: () => Promise<File> | File): Promise<void> {
  const mine = ++numOpened;
  player.stop();
  try {
    const file = await ask('open', { file: await load() });
    const largest = await ask('largest', { model: file.reference, moving: false });
    if (mine !== numOpened) return; // another file was chosen meanwhile
    say('');
    result = file;
    const models = validModels(file, false, choice?.models ?? [file.reference, '']);
    choice = {
      models,
      quantity: choice?.quantity ?? 'displacement',
      skin: file.tumours.length > 0 ? 'translucent' : 'solid',
      exaggeration: nearestExaggeration(goodExaggeration(file.points, largest.displacement)),
      frame: null,
      node: null,
    };
    byId('welcome').hidden = true;
    byId('compare').hidden = false;
    describe(file);
    stage.setBody(file.points, file.surfaces);
    await apply(choice);
    await modes.opened(file, path);
  } catch (error) {
    if (mine === numOpened) complain(name, error);
  }
}

const openListed = (path: string) => {
  history.replaceState(null, '', `#${encodeURIComponent(path)}`);
  return open(path, path, () => fetchFile(path));
};

new ResizeObserver(() => {
  byId('stage').dataset['arrangement'] = canvas.clientWidth >= canvas.clientHeight ? 'beside' : 'below';
}).observe(canvas);
listen({ change, setMoving }, stage, () => choice);
acceptFiles((file) => {
  byId<HTMLSelectElement>('files').selectedIndex = -1;
  history.replaceState(null, '', location.pathname);
  void open(file.name, '', () => file);
});
const files = await listedFiles();
fillList(files, (path) => void openListed(path));
const wanted = decodeURIComponent(location.hash.slice(1));
const first = files.find(({ path }) => path === wanted) ?? files[0];
if (first) {
  byId<HTMLSelectElement>('files').value = first.path;
  await openListed(first.path);
}
