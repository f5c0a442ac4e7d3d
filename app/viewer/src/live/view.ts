// The live page: a body, an engine that moves it, and the tool of who looks at it.
import type { Result } from '../data/types.ts';
import { byId } from '../page/elements.ts';
import { savePicture } from '../page/save.ts';
import type { Skin } from '../picture/body.ts';
import { watchPageColours } from '../picture/page_colours.ts';
import { showDisc } from './tool/disc.ts';
import { startFollowing, type Following } from './following.ts';
import { atRest, goOn, isHolding, letGo, take, toolOf, type ToolState } from './tool/tool_state.ts';
import { heldTool, linkedDone, writeDone, type Done, type HeldTool } from './done_link.ts';
import { linkedLook, linkedSettings, writeLiveLink } from './live_link.ts';
import { liveFrame } from './live_picture.ts';
import { chosenStroke, drawStroke, listenToBlade, showCut, showRegions } from './tool/blade/blade_panel.ts';
import { bodyAfter } from './tool/blade/cut_body.ts';
import type { CutAnswer, CutRequest } from './tool/blade/types.ts';
import { chosenTarget, isCapsuleWhole, showNeedle, showTargets } from './tool/needle/needle_panel.ts';
import { targetFrom, valuesOf } from './tool/needle/way.ts';
import { showGrasp } from './tool/jaws/jaws_panel.ts';
import { createNodeReading } from './node_reading.ts';
import { createPointer, listenToKeys, type Handling } from './tool/pointer.ts';
import { createBudget, remedies, showFrame } from './readings.ts';
import { csvOf, download, moveOf, type Entry } from './record.ts';
import { createScene, probeMark, sizeOf, type Scene } from './scene.ts';
import { startSession, type Listener, type Session } from './session.ts';
import { listenToSettings, settingsOf, showChosen, showLaws, showSettings, type EngineKind } from './settings_panel.ts';
import { nativeEngine } from './engines/socket_engines.ts';
import { furthest, surfaceAt } from './surface.ts';
import { listenToTools, nodeField, showToolState, stays } from './tool/tools_panel.ts';
import { drawTrace } from './trace.ts';
import { createUndo, type Before } from './undo.ts';
import type { Chosen, LiveBody, LiveFrame, LiveSettings } from './types.ts';
import { wasmEngine } from './engines/wasm_engine.ts';

/** Whether the page has springs in WebAssembly: see vite.config.js. */
declare const HAS_KERNEL: boolean;

const engineKind = () => byId<HTMLSelectElement>('live-engine').value as EngineKind;
const fitting = 'The springs are being fitted to the body…';

export interface LiveView {
  /** Sets a body in motion; the same body goes on. @param view  of the link that it was opened with, or empty */
  show(result: Result, body: LiveBody, view: URLSearchParams): Promise<void>;
  hide(): void;
  /** What a link to this view says; null before the springs are there. */
  link(): URLSearchParams | null;
}

