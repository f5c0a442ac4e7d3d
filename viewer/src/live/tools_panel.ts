// The tool, and where it is, as controls: what mouse and finger do can be done with them alone.
import { byId } from '../page/elements.ts';
import { choose, goalOf, pushTo, resize, type Hand, type Kind } from './hand.ts';
import { tell } from './readings.ts';

const form = () => byId<HTMLFormElement>('live-tools');
const input = (id: string) => byId<HTMLInputElement>(id);

export interface ToolActions {
  hand(): Hand;
  change(hand: Hand): void;
  touch(): void;
  letGo(): void;
}

export const nodeField = () => input('live-node');
export const stays = () => input('live-stays').checked;

export function listenToTools({ hand, change, touch, letGo }: ToolActions): void {
  form().addEventListener('submit', (event) => event.preventDefault());
  form().addEventListener('change', (event) => {
    const { name, value } = event.target as HTMLInputElement;
    if (name === 'tool') change(choose(hand(), value as Kind));
  });
  input('live-radius').addEventListener('input', () => change(resize(hand(), input('live-radius').valueAsNumber / 1000)));
  input('live-depth').addEventListener('input', () => change(pushTo(hand(), input('live-depth').valueAsNumber / 1000)));
  nodeField().addEventListener('keydown', (event) => event.key === 'Enter' && touch());
  byId('live-touch').addEventListener('click', touch);
  byId('live-let-go').addEventListener('click', letGo);
}

/** Makes the controls say what the hand does. */
export function showHand(hand: Hand): void {
  (form().elements.namedItem('tool') as RadioNodeList).value = hand.kind;
  const isTool = hand.kind !== 'none';
  for (const id of ['live-radius', 'live-depth', 'live-touch']) (byId(id) as HTMLInputElement).disabled = !isTool;
  (byId('live-let-go') as HTMLButtonElement).disabled = hand.grasp === null;
  if (hand.kind === 'none') return;
  const depth = goalOf(hand);
  tell('live-radius-shown', hand.radius[hand.kind], `${1000 * hand.radius[hand.kind]} mm`);
  input('live-radius').value = String(1000 * hand.radius[hand.kind]);
  byId('live-depth-name').textContent = depth < 0 ? 'Drawn out by' : 'Pushed in by';
  const words = `${(1000 * Math.abs(depth)).toFixed(1)} mm`;
  tell('live-depth-shown', depth, words);
  input('live-depth').value = String(1000 * depth);
  input('live-depth').setAttribute('aria-valuetext', `${byId('live-depth-name').textContent} ${words}`);
  if (hand.grasp) nodeField().value = String(hand.grasp.node);
}
