// The springs of the live page in an empty page, and the same lines compiled for this machine.
import { spawnSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import * as hdf5 from 'h5wasm/node';
import { build } from 'vite';
import { builtTests, newPage, startBrowser } from './browser.mjs';

const viewer = join(import.meta.dirname, '..');
/** Built for the machines whose numbers are those of WebAssembly. */
export const liveReplay = join(builtTests, 'live_replay');
/** Why the springs are not compared with native ones here; false if they are. */
export const noReplay = existsSync(liveReplay) ? false
  : process.arch === 'x64' ? `${liveReplay} is not built (cmake --build --preset release --target live_replay)`
  : 'native springs have other last digits on this machine';

/** The harness as one script, made as the page is made. */
async function bundledHarness() {
  const [{ output }] = await build({
    root: viewer,
    configFile: false,
    logLevel: 'warn',
    worker: { format: 'iife' },
    build: {
      write: false,
      assetsInlineLimit: Number.MAX_SAFE_INTEGER,
      lib: { entry: join(viewer, 'tests/springs_harness.ts'), formats: ['iife'], name: 'harness' },
    },
  });
  return output[0].code;
}

/** A browser with the harness in an empty page. */
export async function startHarness() {
  const harness = await bundledHarness();
  const browser = await startBrowser();
  const page = await newPage(browser);
  await page.addScriptTag({ content: harness });
  return {
    open: (body) => page.evaluate((body) => springs.open(body), body),
    /** In parts, because one answer may be only so long. */
    async play(rows, { whole = false } = {}) {
      const answers = [];
      for (let i = 0; i < rows.length; i += 50)
        answers.push(...(await page.evaluate(([rows, whole]) => springs.play(rows, whole), [rows.slice(i, i + 50), whole])));
      return answers;
    },
    /** @param cut  what a cut of that body has answered */
    foundationLeft: (body, cut) => page.evaluate(([body, cut]) => springs.foundationLeft(body, cut), [body, cut]),
    stop: () => browser.close(),
  };
}

const attribute = (group, name) => Number(group.attrs[name].value);

function capsuleOf(file) {
  const group = file.get('capsule'), patch = file.get('mesh/boundary_patch');
  if (!group) return null;
  const isWound = patch.attrs['names'].value.map((name) => name.replace(/\0+$/, '').split('+').includes('wound'));
  return { thickness: attribute(group, 'thickness'), youngModulus: attribute(group, 'young_modulus'), covered: Array.from(patch.value, (p) => Number(!isWound[p])) };
}

function vesselsOf(file) {
  const group = file.get('vessels');
  if (!group) return null;
  const values = (name) => Array.from(file.get(`vessels/${name}`).value, Number);
  return { points: values('points'), radius: values('radius'), segments: values('segments'), wallRatio: attribute(group, 'wall_ratio'), wallModulus: attribute(group, 'wall_modulus') };
}

/** @param constrained  (T) of the body */
function foundationOf(file, constrained) {
  if (!file.get('load_case/foundation')) return null;
  const [facets, stiffness, normalOnly] = ['facet', 'stiffness', 'normal_only'].map((name) => Array.from(file.get(`load_case/foundation/${name}`).value, Number));
  const isFree = (_, i) => constrained[facets[i]] === 0;
  return { facets: facets.filter(isFree), stiffness: stiffness.filter(isFree), normalOnly: normalOnly.filter(isFree) };
}

/** The body of a result file, as the live page reads it. */
export async function bodyOf(path) {
  await hdf5.ready;
  const file = new hdf5.File(path, 'r');
  const values = (path) => Array.from(file.get(path).value, Number);
  const condition = values('load_case/condition'), value = values('load_case/value');
  const body = {
    file: '',
    points: values('mesh/points'),
    tetrahedra: values('mesh/tetrahedra'),
    region: values('mesh/region'),
    density: values('materials/density'),
    youngModulus: values('materials/young_modulus'),
    poissonRatio: values('materials/poisson_ratio'),
    triangles: values('mesh/boundary_triangles'),
    constrained: condition.map((kind, f) => Number(kind === 1 && value.slice(3 * f, 3 * f + 3).every((x) => x === 0))),
    modulusFactor: file.get('mesh/modulus_factor') ? values('mesh/modulus_factor') : [],
    capsule: capsuleOf(file),
    vessels: vesselsOf(file),
  };
  body.foundation = foundationOf(file, body.constrained);
  file.close();
  return body;
}

export const bodyNumbers = (b) => [
  b.points.length / 3, b.tetrahedra.length / 4, b.density.length, b.triangles.length / 3,
  ...[b.points, b.tetrahedra, b.region, b.density, b.youngModulus, b.poissonRatio, b.triangles, b.constrained].flat(),
  b.modulusFactor.length, ...b.modulusFactor,
  ...(b.capsule ? [1, b.capsule.thickness, b.capsule.youngModulus, ...b.capsule.covered] : [0]),
  ...(b.vessels ? vesselNumbers(b.vessels) : [0]),
  ...(b.foundation ? [b.foundation.facets.length, ...b.foundation.facets, ...b.foundation.stiffness, ...b.foundation.normalOnly] : [0]),
];
const vesselNumbers = ({ points, radius, segments, wallRatio, wallModulus }) => [
  radius.length, segments.length / 2, ...points, ...radius, ...segments, wallRatio, wallModulus,
];
/** @param request  see CutRequest of the page */
export function cutNumbers({ tool, takesLoose }) {
  const what = {
    region: () => [0, tool.region, tool.margin, Number(tool.keepsMargin), Number(tool.opens)],
    'half-space': () => [1, ...tool.point, ...tool.normal],
    blade: () => [2, ...tool.corners.flat(), tool.thickness],
  };
  return [7, Number(takesLoose), ...what[tool.kind]()];
}

const rowNumbers = (row, laws) => {
  const alone = { reset: 3, keep: 4, undo: 5 }[row.kind];
  if (alone) return [alone];
  if (row.kind === 'choose') {
    const s = row.settings;
    return [1, laws.indexOf(s.springLaw), Number(s.keepsVolume), s.youngModulus, s.poissonRatio, s.massDamping, s.stiffnessDamping, s.timeStep];
  }
  if (row.kind === 'cut') return cutNumbers(row.request);
  if (row.tool.kind === 'needle') {
    const { entry, target, depth, values: v } = row.tool;
    return [6, ...entry, ...target, v.diameter, v.spread, v.toughness, v.friction, v.punctureForce, depth, row.numSteps];
  }
  if (row.tool.kind === 'grasp') {
    const { place, inwards, target, radius, depth } = row.tool;
    return [8, ...place, ...inwards, ...target, radius, depth, row.numSteps];
  }
  if (row.tool.kind === 'plate') return [9, ...row.tool.target, ...row.tool.inwards, row.tool.radius, row.numSteps];
  const { kind, target = [0, 0, 0], radius = 0, node = 0 } = row.tool;
  return [2, ['none', 'probe', 'pull'].indexOf(kind), ...target, radius, node, row.numSteps];
};

/** Answers of the native program to the same rows, as bytes. */
export function playNatively(body, rows, laws) {
  const messages = [bodyNumbers(body), ...rows.map((row) => rowNumbers(row, laws))].map((numbers) => {
    const bytes = Buffer.alloc(8 * (1 + numbers.length));
    bytes.writeBigUInt64LE(BigInt(numbers.length));
    numbers.forEach((x, i) => bytes.writeDoubleLE(x, 8 * (1 + i)));
    return bytes;
  });
  const { stdout, stderr, status } = spawnSync(liveReplay, { input: Buffer.concat(messages), maxBuffer: 2 ** 31 });
  if (status !== 0) throw new Error(`live_replay: ${stderr}`);
  const answers = [];
  for (let offset = 0; offset < stdout.length;) {
    const size = Number(stdout.readBigUInt64LE(offset));
    answers.push(Buffer.from(stdout.subarray(offset + 8, offset + 8 + size))); // a copy begins where float64 may
    offset += 8 + size;
  }
  return answers;
}

/** All numbers of the answer to a move, but the seconds that it took. @param tool  that was asked for */
export function frameOf(answer, tool = { kind: 'none' }) {
  const view = new DataView(answer.buffer, answer.byteOffset, answer.length);
  let offset = 0;
  const number = () => view.getFloat64((offset += 8) - 8, true);
  const numbers = (count) => Array.from({ length: count }, number);
  const needle = tool.kind !== 'needle' ? null : {
    depth: number(), tip: number(), force: number(), tipForce: number(), isPunctured: number() !== 0, targetMoved: numbers(3),
    work: { hand: number(), friction: number(), tearing: number() },
    line: { entry: tool.entry, target: tool.target, spread: tool.values.spread },
    forces: numbers(3 * number()),
  };
  const grasp = tool.kind !== 'grasp' ? null : { depth: number(), closing: number(), other: numbers(3), otherForce: numbers(3) };
  const frame = { needle, grasp, time: number(), tool: numbers(3), force: numbers(3), disc: { middle: numbers(3), radius: number() }, indentation: number(), smallestVolume: number(), largestSpeed: number(), restarts: number() };
  frame.radius = ['probe', 'plate', 'pull', 'grasp'].includes(tool.kind) ? tool.radius : 0; // as the page has it
  number();
  frame.numEvaluations = number();
  const [numNodes, numLoaded, numFacets] = numbers(3);
  Object.assign(frame, {
    loadedNodes: numbers(numLoaded), nodalForces: numbers(3 * numLoaded), loadedFacets: numbers(numFacets), tractions: numbers(3 * numFacets),
  });
  frame.displacement = Array.from({ length: 3 * numNodes }, () => view.getFloat32((offset += 4) - 4, true));
  return frame;
}
