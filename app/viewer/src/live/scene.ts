// The picture of what moves: the springs, beside them finite elements, and the tool.
import { strainMesh, type StrainMesh } from '../data/strain.ts';
import type { Result } from '../data/types.ts';
import { vesselsLeft } from '../data/vessels.ts';
import { supportedKey } from '../page/conditions_key.ts';
import { byId } from '../page/elements.ts';
import type { PictureFrame } from '../page/save.ts';
import { tissueEntries } from '../page/patch_legend.ts';
import { partsOf } from '../page/state.ts';
import { vesselsKey } from '../page/vessels_key.ts';
import type { Skin } from '../picture/body.ts';
import type { Marks } from '../picture/marks.ts';
import { liveSkin } from '../picture/materials.ts';
import type { Conditions } from '../picture/facet_conditions.ts';
import { createStage, type Hooks, type Side, type Stage } from '../picture/stage.ts';
import { cutControls, cutOf, listenToLiveCut, setCutControls } from './cut_panel.ts';
import { createForceArrow } from './tool/force_arrow.ts';
import { createLiveLegend } from './live_legend.ts';
import type { LiveLook } from './live_link.ts';
import { colouringOf, differences, shownValues } from './shown_field.ts';
import { carried, nodesThere, surfacesOf } from './tool/blade/cut_body.ts';
import { edgeOfPlate } from './tool/tool_state.ts';
import { needleMark } from './tool/needle/needle_mark.ts';
import type { Truth } from './truth.ts';
import type { LiveBody, LiveFrame, Tool } from './types.ts';
import type { Vector } from './vector.ts';

export interface Scene {
  stage: Stage;
  setBody(result: Result, body: LiveBody): void;
  /** What a cut has left of the body, or what there is of it again. */
  setRemains(body: LiveBody): void;
  showSprings(frame: LiveFrame, tool: Tool): void;
  /** Where a probe would touch, while it does not; null where there is none. */
  setWaiting(probe: Marks['probe']): void;
  /** @param truth  'at rest' while nothing is touched; null hides the second picture */
  showElements(truth: Truth | 'at rest' | null): void;
  setSkin(skin: Skin): void;
  /** Marks a node. */
  setNode(node: number | null): void;
  legend(): PictureFrame['legend'];
  /** What a link keeps of the picture. */
  look(): Omit<LiveLook, 'hasElements'>;
  setLook(look: LiveLook): void;
}

/** From the front, from the side and a little above: what presses on the front is seen from the side as well. */
const viewedFrom: Vector = [-0.6, -1, 0.45];

const vesselsBox = () => byId<HTMLInputElement>('live-vessels');

/** What of the load case is there: where nothing moves, and what stands on springs. */
function constrainedConditions({ constrained, foundation }: LiveBody): Conditions {
  return { kind: constrained, value: new Float64Array(3 * constrained.length), foundation: foundation ?? undefined };
}

/** (G,4) of some of the tetrahedra. */
const nodesOf = (tetrahedra: Int32Array, which: Int32Array) => Int32Array.from({ length: 4 * which.length }, (_, i) => tetrahedra[4 * which[i >> 2]! + (i & 3)]!);

