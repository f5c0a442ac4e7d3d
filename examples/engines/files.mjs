// The files that Livermark exchanges with an engine (results/schema.md, "The problem" and "Tool scenes"), for the
// adapters that Node runs. Fields of points are arrays x0 y0 z0 x1 y1 z1 ... N is the number of nodes, M of tetrahedra,
// R of materials, T of nodes of the tool, K of records, the first at t = 0.
import { existsSync, readFileSync, unlinkSync, writeFileSync } from 'node:fs';
import * as hdf5 from 'h5wasm/node';

await hdf5.ready;

/** Calls read({values, attribute, has, body}) on an open HDF5 file. Throws an Error where the file or an entry is missing. */
function open(path, command, read) {
  if (!existsSync(path)) throw new Error(`${path} does not exist; write it with livermark export ${command}`);
  if (readFileSync(path).toString('latin1', 1, 4) !== 'HDF') throw new Error(`${path} is no HDF5 file; write it with livermark export ${command}`);
  const file = new hdf5.File(path, 'r');
  try {
    const has = (name) => file.get(name) !== null;
    const values = (name) => {
      if (!has(name)) throw new Error(`${path} has no /${name}; write it with livermark export ${command}`);
      return file.get(name).value;
    };
    const attribute = (name, key) => file.get(name)?.attrs[key]?.value;
    const body = () => ({
      density: Float64Array.from(values('materials/density')),
      youngModulus: Float64Array.from(values('materials/young_modulus')),
      poissonRatio: Float64Array.from(values('materials/poisson_ratio')),
    });
    return read({ values, attribute, has, body });
  } finally {
    file.close();
  }
}

const numbers = (values) => Int32Array.from(values, Number); // HDF5 has 64 bits, which Node reads as BigInt

/** Parts of a problem that no nodal forces can say, with the words for them. */
const refused = {
  'load_case/foundation': 'elastic springs below facets',
  'load_case/slow_history': 'tissue that relaxes',
  'load_case/release': 'a release, which happens in time',
  capsule: 'a capsule',
  vessels: 'vessels as lines',
  'mesh/modulus_factor': 'a map of stiffness',
};

/** A rigid ball that touches without friction, or null where a problem has none. Throws an Error where its tool is another. */
function ballOf(path, { values, attribute, has }) {
  if (!has('load_case/touch')) return null;
  const of = (key) => attribute('load_case/touch', key), way = values('load_case/touch/way');
  const other = (of('face') && 'a plate') || (has('load_case/touch/between') && 'two jaws') || (of('friction') !== 0 && 'a tool with friction') ||
    (way.subarray(6).some((value) => value !== 0) && 'a tool that slides');
  if (other) throw new Error(`${path} has ${other}, and adapters know a ball that presses without friction; choose another load case`);
  return { radius: of('radius'), start: way.slice(0, 3), press: way.slice(3, 6) };
}

/** By how much the node that is deepest in a ball at the end of its press is inside it [m]. */
export function deepest({ radius, start, press }, points, u) {
  let least = Infinity;
  for (let i = 0; i < points.length; i += 3)
    least = Math.min(least, Math.hypot(...[0, 1, 2].map((c) => points[i + c] + u[i + c] - start[c] - press[c])));
  return Math.max(0, radius - least);
}

/**
 * Problem at rest, FILE.problem.h5 of `livermark export`.
 * @returns points (3N) [m], tetrahedra (4M), material (M) index into density [kg/m^3], youngModulus [Pa] and
 *   poissonRatio (R); force (3N) of tractions and weight [N], fixed (3N) 1 where a component is prescribed, prescribed
 *   (3N) its displacement [m], 0 elsewhere; isLarge: whether the reference is hyperelastic; targetPeak: the displacement
 *   that the loads are meant to reach [m]; pressDepth [m]: where above 0, force is that of one newton, and all of it is
 *   to be multiplied by one number, so that force . u = pressDepth. touch: the rigid ball that presses without friction, or
 *   null: its radius, start and press [m], the centre where it just touches the body at rest, and by which it moves.
 * @throws Error where the file is no problem, or has what neither nodal forces nor such a ball can say
 */
