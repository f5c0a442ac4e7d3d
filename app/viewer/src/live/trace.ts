// The force of the last seconds, as a line that goes on.
import { roundedUp } from '../picture/scale.ts';
import type { Entry, Move } from './record.ts';
import { length } from './vector.ts';

const seconds = 10;
const margin = { left: 38, right: 8, top: 8, bottom: 20 };

/** Moves of the last seconds, in order. */
function latest(entries: readonly Entry[]): Move[] {
  const moves: Move[] = [];
  for (let i = entries.length - 1; i >= 0; i--) {
    const entry = entries[i]!;
    if (entry.kind !== 'move') continue;
    moves.push(entry);
    if (entry.frame.time < moves[0]!.frame.time - seconds) break;
  }
  return moves.reverse();
}

export function drawTrace(canvas: HTMLCanvasElement, entries: readonly Entry[]): void {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (width === 0) return;
  const density = window.devicePixelRatio;
  const [wide, high] = [Math.round(width * density), Math.round(height * density)];
  if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
  const context = canvas.getContext('2d')!;
  context.setTransform(density, 0, 0, density, 0, 0);
  context.clearRect(0, 0, width, height);

  const shown = latest(entries).map(({ frame }) => ({ time: frame.time, force: frame.grasp ? Math.abs(frame.grasp.closing) : length(frame.force) }));
  const end = Math.max(shown.at(-1)?.time ?? 0, seconds);
  const most = roundedUp(shown.reduce((largest, s) => Math.max(largest, s.force), 0.1));
  const x = (time: number) => margin.left + ((width - margin.left - margin.right) * (time - end + seconds)) / seconds;
  const y = (force: number) => height - margin.bottom - ((height - margin.top - margin.bottom) * force) / most;

  const { font, color, borderTopColor, caretColor } = getComputedStyle(canvas); // of the page, light or dark
  context.font = font;
  context.fillStyle = color;
  context.strokeStyle = borderTopColor;
  context.textBaseline = 'middle';
  for (const force of [0, most / 2, most]) {
    context.beginPath();
    context.moveTo(margin.left, y(force));
    context.lineTo(width - margin.right, y(force));
    context.stroke();
    context.textAlign = 'right';
    context.fillText(String(Number(force.toPrecision(3))), margin.left - 6, y(force));
  }
  context.textBaseline = 'bottom';
  for (const time of [end - seconds, end]) {
    context.textAlign = time === end ? 'right' : 'left';
    context.fillText(`${time.toFixed(1)} s`, x(time), height);
  }
  context.strokeStyle = caretColor;
  context.lineWidth = 1.6;
  context.lineJoin = 'round';
  // What is older than the plot ends at its edge.
  context.save();
  context.beginPath();
  context.rect(margin.left, 0, width - margin.left, height);
  context.clip();
  context.beginPath();
  for (const { time, force } of shown) context.lineTo(x(time), y(force));
  context.stroke();
  context.restore();
}
