// What a reckless user does to the springs of the live page: messages that build/release/tests/live_trial writes.
import { spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { builtTests } from './browser.mjs';

const liveTrial = join(builtTests, 'live_trial');
/** Why there is no trial; false if there is one. */
export const noTrial = existsSync(liveTrial) ? false : `${liveTrial} is not built (cmake --build --preset release --target live_trial)`;

/** Messages of a file: the body, and what is done to it. */
export function readMessages(path) {
  const bytes = readFileSync(path), messages = [];
  for (let offset = 0; offset < bytes.length;) {
    const count = Number(bytes.readBigUInt64LE(offset));
    offset += 8;
    messages.push(new Float64Array(bytes.buffer.slice(bytes.byteOffset + offset, bytes.byteOffset + offset + 8 * count)));
    offset += 8 * count;
  }
  return messages;
}

/** The same of a trial of a body that is made now. */
export function trialMessages(body, numSteps, seed) {
  const folder = mkdtempSync(join(tmpdir(), 'livermark-trial-')), path = join(folder, 'messages');
  try {
    const { status, stderr } = spawnSync(liveTrial, ['--body', body, '--steps', numSteps, '--seed', seed, '--messages', path].map(String), { encoding: 'utf8' });
    if (status !== 0) throw new Error(`live_trial: status ${status}; ${stderr}`);
    return readMessages(path);
  } finally {
    rmSync(folder, { recursive: true });
  }
}

/** The body of the first message, as the live page has it. */
export function bodyOfMessage(message) {
  const [numNodes, numTetrahedra, numRegions, numTriangles] = message;
  let at = 4;
  const take = (count) => Array.from(message.subarray(at, (at += count)));
  const one = () => take(1)[0];
  const vesselsOf = (numPoints) => {
    if (numPoints === 0) return null;
    const numSegments = one();
    return { points: take(3 * numPoints), radius: take(numPoints), segments: take(2 * numSegments), wallRatio: one(), wallModulus: one() };
  };
  const foundationOf = (numFacets) => (numFacets === 0 ? null : { facets: take(numFacets), stiffness: take(numFacets), normalOnly: take(numFacets) });
  return {
    file: '',
    points: take(3 * numNodes), tetrahedra: take(4 * numTetrahedra), region: take(numTetrahedra),
    density: take(numRegions), youngModulus: take(numRegions), poissonRatio: take(numRegions),
    triangles: take(3 * numTriangles), constrained: take(numTriangles),
    modulusFactor: take(one()),
    capsule: one() ? { thickness: one(), youngModulus: one(), covered: take(numTriangles) } : null,
    vessels: vesselsOf(one()),
    foundation: foundationOf(one()),
  };
}

/** What one of the others asks for, as the live page says it. */
export function rowOfMessage(message, laws) {
  const [kind, ...m] = message;
  if (kind === 1)
    return { kind: 'choose', settings: { springLaw: laws[m[0]], keepsVolume: m[1] !== 0, youngModulus: m[2], poissonRatio: m[3], massDamping: m[4], stiffnessDamping: m[5], timeStep: m[6] } };
  if (kind === 2) {
    const tool = { kind: ['none', 'probe', 'pull'][m[0]], target: m.slice(1, 4), radius: m[4], node: m[5] };
    return { kind: 'move', tool, numSteps: m[6] };
  }
  return { kind: { 3: 'reset', 4: 'keep', 5: 'undo' }[kind] };
}