export function readProblem(path) {
  return open(path, 'BODY LOAD_CASE', ({ values, attribute, has, body }) => {
    for (const [name, words] of Object.entries(refused))
      if (has(name)) throw new Error(`${path} has ${words}, which nodal forces cannot say; choose another load case`);
    const isLarge = attribute('load_case', 'regime') === 'large';
    if (isLarge && has('load_case/follows'))
      throw new Error(`${path} has a pressure that follows the surface, which nodal forces cannot say; choose another load case`);
    const problem = {
      points: values('mesh/points'), tetrahedra: numbers(values('mesh/tetrahedra')), material: values('mesh/region'), ...body(),
      isLarge, targetPeak: attribute('load_case', 'target_peak_displacement'), pressDepth: attribute('load_case', 'press_depth') ?? 0,
      touch: ballOf(path, { values, attribute, has }),
    };
    const surface = {
      triangles: numbers(values('mesh/boundary_triangles')), condition: values('load_case/condition'), value: values('load_case/value'),
      constraint: values('load_case/constraint'), factor: has('load_case/node_factor') && values('load_case/node_factor'),
      shift: has('load_case/node_shift') && values('load_case/node_shift'),
      round: has('load_case/round_load') && ['facet', 'middle', 'radius'].map((name) => values(`load_case/round_load/${name}`)),
    };
    return { ...problem, force: nodalForces(problem, surface, values('load_case/acceleration')), ...prescribedNodes(problem, surface) };
  });
}

/** Weight, and each traction by linear shape functions. */
function nodalForces(problem, surface, acceleration) {
  const force = new Float64Array(problem.points.length);
  nodeMasses(problem).forEach((mass, node) => acceleration.forEach((a, c) => (force[3 * node + c] += mass * a)));
  for (let f = 0; f < surface.condition.length; ++f) {
    if (surface.condition[f] !== 2) continue;
    const nodes = surface.triangles.subarray(3 * f, 3 * f + 3);
    const [a, b, c] = Array.from(nodes, (node) => problem.points.subarray(3 * node, 3 * node + 3));
    const area = 0.5 * Math.hypot(...cross(subtract(b, a), subtract(c, a)));
    cornerParts(surface.round, f, [a, b, c]).forEach((part, corner) => {
      for (let i = 0; i < 3; ++i) force[3 * nodes[corner] + i] += part * area * (surface.value[3 * f + i] || 0); // NaN: free
    });
  }
  return force;
}

/** Parts of the force on a triangle that its corners take: thirds, or below a round tool by its pressure. */
function cornerParts(round, facet, corners) {
  const tool = round ? round[0][facet] : -1, moment = [0, 0, 0], rows = 24;
  if (tool < 0) return [1 / 3, 1 / 3, 1 / 3];
  const middle = round[1].subarray(3 * tool, 3 * tool + 3), radius = round[2][tool];
  const add = (...indices) => {
    const at = [rows - indices[0] - indices[1], ...indices].map((index) => index / rows);
    const point = [0, 1, 2].map((c) => at[0] * corners[0][c] + at[1] * corners[1][c] + at[2] * corners[2][c]);
    const height = Math.sqrt(Math.max(0, 1 - (Math.hypot(...subtract(point, middle)) / radius) ** 2));
    at.forEach((value, corner) => (moment[corner] += height * value));
  };
  for (let i = 0; i < rows; ++i)
    for (let j = 0; i + j < rows; ++j) {
      add(i + 1 / 3, j + 1 / 3);
      if (i + j + 1 < rows) add(i + 2 / 3, j + 2 / 3);
    }
  const sum = moment[0] + moment[1] + moment[2];
  return sum > 0 ? moment.map((value) => value / sum) : [1 / 3, 1 / 3, 1 / 3];
}

/** Prescribed components; where two constraints share a node, the earlier one has it. */
function prescribedNodes({ points }, { triangles, condition, value, constraint, factor, shift }) {
  const fixed = new Uint8Array(points.length), prescribed = new Float64Array(points.length);
  const facets = [...condition.keys()].filter((f) => condition[f] === 1).sort((a, b) => constraint[a] - constraint[b] || a - b);
  for (const f of facets)
    for (const node of triangles.subarray(3 * f, 3 * f + 3))
      for (let c = 0; c < 3; ++c) {
        const i = 3 * node + c;
        if (fixed[i] || Number.isNaN(value[3 * f + c])) continue;
        fixed[i] = 1;
        prescribed[i] = value[3 * f + c] * (factor ? factor[node] : 1) + (shift ? shift[i] : 0);
      }
  return { fixed, prescribed };
}

