// Mouse, finger and keys as motions of the tool.
import type { Stage } from '../../picture/stage.ts';
import { shortest, lengthOfStroke, strokeOf, type Stroke } from './blade/stroke.ts';
import { goalOf, isHolding, letGo, pushTo, slide, type Grasp, type ToolState } from './tool_state.ts';
import type { LiveBody } from '../types.ts';
import { plus, type Vector } from '../vector.ts';

export interface Handling {
  toolState(): ToolState;
  change(toolState: ToolState): void;
  /** Sets the tool down. */
  take(place: Pick<Grasp, 'point' | 'inwards' | 'node'>): void;
  /** The blade has been led across the picture. */
  cutAlong(stroke: Stroke): void;
  /** Shows where it is led, in pixels of the canvas. */
  drawStroke(line: [x1: number, y1: number, x2: number, y2: number] | null): void;
  body(): LiveBody | null;
  /** Whether a tool stays where it is when the button is let go. */
  stays(): boolean;
  say(sentence: string): void;
}

const constrainedSentence = 'The load case constrains the body there: nothing gives way. Turn it and take another place.';
const perNotch = 0.0005 / 100; // of the wheel: half a millimetre [m/pixel]
const linesToPixels = 33;

export interface Pointer {
  takesPress(event: PointerEvent): boolean;
}

/** Moves of the pointer across the screen, seen at the place that is grasped. */
function across(stage: Stage, toolState: ToolState, right: number, down: number): Vector {
  const screen = stage.screenAt(toolState.grasp!.point);
  return plus(screen.right.map((x) => x * right * screen.metresPerPixel) as Vector, screen.up, -down * screen.metresPerPixel);
}

/** @param stage  asked for when there is a pointer on it */
export function createPointer(canvas: HTMLCanvasElement, stage: () => Stage, handling: Handling): Pointer {
  let pressed: { id: number; x: number; y: number } | null = null;
  let stroke: { start: PointerEvent; point: Vector } | null = null;

  /** From where the blade was set down to where the pointer is now. */
  function strokeTo(event: PointerEvent): Stroke {
    const { right, up, metresPerPixel } = stage().screenAt(stroke!.point);
    const [x, y] = [event.clientX - stroke!.start.clientX, event.clientY - stroke!.start.clientY];
    return strokeOf(stroke!.point, right, up, x * metresPerPixel, -y * metresPerPixel);
  }
  function endStroke(event: PointerEvent | null): void {
    const led = event && strokeTo(event);
    stroke = null;
    handling.drawStroke(null);
    if (!led) return;
    if (lengthOfStroke(led) >= shortest) handling.cutAlong(led);
    else handling.say('Press where the cut begins, and lead the blade to where it ends.');
  }

  function release(lets: boolean): void {
    pressed = null;
    if (stroke) endStroke(null);
    stage().setZooming(true);
    if (lets) handling.change(letGo(handling.toolState()));
  }
  canvas.addEventListener('pointermove', (event) => {
    if (event.pointerId === pressed?.id && stroke) {
      const box = canvas.getBoundingClientRect();
      handling.drawStroke([stroke.start.clientX - box.left, stroke.start.clientY - box.top, event.clientX - box.left, event.clientY - box.top]);
      return;
    }
    const toolState = handling.toolState();
    if (event.pointerId !== pressed?.id || !toolState.grasp) return;
    const [right, down] = [event.clientX - pressed.x, event.clientY - pressed.y];
    pressed = { id: pressed.id, x: event.clientX, y: event.clientY };
    // Away from oneself is into the body.
    const deeper = -down * stage().screenAt(toolState.grasp.point).metresPerPixel;
    handling.change(event.shiftKey ? pushTo(toolState, goalOf(toolState) + deeper) : slide(toolState, across(stage(), toolState, right, down)));
  });
  canvas.addEventListener('pointerup', (event) => {
    if (event.pointerId !== pressed?.id) return;
    if (stroke) endStroke(event);
    release(!handling.stays());
  });
  canvas.addEventListener('pointercancel', (event) => event.pointerId === pressed?.id && release(true));
  canvas.addEventListener('wheel', (event) => {
    if (!pressed) return;
    event.preventDefault();
    if (stroke) return;
    // With Shift a wheel rolls sideways on some systems.
    const pixels = (event.deltaY || event.deltaX) * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? linesToPixels : 1);
    handling.change(pushTo(handling.toolState(), goalOf(handling.toolState()) - pixels * perNotch));
  }, { passive: false });
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());

  return {
    takesPress(event) {
      const [toolState, body] = [handling.toolState(), handling.body()];
      if (pressed) {
        // A second finger: both turn the body.
        release(true);
        return false;
      }
      if (toolState.kind === 'none' || !body) return false;
      const hit = stage().hitAt(event);
      if (!hit || hit.side !== 0) return false;
      if (isHolding(toolState.kind) && body.constrained[hit.triangle]) {
        handling.say(constrainedSentence);
        return false;
      }
      pressed = { id: event.pointerId, x: event.clientX, y: event.clientY };
      canvas.setPointerCapture(event.pointerId);
      stage().setZooming(false);
      handling.say('');
      if (toolState.kind === 'blade') stroke = { start: event, point: hit.point };
      else handling.take(hit);
      return true;
    },
  };
}

const millimetre = 0.001;
const turned = Math.PI / 18;

export interface KeyActions extends Handling {
  touch(): void;
  pause(): void;
  step(): void;
  undo(): void;
}

/** Keys on the picture. Arrows turn the body; with Shift they move the tool. */
export function listenToKeys(canvas: HTMLCanvasElement, stage: () => Stage, actions: KeyActions): void {
  const push = (metres: number) => actions.change(pushTo(actions.toolState(), goalOf(actions.toolState()) + metres));
  const arrow = (right: number, up: number, moves: boolean) => {
    const toolState = actions.toolState();
    if (!moves) return stage().turn(right * turned, up * turned);
    if (!toolState.grasp) return;
    const { metresPerPixel } = stage().screenAt(toolState.grasp.point);
    const pixels = millimetre / metresPerPixel;
    actions.change(slide(toolState, across(stage(), toolState, right * pixels, -up * pixels)));
  };
  const keys: Record<string, (isShifted: boolean) => void> = {
    ArrowLeft: (moves) => arrow(-1, 0, moves),
    ArrowRight: (moves) => arrow(1, 0, moves),
    ArrowUp: (moves) => arrow(0, 1, moves),
    ArrowDown: (moves) => arrow(0, -1, moves),
    PageDown: () => push(millimetre),
    PageUp: () => push(-millimetre),
    Enter: actions.touch,
    Escape: () => actions.change(letGo(actions.toolState())),
    ' ': actions.pause,
    '.': actions.step,
    '+': () => stage().zoom(0.9),
    '=': () => stage().zoom(0.9),
    '-': () => stage().zoom(1 / 0.9),
    r: () => stage().resetView(),
    R: () => stage().resetView(),
  };
  canvas.addEventListener('keydown', (event) => {
    const isCommand = event.ctrlKey || event.metaKey;
    const action = isCommand && !event.shiftKey && event.key === 'z' ? actions.undo : keys[event.key];
    if (!action || event.altKey || (isCommand && event.key !== 'z')) return;
    event.preventDefault();
    action(event.shiftKey);
  });
}