/** @param say  shows a sentence about what went wrong, or none @param changed  a link would be another one now */
export function createLiveView(say: (sentence: string) => void, changed: () => void): LiveView {
  let result: Result | null = null;
  let body: LiveBody | null = null;
  let whole: LiveBody | null = null; // before all cuts
  let lastCut: CutAnswer | null = null; // whose remains the body is
  let cuts: CutRequest[] = []; // that have been made
  let linked: Done | null = null; // what a link says that is still to be done
  let undone: Before | null = null; // that the engine is asked to go back to
  let session: Session | null = null;
  let settings: LiveSettings | null = null;
  let entries: Entry[] = [];
  let toolState: ToolState = atRest;
  let frame: LiveFrame | null = null;
  let isPaused = false;
  let wasPaused = false; // before it was hidden
  let numStarted = 0;
  let tracedAt = 0;
  let steps: Chosen | null = null; // that are taken
  const budget = createBudget(() => steps && body && {
    chosen: steps, numTetrahedra: body.tetrahedra.length / 4, hasNeedle: toolState.kind === 'needle' && toolState.grasp !== null,
    isOfGlass: byId<HTMLInputElement>('live-translucent').checked, mayBeNative: engineKind() !== 'native' && body.file !== '' });
  const undoing = createUndo();
  const reading = createNodeReading();
  const canvas = document.querySelector<HTMLCanvasElement>('#live-stage canvas')!;
  const calm = matchMedia('(prefers-reduced-motion: reduce)');
  const note = (sentence: string) => (byId('live-note').textContent = sentence);
  const complain = (error: unknown) => say(error instanceof Error ? error.message : String(error));

  function change(next: ToolState): void {
    if (isPaused && next.grasp && !toolState.grasp) note('It pauses; “Go on”, or Space on the picture.');
    toolState = next;
    showToolState(toolState);
    showWaiting();
    session?.wake();
    changed();
  }
  /** Ball or plate stand beside the node that they would touch, so that one sees what there is to touch with. */
  function showWaiting(): void {
    const { kind, grasp } = toolState;
    const place = body && (kind === 'probe' || kind === 'plate') && !grasp ? surfaceAt(body, frame?.displacement ?? new Float32Array(body.points.length), nodeField().valueAsNumber) : null;
    const waiting = place && toolOf(take(toolState, place));
    scene.setWaiting(waiting && (waiting.kind === 'probe' || waiting.kind === 'plate') ? probeMark(waiting, waiting.target) : null);
  }
  /** Where a needle goes that enters here. */
  function needleAt({ point, inwards }: Parameters<Handling['take']>[0]) {
    const target = targetFrom(point, inwards, chosenTarget(body!, result!.lesions));
    return { target, values: valuesOf(toolState.radius.needle, isCapsuleWhole()) };
  }
  /** Keeps what there is before a tool is taken. */
  function keep(): void {
    undoing.keep({ toolState, cut: lastCut, cuts });
    session?.keep();
  }
  function takeAt(place: Parameters<Handling['take']>[0]): void {
    keep();
    say(''); // what was wrong with another place
    change(take(toolState, place, toolState.kind === 'needle' ? needleAt(place) : null));
  }
  const handling: Handling = {
    toolState: () => toolState, change, take: takeAt, drawStroke,
    cutAlong: (stroke) => whole && cut(chosenStroke(stroke, sizeOf(whole))),
    body: () => body, stays, say: note };
  const pointer = createPointer(canvas, () => scene.stage, handling);
  const scene: Scene = createScene(canvas, { takesPress: pointer.takesPress, onDrawn: budget.draw, onPick: read, onTurned: changed });
  const following: Following = startFollowing(scene, tellNode, complain);

  function touch(): void {
    const node = nodeField().valueAsNumber;
    if (!body || !isHolding(toolState.kind)) return;
    const isNode = Number.isInteger(node) && node >= 0 && node < body.points.length / 3;
    const place = isNode ? surfaceAt(body, frame?.displacement ?? new Float32Array(body.points.length), node) : null;
    if (place) takeAt(place);
    note(place ? '' : isNode ? `Node ${node} is inside or constrained; take one of the free surface, such as ${furthest(body, [0, -1, 0])}.` : 'There is no such node.');
  }
  /** Says from now on what is there at a node. */
  function read(node: number | null): void {
    if (!body) return;
    if (node !== null) nodeField().value = String(node);
    showWaiting();
    reading.read(body, node);
    scene.setNode(node);
    tellNode();
  }
  function tellNode(): void {
    if (frame) reading.show(frame.displacement, following.truth(), following.isUnloaded());
  }
  function undo(): void {
    undone = undoing.take();
    if (!undone) return;
    session?.restore();
    // The next frame is already that of the tool as it was.
    change(undone.toolState);
  }
  function cut(request: CutRequest): void {
    if (toolState.grasp) letToolGo();
    say('');
    note('Cutting…');
    session?.cut(request);
  }
  /** The body is from now on what a cut has left, or whole. */
  function showRemains(answer: CutAnswer | null): void {
    if (!whole || !settings || answer === lastCut) return;
    lastCut = answer;
    body = answer ? bodyAfter(whole, answer) : whole;
    scene.setRemains(body);
    following.open(body, settings);
    showCut(answer);
    byId('live-reset').textContent = answer ? 'Whole again, at rest' : 'Back to rest';
    nodeField().max = String(body.points.length / 3 - 1);
    nodeField().value = String(furthest(body, [0, -1, 0]));
    showWaiting();
  }
  function showGlass(): void {
    byId<HTMLInputElement>('live-translucent').checked = true;
    scene.setSkin('translucent');
  }
  /** A needle is inside: the body is of glass then. */
  function changeTool(next: ToolState): void {
    if (next.kind === 'needle' && toolState.kind !== 'needle') showGlass();
    change(next);
  }
  /** Goes on with what a link says, in its order. */
  function doLinked(): void {
    const next = linked?.cuts.shift();
    if (next) return cut(next);
    const tool = linked?.tool;
    linked = null;
    if (tool && tool.grasp.node < body!.points.length / 3) takeLinked(tool); // parted nodes are there by now
  }
  function takeLinked({ kind, radius, grasp }: HeldTool): void {
    keep();
    changeTool({ ...toolState, kind, radius: { ...toolState.radius, [kind]: radius }, grasp });
  }
  const letToolGo = () => change(letGo(toolState));
  const pause = () => session?.pause(!isPaused);
  const step = () => session?.step();

  /** A trace that goes on by itself is motion too: who wants less of it gets it in steps. */
  function trace(): void {
    const now = performance.now();
    if (calm.matches && !isPaused && now - tracedAt < 1000) return;
    tracedAt = now;
    drawTrace(byId<HTMLCanvasElement>('live-trace'), entries);
  }

  watchPageColours(() => drawTrace(byId<HTMLCanvasElement>('live-trace'), entries));

  const listener: Listener = {
    tool(elapsed) {
      toolState = goOn(toolState, elapsed);
      return toolOf(toolState);
    },
    moved(tool, numSteps, next, timing) {
      entries.push(moveOf(tool, numSteps, next));
      following.follow(next);
      frame = next;
      scene.showSprings(next, tool);
      tellNode();
      showFrame(next, numSteps);
      showDisc(body!, tool, next);
      showNeedle(tool, next);
      showGrasp(next);
      budget.spend(timing);
      trace();
    },
    chosen(asked, chosen) {
      settings = asked;
      steps = chosen;
      entries.push({ kind: 'choose', settings: asked, chosen });
      following.choose(asked);
      showSettings(asked);
      showChosen(chosen);
      byId('live').dataset['state'] = 'moving';
      note('');
      changed();
      doLinked();
    },
    wasReset() {
      entries.push({ kind: 'reset' });
      letToolGo();
      undoing.forget();
      cuts = [];
      showRemains(null);
    },
    wasKept() {
      entries.push({ kind: 'keep' });
    },
    wasRestored() {
      entries.push({ kind: 'undo' });
      cuts = undone?.cuts ?? [];
      showRemains(undone?.cut ?? null);
      changed();
    },
    wasCut(request, answer) {
      entries.push({ kind: 'cut', request, answer });
      undoing.keep({ toolState: letGo(toolState), cut: lastCut, cuts });
      cuts = [...cuts, request];
      showRemains(answer);
      changed();
      note(answer.closed.volume > 0 ? 'This leaves a closed cavity; “Cut” says how large and how deep.' : '');
      // What was cut out of the inside is seen through glass alone.
      if (request.tool.kind === 'region') showGlass();
      doLinked();
    },
    notCut(error) {
      note('');
      complain(error);
      doLinked();
    },
    slept(isAsleep, isAtRest) {
      byId('live').dataset['asleep'] = String(isAsleep);
      byId('live').dataset['atRest'] = String(isAtRest);
      byId('live-rest').hidden = !isAtRest;
      following.rest(isAtRest);
      if (isAtRest) budget.rest();
    },
    failed(error, kept) {
      complain(error);
      if (!kept && ['needle', 'grasp', 'plate'].includes(toolState.kind) && toolState.grasp) {
        // It cannot go there: another one may.
        letToolGo();
        session?.pause(false);
        return;
      }
      if (kept) showSettings(kept);
      byId('live').dataset['state'] = 'fault';
    },
    paused(pauses) {
      isPaused = pauses;
      byId('live-pause').textContent = pauses ? '▶ Go on' : '❚❚ Pause';
      (byId('live-step-once') as HTMLButtonElement).disabled = !pauses;
    },
  };

  /** From rest: no engine knows what another one has moved. */
  async function start(of: LiveBody): Promise<void> {
    const mine = ++numStarted;
    session?.close();
    session = null;
    entries = [];
    cuts = [];
    showRemains(null);
    frame = null;
    undoing.forget();
    letToolGo();
    say('');
    note(fitting);
    byId('live').dataset['state'] = 'starting';
    listener.slept(false, false); // another engine may have been asleep
    const engine = engineKind() === 'native' ? nativeEngine() : wasmEngine();
    try {
      const { springLaws } = await engine.open(of);
      if (mine !== numStarted) return engine.close();
      settings = showLaws(springLaws, settings ?? settingsOf(of));
      following.open(of, settings);
      session = startSession(engine, sizeOf(of), settings, listener);
      listener.paused(false);
    } catch (error) {
      engine.close();
      if (mine === numStarted) listener.failed(error, null);
    }
  }

  listenToBlade(cut);
  listenToTools({ toolState: () => toolState, change: changeTool, touch, letGo: letToolGo });
  listenToKeys(canvas, () => scene.stage, { ...handling, touch, pause, step, undo });
  const choose = (asked: LiveSettings) => (say(''), note(fitting), session?.choose(asked));
  listenToSettings(() => settings, choose, say);
  /** No engine knows what another one has moved: it does the cuts again, and takes the tool that stays. */
  function changeEngine(): void {
    if (!whole) return;
    linked = { cuts: [...cuts, ...(linked?.cuts ?? [])], tool: linked?.tool ?? heldTool(toolState) };
    void start(whole);
  }
  byId('live-engine').addEventListener('change', changeEngine);
  /** @param then  what makes it faster */
  const listenToRemedy = (id: string, then: () => void) => byId(id).addEventListener('click', () => ((byId(id).hidden = true), then()));
  listenToRemedy(remedies.native, () => {
    byId<HTMLSelectElement>('live-engine').value = 'native';
    changeEngine();
  });
  listenToRemedy(remedies.longest, () => settings && choose({ ...settings, timeStep: 0 }));
  listenToRemedy(remedies.opaque, () => scene.setSkin('solid'));
  byId('live-pause').addEventListener('click', pause);
  byId('live-step-once').addEventListener('click', step);
  nodeField().addEventListener('input', showWaiting);
  byId('live-reset').addEventListener('click', () => session?.reset());
  byId('live-undo').addEventListener('click', undo);
  byId('live-view').addEventListener('click', () => scene.stage.resetView());
  byId('live-save').addEventListener('click', () => download('livermark_live.csv', csvOf(entries)));
  byId('live-skin').addEventListener('change', (event) => scene.setSkin((event.target as HTMLInputElement).value as Skin));
  byId('live-save-picture').addEventListener('click', () => {
    if (result && settings) savePicture(scene.stage, byId('live-stage'), liveFrame(result, settings, scene.legend())).catch(complain);
  });
  byId('live').addEventListener('change', changed);
  showToolState(toolState);

  return {
    async show(of, next, view) {
      if (next === whole) return session?.pause(wasPaused);
      [result, body, whole, lastCut] = [of, next, next, null];
      showCut(null);
      const isLinked = view.get('mode') === 'live';
      scene.setBody(of, next);
      showTargets(of.lesions);
      showRegions(of.lesions);
      read(null);
      nodeField().max = String(next.points.length / 3 - 1);
      nodeField().value = String(furthest(next, [0, -1, 0]));
      showWaiting();
      const isServed = next.file !== '';
      const engines = byId<HTMLSelectElement>('live-engine');
      engines.options[0]!.disabled = !HAS_KERNEL;
      engines.options[1]!.disabled = !isServed;
      if (!isServed || !HAS_KERNEL) engines.value = isServed ? 'native' : 'wasm';
      if (!isServed && !HAS_KERNEL) return say(`This page has no springs of its own; open the file with \`livermark view\`, or run scripts/live-kernel and make the page again.`);
      settings = isLinked ? linkedSettings(view, settingsOf(next)) : null;
      linked = isLinked ? linkedDone(view) : null;
      await start(next);
      if (!isLinked || next !== whole) return;
      const look = linkedLook(view, scene.look());
      if (look.hasElements) following.switchOn();
      scene.setLook(look);
    },
    link() {
      if (!settings) return null;
      const link = writeLiveLink(settings, { ...scene.look(), hasElements: following.isOn() });
      // What is not done yet is in the link all the same.
      writeDone(link, { cuts: [...cuts, ...(linked?.cuts ?? [])], tool: linked?.tool ?? heldTool(toolState) });
      return link;
    },
    hide() {
      wasPaused = isPaused;
      letToolGo();
      session?.pause(true);
    },
  };
}