/**
 * Scene in motion, FILE.scene.h5 of `livermark export`.
 * @returns points, tetrahedra, material and materials as readProblem; held: the constrained nodes; tool (T): the nodes
 *   that the tool moves; time (K) [s]; way (K*T*3): displacement of these nodes, record after record [m]; massDamping
 *   [1/s]; lastRecordHeld: the last record in which the nodes of the tool are held
 * @throws Error where the file is no scene
 */
export function readScene(path) {
  return open(path, 'BODY press_and_slide', ({ values, attribute, body }) => ({
    points: values('points'), tetrahedra: numbers(values('tetrahedra')), material: values('region'), ...body(),
    held: values('held'), tool: values('tool/nodes'), time: values('tool/time'), way: values('tool/displacement'),
    massDamping: attribute('tool', 'mass_damping'), lastRecordHeld: Number(attribute('tool', 'last_record_held')),
  }));
}

/** Displacements (3N) [m] of all nodes, as CSV that `livermark score` reads. */
export function writeSolution(path, points, displacement) {
  const rows = ['x,y,z,ux,uy,uz'];
  for (let i = 0; i < points.length; i += 3)
    rows.push([...points.subarray(i, i + 3), ...displacement.subarray(i, i + 3)].join(','));
  writeFileSync(path, `${rows.join('\n')}\n`);
}

/**
 * Motion, as HDF5 that `livermark score` reads.
 * @param displacement   (K*N*3) float32 [m]
 * @param force          (K*3) elastic force of the body on the tool [N]
 * @param secondsPerFrame  processor time [s]
 */
export function writeMotion(path, { displacement, force, secondsPerFrame }) {
  if (existsSync(path)) unlinkSync(path);
  const file = new hdf5.File(path, 'w', { libver: 'latest' }), records = force.length / 3;
  file.create_dataset({ name: 'displacement', data: displacement, shape: [records, displacement.length / records / 3, 3] });
  file.create_dataset({ name: 'force', data: force, shape: [records, 3] });
  file.create_attribute('seconds_per_frame', secondsPerFrame);
  file.close();
}

export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** Volumes (M) [m^3]. */
export function volumes({ points, tetrahedra }) {
  return Float64Array.from({ length: tetrahedra.length / 4 }, (_, t) => {
    const [a, b, c, d] = Array.from(tetrahedra.subarray(4 * t, 4 * t + 4), (node) => points.subarray(3 * node, 3 * node + 3));
    return dot(cross(subtract(b, a), subtract(c, a)), subtract(d, a)) / 6;
  });
}

/** Masses (N) [kg]: each tetrahedron gives a quarter of its own to each of its nodes. */
export function nodeMasses(body) {
  const mass = new Float64Array(body.points.length / 3);
  volumes(body).forEach((volume, t) => {
    for (let corner = 0; corner < 4; ++corner) mass[body.tetrahedra[4 * t + corner]] += 0.25 * body.density[body.material[t]] * volume;
  });
  return mass;
}

/**
 * Command line FIRST SECOND [--name value]..., of an adapter.
 * @param settings  the options and their defaults, numbers
 * @returns input, output: the two files; isScene: whether the first is one; settings
 */
export function commandLine(usage, settings) {
  const [input, output, ...rest] = process.argv.slice(2), chosen = { ...settings };
  const fail = (fault) => {
    console.error(`${fault}\nusage: ${usage}`);
    process.exit(2);
  };
  if (!input || !output || output.startsWith('--')) fail('two files are needed');
  for (let i = 0; i < rest.length; i += 2) {
    const name = rest[i].replace(/^--/, '');
    if (!(name in settings) || rest[i + 1] === undefined || !Number.isFinite(Number(rest[i + 1])))
      fail(`${rest[i]} ${rest[i + 1] ?? ''}: options are ${Object.keys(settings).map((key) => `--${key} NUMBER`).join(', ')}`);
    chosen[name] = Number(rest[i + 1]);
  }
  return { input, output, isScene: input.endsWith('.scene.h5'), settings: chosen };
}
