// The page: files are opened, compared or set in motion, and the address says what is shown.
import './style.css';
import type { OpenExperiment } from './data/client.ts';
import { courseOf, Fault, type Result } from './data/types.ts';
import { createExperimentView } from './experiment/view.ts';
import { createModes } from './modes.ts';
import { createCompareView, type Prepared } from './page/compare.ts';
import { listen } from './page/controls.ts';
import { byId } from './page/elements.ts';
import { acceptFiles, fetchFile, fillList, firstOf, inOrder, listedFiles, showListed } from './page/files.ts';
import { linkTo, placeOf, readLink, type Link } from './page/link.ts';
import { createOpening } from './page/opening.ts';
import { createPlayer } from './page/player.ts';
import { comparedFrame, savePicture, saveTable } from './page/save.ts';
import { createSlices } from './page/slices.ts';
import { atLoad, validModels } from './page/state.ts';
import { listenToTheme } from './page/theme.ts';
import { vesselsInWords } from './page/vessels_key.ts';
import { short } from './picture/scale.ts';
import { createStage, type Stage } from './picture/stage.ts';

const canvas = document.querySelector<HTMLCanvasElement>('#stage canvas')!;
let path = ''; // of the file that is shown, in the server's list
let linkTimer = 0;

listenToTheme();
const stage = startStage();
const slices = createSlices(writeLink);
const compare = createCompareView(stage, { complain, drawn: (...drawn) => (slices.show(...drawn), writeLink()) });
const modes = createModes({ say, complain, changed: writeLink });
const experiment = createExperimentView({ complain, changed: writeLink });
const player = createPlayer(() => compare.result()?.frameTimes ?? [], () => compare.choice()?.frame ?? 0, (frame) => compare.apply({ frame }));

function startStage(): Stage {
  try {
    return createStage(canvas, { onPick: (node) => void compare.apply({ node }), onTurned: writeLink });
  } catch (error) {
    say('This browser cannot draw in three dimensions: switch on WebGL 2 in its settings, or open the page in another.');
    throw error;
  }
}

function say(sentence: string): void {
  byId('message').textContent = sentence;
  byId('message').hidden = sentence === '';
}

function complain(name: string, error: unknown): void {
  const sentence = error instanceof Fault ? error.message : `It cannot be shown (${String(error)}).`;
  say(`${name}: ${sentence}`);
}

const fragment = () => {
  const ofExperiment = experiment.link(path);
  if (ofExperiment !== null) return ofExperiment;
  const [result, choice] = [compare.result(), compare.choice()];
  if (!result || !choice) return '';
  const live = modes.liveLink()?.toString().replaceAll('%2C', ',');
  const through = slices.link();
  return linkTo(path, result, choice, stage.cameraPlace()) + (through ? `&slices=${through}` : '') + (live ? `&${live}` : '');
};

/** The address is that of the view, a moment after it came to rest: browsers count changes. */
function writeLink(): void {
  clearTimeout(linkTimer);
  document.body.dataset['address'] = 'behind';
  linkTimer = window.setTimeout(() => {
    history.replaceState(null, '', location.pathname + location.search + fragment());
    document.body.dataset['address'] = 'shown';
  }, 250);
}

function describe(file: Result): void {
  document.title = `${file.body}, ${file.loadCase} – Livermark`;
  byId('title').textContent = byId('live-title').textContent = `${file.body}: ${file.loadCase}`;
  byId('subtitle').textContent = file.title;
  const lesions = file.lesions.map(({ name, volume }) => `${name.replaceAll('_', ' ')} (${(1e6 * volume).toPrecision(3)} mL)`);
  const inside = lesions.length > 0 ? ` Inside: ${lesions.join(', ')}.` : '';
  const parts = [file.capsule ? `capsule: E t = ${short(file.capsule.youngModulus * file.capsule.thickness)} N/m` : '', file.vessels ? `vessels: ${vesselsInWords(file)}` : ''].filter(Boolean).join('; ');
  const has = parts ? ` ${parts[0]!.toUpperCase()}${parts.slice(1)}.` : '';
  const axes = file.isAnatomical ? ' x points to the patient’s left, y to the back, z to the head.' : '';
  byId('about').textContent = `${file.file}: ${file.points.length / 3} nodes, ${file.surfaces.outside.triangles.length / 3} triangles on the surface.${inside}${has}${axes} Keys on the picture: arrows turn, + and − zoom, R resets the view, Esc unmarks the node.`;
}

