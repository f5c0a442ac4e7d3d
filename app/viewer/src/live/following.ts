// Finite elements beside the springs: on or off, and what is said of them.
import { byId } from '../page/elements.ts';
import { percent } from '../picture/scale.ts';
import { tell } from './readings.ts';
import type { Scene } from './scene.ts';
import { femEngine } from './engines/socket_engines.ts';
import { inWords, isCompared, isLoaded, startAsking, stiffnessRatio, type Asking, type Truth } from './truth.ts';
import type { Elements, LiveBody, LiveFrame, LiveSettings } from './types.ts';

export interface Following {
  /** What FEM has said to the forces of now, if it has. */
  truth(): Truth | null;
  /** Whether FEM is at rest because nothing acts on the body. */
  isUnloaded(): boolean;
  open(body: LiveBody, settings: LiveSettings): void;
  choose(settings: LiveSettings): void;
  /** Whether it is on. */
  isOn(): boolean;
  /** Switches it on, if there is a server that solves. */
  switchOn(): void;
  follow(frame: LiveFrame): void;
  /** Whether the body rests where the last frame has it. */
  rest(isAtRest: boolean): void;
}

const readings = ['live-fem-force', 'live-fem-springs', 'live-fem-indentation', 'live-fem-elements', 'live-fem-off', 'live-fem-error'];
const tellProgress = (sentence: string) => (byId('live-fem-progress').textContent = sentence);
const box = () => byId<HTMLInputElement>('live-fem');

const captions: Record<Elements, string> = { linear: 'FEM, linear', hyperelastic: 'FEM, hyperelastic' };
const stillMoving = 'still moving: springs have inertia and damping, FEM has not';

function tellTruth(truth: Truth): void {
  const { force, springs, elements, error, isAtRest } = truth;
  const isNeedle = truth.apart !== null;
  byId('live-fem-springs-name').textContent = isNeedle ? 'Springs move the target by' : 'Springs give way by';
  byId('live-fem-elements-name').textContent = isNeedle ? 'FEM moves the target by' : 'FEM gives way by';
  byId('live-fem-off-row').hidden = isNeedle;
  byId('live-fem-caption').textContent = `${captions[truth.judge]}: ${isNeedle ? 'motion of the target by the same needle' : 'indentation by the same round load'}`;
  // A moment of the springs beside elements at rest says nothing of either.
  const areCompared = isCompared(truth);
  const off = areCompared ? stiffnessRatio(truth) - 1 : Number.NaN;
  const mm = (metres: number) => `${(1000 * metres).toFixed(2).replace('-', '−')} mm`;
  tell('live-fem-force', force, `${force.toFixed(2)} N`);
  tell('live-fem-springs', springs, `${mm(springs)}${isAtRest ? '' : ', still moving'}`);
  tell('live-fem-indentation', elements, mm(elements));
  tell('live-fem-elements', elements, mm(elements));
  tell('live-fem-off', off, areCompared ? `${off > 0 ? '+' : ''}${off < 0 ? '−' : ''}${percent(Math.abs(off))} %` : '–');
  byId('live-fem-words').textContent = inWords(truth);
  tell('live-fem-error', areCompared ? error : Number.NaN, areCompared ? `${percent(error)} %` : '–');
  tell('live-fem-state', Number(isAtRest), !isAtRest ? stillMoving : areCompared ? `at rest, beside ${truth.judge} elements` : 'at rest, when hyperelastic elements have answered');
  // Nothing more is going to be said.
  byId('live-fem-readings').dataset['judged'] = String(areCompared);
}

/** @param answered  is called when there is another answer, or none any more */
export function startFollowing(scene: Scene, answered: () => void, complain: (error: unknown) => void): Following {
  let body: LiveBody | null = null;
  let settings: LiveSettings | null = null;
  let asking: Asking | null = null;
  let truth: Truth | null = null;
  let latest: LiveFrame | null = null; // of the body that is open
  let isAtRest = false; // there

  /** Nothing is touched: finite elements are at rest. */
  function forget(): void {
    truth = null;
    tellProgress('');
    for (const id of readings) tell(id, Number.NaN, '–');
    byId('live-fem-words').textContent = 'Nothing acts on the body: springs and FEM are both at rest.';
    tell('live-fem-state', Number.NaN, 'when the body is touched and FEM has answered');
    byId('live-fem-readings').dataset['judged'] = 'false';
    scene.showElements('at rest');
    answered();
  }

  function stop(): void {
    asking?.close();
    asking = null;
    tellProgress('');
    truth = null;
    box().checked = false;
    byId('live-fem-readings').hidden = byId('live-names').hidden = true;
    if (body) scene.showElements(null);
    answered();
  }

  function start(): void {
    if (!body || !settings) return stop();
    byId('live-fem-readings').hidden = byId('live-names').hidden = false;
    forget();
    const show = (answer: Truth) => {
      truth = answer;
      tellProgress('');
      tellTruth(answer);
      scene.showElements(answer);
      answered();
    };
    const fail = (error: unknown) => {
      stop();
      complain(error);
    };
    const onProgress = (sentence: string) => tellProgress(latest && isLoaded(latest) ? sentence : '');
    asking = startAsking(femEngine(onProgress), body, settings, show, fail);
    // A body that rests, or pauses, sends no more frames.
    if (latest) asking.ask(latest);
    asking.rest(isAtRest);
  }

  box().addEventListener('change', () => (box().checked ? start() : stop()));
  return {
    truth: () => truth,
    isUnloaded: () => asking !== null && latest !== null && !isLoaded(latest),
    open(next, chosen) {
      // What is left of the body after a cut is of the same materials.
      const goesOn = next.density === body?.density && box().checked;
      stop();
      body = next;
      settings = chosen;
      latest = null;
      box().disabled = next.file === '';
      byId('live-fem-hint').hidden = next.file !== '';
      if (goesOn) {
        box().checked = true;
        start();
      }
    },
    choose(chosen) {
      settings = chosen;
      asking?.choose(chosen);
    },
    isOn: () => box().checked,
    switchOn() {
      if (box().disabled || box().checked) return;
      box().checked = true;
      start();
    },
    follow(frame) {
      if (asking && truth && !isLoaded(frame)) forget();
      latest = frame;
      asking?.ask(frame);
    },
    rest(rests) {
      isAtRest = rests;
      asking?.rest(rests);
    },
  };
}
