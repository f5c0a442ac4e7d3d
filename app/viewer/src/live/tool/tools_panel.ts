// The tool, and where it is, as controls: what mouse and finger do can be done with them alone.
import { byId } from '../../page/elements.ts';
import { showBladeControls } from './blade/blade_panel.ts';
import { showGraspReadings } from './jaws/jaws_panel.ts';
import { showNeedleControls } from './needle/needle_panel.ts';
import { choose, depths, goalOf, isHolding, pushTo, resize, type ToolState, type Kind } from './tool_state.ts';
import { tell } from '../readings.ts';

const form = () => byId<HTMLFormElement>('live-tools');
const input = (id: string) => byId<HTMLInputElement>(id);

export interface ToolActions {
  toolState(): ToolState;
  change(toolState: ToolState): void;
  touch(): void;
  letGo(): void;
}

export const nodeField = () => input('live-node');
let wantsToStay = false; // what the reader wants of other tools than a needle
/** Whether a tool stays where it is when it is let go: as the reader wants, and a needle always. */
export const stays = () => input('live-stays').checked;

export function listenToTools({ toolState, change, touch, letGo }: ToolActions): void {
  form().addEventListener('submit', (event) => event.preventDefault());
  form().addEventListener('change', (event) => {
    const { name, value } = event.target as HTMLInputElement;
    if (name === 'tool') change(choose(toolState(), value as Kind));
  });
  input('live-stays').addEventListener('change', () => (wantsToStay = stays()));
  input('live-radius').addEventListener('input', () => change(resize(toolState(), input('live-radius').valueAsNumber / 1000)));
  input('live-depth').addEventListener('input', () => change(pushTo(toolState(), input('live-depth').valueAsNumber / 1000)));
  nodeField().addEventListener('keydown', (event) => event.key === 'Enter' && touch());
  byId('live-touch').addEventListener('click', touch);
  byId('live-let-go').addEventListener('click', letGo);
}

/** @param depth  that is asked for [m] */
function depthName(kind: Kind, depth: number): string {
  if (kind === 'needle') return 'Tip led to';
  if (kind === 'grasp') return depth < 0 ? 'Jaws open by' : 'Jaws close by';
  return depth < 0 ? 'Drawn out by' : 'Pushed in by';
}

/** Makes the controls say what the tool does. */
export function showToolState(toolState: ToolState): void {
  (form().elements.namedItem('tool') as RadioNodeList).value = toolState.kind;
  const isTool = isHolding(toolState.kind);
  if (byId('live-needle').hidden === (toolState.kind === 'needle')) showNeedleControls(toolState.kind === 'needle');
  showGraspReadings(toolState.kind === 'grasp');
  if (toolState.kind !== 'needle') byId('live-radius-name').textContent = toolState.kind === 'plate' ? 'Half a side' : 'Radius';
  byId('live-felt').hidden = toolState.kind === 'needle' || toolState.kind === 'grasp';
  input('live-stays').checked = wantsToStay || toolState.kind === 'needle';
  input('live-stays').disabled = toolState.kind === 'needle';
  showBladeControls(toolState.kind === 'blade');
  for (const id of ['live-radius', 'live-depth', 'live-touch']) (byId(id) as HTMLInputElement).disabled = !isTool;
  (byId('live-let-go') as HTMLButtonElement).disabled = toolState.grasp === null;
  if (!isHolding(toolState.kind)) return;
  const depth = goalOf(toolState);
  const [least, most] = depths(toolState);
  input('live-depth').min = String(Math.round(1000 * least));
  input('live-depth').max = String(Math.ceil(1000 * most));
  tell('live-radius-shown', toolState.radius[toolState.kind], `${1000 * toolState.radius[toolState.kind]} mm`);
  input('live-radius').value = String(1000 * toolState.radius[toolState.kind]);
  byId('live-depth-name').textContent = depthName(toolState.kind, depth);
  const words = toolState.kind === 'needle' && !toolState.grasp && depth === 0 ? 'the target' : `${(1000 * Math.abs(depth)).toFixed(1)} mm`;
  tell('live-depth-shown', depth, words);
  input('live-depth').value = String(1000 * depth);
  input('live-depth').setAttribute('aria-valuetext', `${byId('live-depth-name').textContent} ${words}`);
  if (toolState.grasp) nodeField().value = String(toolState.grasp.node);
}
