// A needle as the picture draws it.
import type { NeedleMark } from '../../../picture/needle_mark.ts';
import type { LiveFrame } from '../../types.ts';
import type { NeedleTool } from './types.ts';
import { pointAt } from './way.ts';
import { plus } from '../../vector.ts';

/** Of the shaft that is drawn before the target, so that the handle is outside wherever the tip is [m]. */
const shaft = 0.1;

export function needleMark(tool: NeedleTool, { needle }: LiveFrame): NeedleMark {
  const depth = needle?.depth ?? 0;
  return {
    tip: pointAt(tool, depth),
    handle: pointAt(tool, depth - shaft),
    radius: 0.5 * tool.values.diameter,
    planned: tool.target,
    target: plus(tool.target, needle?.targetMoved ?? [0, 0, 0]),
  };
}
