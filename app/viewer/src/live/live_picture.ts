// What is written around a picture of the body that moves: which springs, the force, how far it gives way, and how long its arrow is.
import type { Result } from '../data/types.ts';
import { byId } from '../page/elements.ts';
import type { PictureFrame } from '../page/save.ts';
import { short } from '../picture/scale.ts';
import type { LiveSettings } from './types.ts';

/** The key to the arrow of the force, at the lower right as on the page. [CSS pixels] */
function arrowKey(): string {
  const key = byId('live-arrow-key');
  if (key.hidden) return '';
  const { width, height } = byId('live-stage').getBoundingClientRect();
  const [end, y, length] = [width - 14, height - 20, Number(key.dataset['pixels'])];
  return `<path d="M${end - length} ${y}H${end - 11}" stroke="#d6281f" stroke-width="5"/><path d="M${end} ${y}l-12 -7v14z" fill="#d6281f"/>
    <text x="${end - length - 8}" y="${y + 5}" text-anchor="end" fill="${getComputedStyle(key).color}" font-size="13" font-weight="600">${key.textContent}</text>`;
}

export function liveFrame(result: Result, settings: LiveSettings, legend: PictureFrame['legend']): PictureFrame {
  const text = (id: string) => byId(`live-${id}`).textContent;
  const springs = `${settings.springLaw}${settings.keepsVolume ? ' with nodal volume term' : ''}`;
  // Beside elements at rest.
  const isMoving = !byId('live-names').hidden && byId('live').dataset['atRest'] !== 'true';
  const material = `E ${short(settings.youngModulus / 1000)} kPa, ν ${short(settings.poissonRatio)}`;
  const felt = byId('live-grasp-felt').hidden ? `${text('force')}, ${text('indentation')}` : `each jaw closes with ${text('grasp-closing')}, ${text('indentation')}`;
  return {
    file: `${result.body}_live`,
    title: `${result.body}: ${springs}, ${material}`,
    sides: [`Springs: ${felt}${isMoving ? ', still moving' : ''}`, ...(byId('live-names').hidden ? [] : [`FEM: ${text('fem-indentation')}`])],
    legend,
    more: arrowKey(),
  };
}
