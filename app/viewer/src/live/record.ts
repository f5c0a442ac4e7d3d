// Everything that was asked of an engine, in order: enough to do the same again elsewhere.
import type { CutAnswer, CutRequest } from './tool/blade/types.ts';
import type { Chosen, LiveFrame, LiveSettings, Tool } from './types.ts';
import { length } from './vector.ts';

export interface Move {
  kind: 'move';
  tool: Tool;
  numSteps: number;
  frame: Pick<LiveFrame, 'time' | 'force' | 'indentation' | 'smallestVolume' | 'disc' | 'needle' | 'grasp'>;
}
export type Entry = Move | { kind: 'cut'; request: CutRequest; answer: Pick<CutAnswer, 'volume' | 'margin'> } | { kind: 'choose'; settings: LiveSettings; chosen: Chosen } | { kind: 'reset' | 'keep' | 'undo' };

const columns = [
  'kind', 'num_steps', 'tool', 'target_x', 'target_y', 'target_z', 'radius', 'node',
  'law', 'keeps_volume', 'young_modulus', 'poisson_ratio', 'mass_damping', 'stiffness_damping', 'time_step', 'longest_time_step', 'critical_time_step', 'step_limit',
  'time', 'force_x', 'force_y', 'force_z', 'indentation', 'smallest_volume',
  'disc_x', 'disc_y', 'disc_z',
  'entry_x', 'entry_y', 'entry_z', 'depth', 'diameter', 'toughness', 'friction', 'puncture_force', 'tip', 'target_moved',
  'inwards_x', 'inwards_y', 'inwards_z', 'closing', 'other_x', 'other_y', 'other_z',
  'region', 'margin', 'keeps_margin', 'opens', 'thickness', 'takes_loose', 'volume', 'margin_left',
  ...[0, 1, 2, 3].flatMap((corner) => ['x', 'y', 'z'].map((axis) => `corner_${corner}_${axis}` as const)),
] as const;
type Row = Partial<Record<(typeof columns)[number], string | number | undefined>>;

export function moveOf(tool: Tool, numSteps: number, { time, force, indentation, smallestVolume, disc, needle, grasp }: LiveFrame): Move {
  return { kind: 'move', tool, numSteps, frame: { time, force, indentation, smallestVolume, disc, needle, grasp } };
}

function moveRow({ tool, numSteps, frame }: Move): Row {
  const [force_x, force_y, force_z] = frame.force;
  const [disc_x, disc_y, disc_z] = frame.disc.middle;
  const place = frame.disc.radius > 0 ? { disc_x, disc_y, disc_z } : {};
  const answer = { time: frame.time, force_x, force_y, force_z, indentation: frame.indentation, smallest_volume: frame.smallestVolume, ...place };
  const asked = { kind: 'move', num_steps: numSteps, tool: tool.kind };
  if (tool.kind === 'none') return { ...asked, ...answer };
  const [target_x, target_y, target_z] = tool.target;
  if (tool.kind === 'needle') {
    const [entry_x, entry_y, entry_z] = tool.entry;
    const felt = frame.needle && { tip: frame.needle.tip, target_moved: length(frame.needle.targetMoved) };
    const { diameter, spread, toughness, friction, punctureForce } = tool.values;
    const needle = { entry_x, entry_y, entry_z, depth: tool.depth, diameter, toughness, friction, puncture_force: punctureForce };
    return { ...asked, target_x, target_y, target_z, radius: spread, ...needle, ...felt, ...answer };
  }
  if (tool.kind === 'grasp') {
    const [entry_x, entry_y, entry_z] = tool.place;
    const [inwards_x, inwards_y, inwards_z] = tool.inwards;
    const [other_x, other_y, other_z] = frame.grasp?.other ?? [];
    const jaws = { entry_x, entry_y, entry_z, depth: tool.depth, inwards_x, inwards_y, inwards_z, closing: frame.grasp?.closing, other_x, other_y, other_z };
    return { ...asked, target_x, target_y, target_z, radius: tool.radius, ...jaws, ...answer };
  }
  const said = { ...asked, target_x, target_y, target_z, radius: tool.radius, ...answer };
  if (tool.kind === 'pull') return { ...said, node: tool.node };
  if (tool.kind !== 'plate') return said;
  const [inwards_x, inwards_y, inwards_z] = tool.inwards;
  return { ...said, inwards_x, inwards_y, inwards_z };
}

/** Of a half-space, corner 0 is its point and corner 1 its normal. */
function cutRow({ request: { tool, takesLoose }, answer }: Extract<Entry, { kind: 'cut' }>): Row {
  const said = { kind: 'cut', tool: tool.kind, takes_loose: Number(takesLoose), volume: answer.volume, margin_left: answer.margin };
  if (tool.kind === 'region') return { ...said, region: tool.region, margin: tool.margin, keeps_margin: Number(tool.keepsMargin), opens: Number(tool.opens) };
  const places = tool.kind === 'blade' ? tool.corners : [tool.point, tool.normal];
  const corners = Object.fromEntries(places.flatMap((place, c) => place.map((x, i) => [`corner_${c}_${'xyz'[i]}`, x])));
  return { ...said, ...corners, ...(tool.kind === 'blade' && { thickness: tool.thickness }) };
}

function rowOf(entry: Entry): Row {
  if (entry.kind === 'move') return moveRow(entry);
  if (entry.kind === 'cut') return cutRow(entry);
  if (entry.kind !== 'choose') return { kind: entry.kind };
  const { settings, chosen } = entry;
  return {
    kind: 'choose',
    law: settings.springLaw,
    keeps_volume: Number(settings.keepsVolume),
    young_modulus: settings.youngModulus,
    poisson_ratio: settings.poissonRatio,
    mass_damping: settings.massDamping,
    stiffness_damping: settings.stiffnessDamping,
    // The step that was taken: 0 would be another one on another machine.
    time_step: chosen.timeStep,
    longest_time_step: chosen.longestTimeStep,
    critical_time_step: chosen.criticalTimeStep,
    step_limit: chosen.limit,
  };
}

/** A line for each entry, in SI units, with as many digits as the numbers have. What does not apply is left empty. */
export function csvOf(entries: readonly Entry[]): string {
  const lines = entries.map(rowOf).map((row) => columns.map((column) => row[column] ?? '').join(','));
  return [columns.join(','), ...lines, ''].join('\n');
}

export function download(name: string, text: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([text], { type: 'text/csv' }));
  link.download = name;
  link.click();
  // The browser has begun to read it by then.
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