/** Largest extent [m]. */
export function sizeOf({ points }: Pick<LiveBody, 'points'>): number {
  let [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (let i = 0; i < points.length; i++) {
    low[i % 3] = Math.min(low[i % 3]!, points[i]!);
    high[i % 3] = Math.max(high[i % 3]!, points[i]!);
  }
  return Math.max(...high.map((x, i) => x - low[i]!));
}

/** What is drawn of what touches, at a place of its centre. @param other  centre of the other jaw */
export function probeMark(tool: Extract<Tool, { kind: 'probe' | 'plate' | 'grasp' }>, centre: Vector, other?: Vector): NonNullable<Marks['probe']> {
  return tool.kind === 'plate' ? { centre, radius: edgeOfPlate * tool.radius, plate: { axis: tool.inwards, half: tool.radius } } : { centre, radius: tool.radius, other };
}

export function createScene(canvas: HTMLCanvasElement, hooks: Hooks): Scene {
  const onDrawn = (seconds: number) => {
    arrow.showKey(stage, toolAt);
    hooks.onDrawn?.(seconds);
  };
  const stage: Stage = createStage(canvas, { ...hooks, onDrawn }, 56, viewedFrom);
  const setViews = (count: 1 | 2) => {
    byId('live-stage').dataset['views'] = String(count);
    stage.setViews(count);
  };
  new ResizeObserver(() => {
    byId('live-stage').dataset['arrangement'] = canvas.clientWidth >= canvas.clientHeight ? 'beside' : 'below';
  }).observe(canvas);
  const legend = createLiveLegend(() => redraw());
  let opened: Result | null = null;
  listenToLiveCut(showCut);
  vesselsBox().addEventListener('change', showVessels);
  function showCut(): void {
    if (!opened) return;
    const cut = cutOf(opened);
    stage.setCut(cut);
    showNames(cut !== null);
    showVessels();
  }
  function showVessels(): void {
    if (!opened) return;
    const areShown = vesselsBox().checked;
    const key = byId('live-conditions');
    stage.showVessels(areShown);
    byId('live-vessels-row').hidden = opened.vessels === null;
    key.replaceChildren(key.firstElementChild!, ...supportedKey(opened), ...areShown ? vesselsKey(opened, skin === 'translucent' || cutOf(opened) !== null) : []);
  }
  function setSkin(chosen: Skin): void {
    skin = chosen;
    noteShift();
    showNames(opened !== null && cutOf(opened) !== null);
    showVessels();
    redraw();
  }
  function chooseSkin(chosen: Skin): void {
    byId('live-skin').querySelector<HTMLInputElement>(`[value=${chosen}]`)!.checked = true;
    setSkin(chosen);
  }
  const noteShift = () => legend.note(skin === 'flat' ? '' : 'Light and glass shift colours; “Exact colours” shows them as here.');
  /** Lesions are seen in glass, and where the body is cut through them. */
  const showNames = (isCut: boolean) => stage.showNames(skin === 'translucent' ? 'all' : isCut ? 'cut' : 'none');
  let arrow = createForceArrow(1);
  let toolAt: Vector | null = null;
  let skin: Skin = liveSkin;
  let waiting: Marks['probe'] = null;
  let node: number | null = null;
  let body: LiveBody | null = null;
  let mesh: StrainMesh | null = null; // made when it is needed
  const shown: [Float32Array | null, Float32Array | null] = [null, null]; // displacements of both sides
  const values: [Float32Array | null, Float32Array | null] = [null, null]; // that are coloured
  let difference: Float32Array | null = null;

  function redraw(sides: readonly Side[] = [0, 1]): void {
    const field = legend.shown();
    for (const side of sides) {
      const displacement = shown[side];
      values[side] = displacement && (field === 'tissue' ? carried(opened!.tissue, 1, body!) : shownValues(field, displacement, difference, () => (mesh ??= strainMesh(body!.points, body!.tetrahedra))));
    }
    // The colours of both sides mean the same.
    const changed: readonly Side[] = legend.see(values) ? [0, 1] : sides;
    for (const side of changed) {
      const [displacement, coloured] = [shown[side], values[side]];
      if (!displacement || !coloured) continue;
      stage.show(side, { displacement, values: coloured, end: legend.end(), quantity: colouringOf(field), skin, exaggeration: 1, node });
    }
  }

  function marksOf(frame: LiveFrame, tool: Tool): Marks {
    if (tool.kind === 'none') return { probe: waiting, grip: null, arrow: null, needle: null };
    if (tool.kind === 'needle') return { probe: null, grip: null, arrow: null, needle: needleMark(tool, frame) };
    return {
      probe: tool.kind === 'pull' ? null : probeMark(tool, frame.tool, frame.grasp?.other),
      grip: tool.kind === 'pull' ? frame.tool : null,
      arrow: arrow.of(frame),
      needle: null,
    };
  }

  return {
    stage,
    setBody(result, next) {
      stage.setBody(result.points, result.surfaces, { ...partsOf(result), conditions: constrainedConditions(next) });
      setCutControls('', 50); // another body is whole at first
      showNames(false);
      opened = result;
      body = next;
      mesh = null;
      node = null;
      arrow = createForceArrow(sizeOf(next));
      [shown[1], difference, toolAt, waiting] = [null, null, null, null];
      shown[0] = new Float32Array(result.points.length);
      setViews(1);
      legend.allowDifference(false);
      legend.setTissue(tissueEntries(result));
      // A liver looks like one until somebody asks for numbers.
      if (result.isAnatomical) legend.set('tissue', null);
      chooseSkin(result.isAnatomical ? 'translucent' : skin);
    },
    setRemains(next) {
      if (!opened) return;
      const there = nodesThere(next);
      const parts = partsOf(opened);
      const labels = parts.labels?.filter((label) => there.has(label.node)) ?? [];
      const firstOfWound = next.cuts ? next.cuts.wound.indexOf(1) : -1;
      stage.replaceBody(next.cuts ? Float32Array.from(next.points) : opened.points, next.cuts ? surfacesOf(next) : opened.surfaces,
        { ...parts, patches: next.cuts ? undefined : parts.patches, conditions: constrainedConditions(next), tetrahedra: next.tetrahedra, labels, firstOfWound,
          vessels: parts.vessels && next.cuts ? vesselsLeft(parts.vessels, nodesOf(opened.tetrahedra, next.cuts.gone), next) : parts.vessels });
      body = next;
      mesh = null;
      toolAt = null;
      // Until the next frame new nodes are where those are that they were parted from.
      const numWhole = opened.points.length;
      shown.forEach((displacement, side) => (shown[side] = displacement && carried(displacement.subarray(0, numWhole), 3, next)));
      difference = null;
      if (node !== null && !there.has(node)) node = null;
      redraw();
    },
    showSprings(frame, tool) {
      toolAt = tool.kind === 'none' || tool.kind === 'needle' ? null : frame.tool;
      shown[0] = frame.displacement;
      stage.mark(0, marksOf(frame, tool));
      redraw([0]);
    },
    setWaiting(probe) {
      waiting = probe;
      if (toolAt === null) stage.mark(0, { probe, grip: null, arrow: null, needle: null });
    },
    showElements(truth) {
      const had = shown[1] !== null;
      const answer = truth === null || truth === 'at rest' ? null : truth;
      shown[1] = truth === null ? null : (answer?.displacement ?? new Float32Array(shown[0]!.length));
      difference = answer && differences(answer.frame.displacement, answer.displacement);
      legend.setMoving(answer !== null && !answer.isAtRest);
      if (had !== (truth !== null)) {
        setViews(truth === null ? 1 : 2);
        legend.allowDifference(truth !== null);
      }
      redraw(legend.shown() === 'difference' ? [0, 1] : [1]);
    },
    setSkin: chooseSkin,
    setNode(chosen) {
      node = chosen;
      redraw();
    },
    legend: legend.now,
    look: () => ({ shown: legend.shown(), end: legend.fixedEnd(), skin, showsVessels: vesselsBox().checked, ...cutControls(), camera: stage.cameraPlace() }),
    setLook(look) {
      vesselsBox().checked = look.showsVessels;
      setCutControls(look.cutAxis, look.cutPlace);
      showCut();
      chooseSkin(look.skin);
      legend.set(look.shown, look.end);
      if (look.camera) stage.setCameraPlace(look.camera);
    },
  };
}
