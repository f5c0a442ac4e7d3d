// The picture of what moves: the springs, beside them finite elements, and the tool.
import type { Result } from '../data/types.ts';
import { byId } from '../page/elements.ts';
import { legend } from '../page/legend.ts';
import type { Skin } from '../picture/body.ts';
import { lengths } from '../picture/fields.ts';
import type { Marks } from '../picture/marks.ts';
import { roundedUp } from '../picture/scale.ts';
import { createStage, type Hooks, type Side, type Stage } from '../picture/stage.ts';
import { length } from './hand.ts';
import type { LiveFrame, Tool, Vector } from './types.ts';

export interface Scene {
  stage: Stage;
  setBody(result: Result): void;
  showSprings(frame: LiveFrame, tool: Tool): void;
  /** @param displacement  null hides the second picture */
  showElements(displacement: Float32Array | null): void;
  setSkin(skin: Skin): void;
  /** Colours begin anew. */
  forget(): void;
}

const arrowScale = 0.025; // [m/N]
const longestArrow = 0.15; // [m]
const firstEnd = 0.005; // of the legend [m]

function marksOf(frame: LiveFrame, tool: Tool): Marks {
  if (tool.kind === 'none') return { probe: null, grip: null, arrow: null };
  const force = length(frame.force);
  const scale = Math.min(arrowScale, longestArrow / (force || 1));
  const from = frame.tool;
  return {
    probe: tool.kind === 'probe' ? { centre: from, radius: tool.radius } : null,
    grip: tool.kind === 'pull' ? from : null,
    arrow: { from, along: frame.force.map((f) => f * scale) as Vector },
  };
}

export function createScene(canvas: HTMLCanvasElement, hooks: Hooks): Scene {
  const stage = createStage(canvas, hooks, 56);
  const setViews = (count: 1 | 2) => {
    byId('live-stage').dataset['views'] = String(count);
    stage.setViews(count);
  };
  new ResizeObserver(() => {
    byId('live-stage').dataset['arrangement'] = canvas.clientWidth >= canvas.clientHeight ? 'beside' : 'below';
  }).observe(canvas);
  let skin: Skin = 'solid';
  let end = firstEnd;
  const shown: [Float32Array | null, Float32Array | null] = [null, null];

  function showLegend(): void {
    const note = skin === 'flat' ? '' : 'Light and glass shift colours; “Exact colours” shows them as here.';
    byId('live-legend').replaceChildren(...legend('displacement', end, false, note));
  }

  function show(side: Side, displacement: Float32Array): void {
    shown[side] = displacement;
    const values = lengths(displacement);
    const largest = values.reduce((most, value) => Math.max(most, value), 0);
    // The legend grows and does not shrink: a colour goes on to mean the same.
    if (largest > end && largest < Infinity) {
      end = roundedUp(1000 * largest) / 1000;
      showLegend();
      if (shown[1 - side]) show((1 - side) as Side, shown[1 - side]!);
    }
    stage.show(side, { displacement, values, end, quantity: 'displacement', skin, exaggeration: 1, node: null });
  }

  function redraw(): void {
    showLegend();
    for (const side of [0, 1] as Side[]) if (shown[side]) show(side, shown[side]!);
  }

  return {
    stage,
    setBody(result) {
      stage.setBody(result.points, result.surfaces);
      end = firstEnd;
      shown[1] = null;
      show(0, new Float32Array(result.points.length));
      setViews(1);
      showLegend();
    },
    showSprings(frame, tool) {
      show(0, frame.displacement);
      stage.mark(0, marksOf(frame, tool));
    },
    showElements(displacement) {
      const had = shown[1] !== null;
      if (displacement) show(1, displacement);
      else shown[1] = null;
      if (had !== (displacement !== null)) setViews(displacement ? 2 : 1);
    },
    setSkin(chosen) {
      skin = chosen;
      redraw();
    },
    forget() {
      end = firstEnd;
      redraw();
    },
  };
}