function showResult(prepared: Prepared, link: Link): void {
  experiment.hide();
  byId('compare').hidden = false;
  describe(prepared.file.result);
  slices.open(prepared.file.result, path, link.view);
  compare.show(prepared);
  const camera = placeOf(link.view.get('camera'));
  if (camera) stage.setCameraPlace(camera);
  void modes.opened(prepared.file, path, link.view);
}

function showExperiment(opened: OpenExperiment, link: Link): void {
  modes.closed();
  compare.close();
  experiment.show(opened, link.view);
}

const open = createOpening<Prepared | OpenExperiment>({
  prepare: async (file, link) => ('experiment' in file ? file : compare.prepare(file, link.view)),
  accept(prepared, link) {
    say('');
    player.stop();
    path = link.path;
    byId('welcome').hidden = true;
    if ('experiment' in prepared) showExperiment(prepared, link);
    else showResult(prepared, link);
    showListed(path);
    writeLink();
  },
  refuse(name, error) {
    showListed(path);
    if (error !== null) complain(name, error);
  },
});

const openListed = (listed: string, view = new URLSearchParams()) =>
  open(listed, { path: listed, view }, (signal, onProgress) => fetchFile(listed, signal, onProgress));

function setMoving(isMoving: boolean): void {
  const [result, choice] = [compare.result(), compare.choice()];
  if (!result || !choice) return;
  player.stop();
  void compare.apply({ frame: isMoving ? 0 : null, models: validModels(result, isMoving ? 'motion' : courseOf({ ...choice, frame: null }), choice.models) });
}

function setPoint(chosen: number): void {
  const [result, choice] = [compare.result(), compare.choice()];
  if (!result || !choice) return;
  player.stop();
  void compare.apply(atLoad(result, choice, chosen));
}

async function copyLink(button: HTMLElement): Promise<void> {
  history.replaceState(null, '', location.pathname + location.search + fragment());
  try {
    await navigator.clipboard.writeText(location.href);
    button.textContent = 'Link copied';
  } catch {
    button.textContent = 'The link is in the address';
  }
  setTimeout(() => (button.textContent = 'Copy link'), 2500);
}

/** Calls back with what is shown, if anything is. */
const ofShown = (action: (result: Result) => unknown) => () => {
  const result = compare.result();
  if (result) void action(result);
};

new ResizeObserver(() => {
  byId('stage').dataset['arrangement'] = canvas.clientWidth >= canvas.clientHeight ? 'beside' : 'below';
}).observe(canvas);
listen({ change: (part) => void compare.apply(part), setMoving, setPoint }, stage, compare.result, compare.choice);
for (const id of ['copy_link', 'live-copy-link', 'experiment-copy-link']) byId(id).addEventListener('click', () => void copyLink(byId(id)));
byId('save_picture').addEventListener('click', ofShown((result) => savePicture(stage, byId('stage'), comparedFrame(result, compare.choice()!)).catch((error) => complain('The picture', error))));
byId('save_table').addEventListener('click', ofShown(() => saveTable(compare.seen()!, compare.choice()!)));
// A link to a view of a file from elsewhere is for the first such file.
const firstView = () => (compare.result() || experiment.link('') ? new URLSearchParams() : readLink(location.hash).view);
acceptFiles((file) => void open(file.name, { path: '', view: firstView() }, () => file));

const files = inOrder(await listedFiles());
fillList(files, (listed) => void openListed(listed));

/** Opens what the address names. */
async function openAddress(): Promise<void> {
  const asked = readLink(location.hash);
  const named = files.find((file) => file.path === asked.path) ?? firstOf(files);
  if (!named) return;
  const isMissing = asked.path !== '' && named.path !== asked.path;
  await openListed(named.path, isMissing ? undefined : asked.view);
  if (isMissing && path === named.path) say(`${asked.path} is not in the list; ${named.path} is shown.`);
}
window.addEventListener('hashchange', () => void openAddress());
await openAddress();
