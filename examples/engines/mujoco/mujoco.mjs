// Moves tissue of Livermark with the flex bodies of MuJoCo (npm @mujoco/mujoco, WebAssembly, one thread).
//   node mujoco.mjs PROBLEM.problem.h5 SOLUTION.csv [--step 1] [--corrected 0]        at rest; under a ball --step 0.02
//   node mujoco.mjs SCENE.scene.h5 MOTION.h5 [--step 0.002] [--corrected 0]           in motion
//
// A flex of dimension 3 is linear tetrahedra of the Saint Venant-Kirchhoff material. MuJoCo takes E and nu as `young` and
// `poisson`, and makes mu and lambda of them, but its force has lambda twice: the energy of a tetrahedron is
//   V (mu tr E^2 + lambda (tr E)^2)   in place of   V (mu tr E^2 + lambda / 2 (tr E)^2)
// (MetricTensor in user_mesh.cc, where la would have to be la / 2). What is typed in makes mu and lambda right, or is E and nu with --corrected 0:
//   poisson = nu / (2 - 2 nu)     young = E (1 + poisson) / (1 + nu)
// A ball is a sphere that no force moves, and contact is with facets. Its solref -1 / step^2, -1 / step puts a facet out of the ball in
// one step. MuJoCo takes a solimp of 0.9999 at most, so contact is a spring of 9999 times the nodes' mass over step^2 [N/m]: facets
// sink by less in shorter steps. Steps have the solver CG: MuJoCo's Newton has the same result, and factors a dense matrix.
// Each node is a body with its mass and three sliders. The damping of a slider is massDamping times the mass.
import { commandLine, deepest, nodeMasses, readProblem, readScene, writeMotion, writeSolution } from '../files.mjs';

const usage = 'node mujoco.mjs PROBLEM.problem.h5 SOLUTION.csv | SCENE.scene.h5 MOTION.h5 [--name value]...';
const { default: load } = await import('@mujoco/mujoco');
const mujoco = await load();

const unit = 1e6; // micronewtons and milligrams: MuJoCo stops its iterations where squares of forces are below 1e-15

/** What to type in for tissue of E [Pa] and nu. */
function typedMaterial(young, nu, isCorrected) {
  if (!isCorrected) return { young: unit * young, poisson: nu };
  const poisson = nu / (2 - 2 * nu);
  return { young: (unit * young * (1 + poisson)) / (1 + nu), poisson };
}

/** MJCF of a body: one flex for each material, which share the bodies of the nodes. Nodes in isStill have no sliders; those
 *  in isDriven (3N) are too heavy to be moved by forces, because an implicit step couples them with their neighbours. */
function modelText(body, isStill, isDriven, damping, settings) {
  const heavy = 1e6 + 1e12 * settings.step ** 2; // over the mass; the stiffest sliders have some 1e6 / s^2
  const solref = `${-((1 / settings.step) ** 2)} ${-1 / settings.step}`;
  const { points, tetrahedra, material } = body, mass = nodeMasses(body).map((m) => unit * m), nodes = [...mass.keys()];
  const sliders = (i) => ['1 0 0', '0 1 0', '0 0 1'].map((axis, c) => `<joint type="slide" axis="${axis}" damping="${damping * mass[i]}" ` +
    `armature="${isDriven[3 * i + c] ? heavy * mass[i] : 0}"/>`).join('');
  const bodies = nodes.map((i) => `<body name="${i}" pos="${points.subarray(3 * i, 3 * i + 3).join(' ')}">` +
    `<inertial pos="0 0 0" mass="${mass[i]}" diaginertia="1e-9 1e-9 1e-9"/>${isStill[i] ? '' : sliders(i)}</body>`);
  const flexes = Array.from(body.youngModulus, (E, region) => {
    const own = [...material.keys()].filter((t) => material[t] === region).flatMap((t) => [...tetrahedra.subarray(4 * t, 4 * t + 4)]);
    const used = [...new Set(own)], number = new Map(used.map((node, k) => [node, k]));
    const { young, poisson } = typedMaterial(E, body.poissonRatio[region], settings.corrected);
    const elements = own.map((node) => number.get(node)).join(' ');
    return own.length === 0 ? '' : `<flex name="region${region}" dim="3" radius="1e-5" body="${used.join(' ')}" element="${elements}">
      <contact contype="0" conaffinity="${body.touch ? 1 : 0}" condim="1" selfcollide="none" internal="false"/>
      <elasticity young="${young}" poisson="${poisson}"/></flex>`;
  });
  const ball = body.touch ? `<body name="ball" mocap="true" pos="${body.touch.start.join(' ')}"><geom type="sphere" size="${body.touch.radius}"
    priority="1" condim="1" contype="1" conaffinity="0" solref="${solref}" solimp="${settings.solimp} ${settings.solimp} 1"/></body>` : '';
  // The tolerance of a step is relative to meaninertia, which must not count those that are heavy.
  return `<mujoco><option gravity="0 0 0" timestep="${settings.step}" integrator="discrete"
    jacobian="sparse" ${body.touch ? 'solver="CG"' : ''} iterations="1000" tolerance="1e-12"><flag contact="${body.touch ? 'enable' : 'disable'}"/></option>
    <statistic meaninertia="${mass.reduce((sum, m) => sum + m) / mass.length}"/><size memory="${Math.ceil(20 + nodes.length / (body.touch ? 2 : 50))}M"/>
    <worldbody>${ball}${bodies.join('\n')}</worldbody><deformable>${flexes.join('\n')}</deformable></mujoco>`;
}

/** The engine with one body. Its q, v, spring and load are views (3N): displacement, velocity, elastic and given force. */
function engineOf(body, isStill, isDriven, damping, settings) {
  const begin = process.cpuUsage();
  mujoco.FS.writeFile('/body.xml', modelText(body, isStill, isDriven, damping, settings));
  const model = mujoco.MjModel.loadFromXML ? mujoco.MjModel.loadFromXML('/body.xml') : mujoco.MjModel.from_xml_path('/body.xml');
  const data = new mujoco.MjData(model), numNodes = body.points.length / 3;
  const free = Int32Array.from([...Array(numNodes).keys()].filter((node) => !isStill[node]));
  return {
    free, setupSeconds: seconds(begin), q: data.qpos, v: data.qvel, spring: data.qfrc_spring, load: data.qfrc_applied,
    forces: () => mujoco.mj_forward(model, data),
    step: () => mujoco.mj_step(model, data),
    setBall: (centre) => data.mocap_pos.set(centre), contact: data.qfrc_constraint,
    /** Depth by which facets are inside the ball [m]. */
    sunk: () => Array.from({ length: data.ncon }, (_, k) => -data.contact.get(k).dist).reduce((a, b) => Math.max(a, b), 0),
    /** Gives all sliders the mass of their node. Constants of a model are computed at rest, so the state is put back. */
    release() {
      const state = [data.qpos, data.qvel].map((view) => view.slice());
      model.dof_armature.fill(0);
      mujoco.mj_setConst(model, data);
      [data.qpos, data.qvel].forEach((view, k) => view.set(state[k]));
    },
    displacement() {
      const u = new Float64Array(3 * numNodes);
      free.forEach((node, k) => u.set(data.qpos.subarray(3 * k, 3 * k + 3), 3 * node));
      return u;
    },
  };
}

function seconds(begin) {
  const used = process.cpuUsage(begin);
  return (used.user + used.system) / 1e6;
}

/** Steps until forces balance to the part `settings.tolerance` of the load. Velocities are set to zero at each maximum of
 *  the kinetic energy (kinetic damping: Day 1965, Cundall 1976), so no damping has to be chosen. */
function relax(engine, problem, factor, settings) {
  const dofs = Int32Array.from(Array.from(engine.free, (node) => [3 * node, 3 * node + 1, 3 * node + 2]).flat());
  const isFixed = Uint8Array.from(dofs, (dof) => problem.fixed[dof]), mass = nodeMasses(problem);
  const ramp = problem.touch ? 50 : problem.isLarge ? 500 : 1;
  let energy = 0, steps = 0, residual = Infinity;
  for (; steps < settings.longest; ++steps) {
    const part = Math.min(1, (steps + 1) / ramp);
    for (let k = 0; k < dofs.length; ++k) {
      engine.load[k] = isFixed[k] ? 0 : unit * part * factor * problem.force[dofs[k]];
      if (!isFixed[k]) continue;
      engine.q[k] = part * factor * problem.prescribed[dofs[k]];
      engine.v[k] = 0;
    }
    if (problem.touch) engine.setBall(problem.touch.start.map((x, c) => x + part * problem.touch.press[c]));
    engine.step(); // leaves the forces at the positions where it began
    let kinetic = 0, open = 0, scale = 0;
    for (let k = 0; k < dofs.length; ++k) {
      if (!isFixed[k]) kinetic += mass[Math.floor(dofs[k] / 3)] * engine.v[k] ** 2;
      const given = engine.load[k] + engine.contact[k];
      open += isFixed[k] ? 0 : (engine.spring[k] + given) ** 2;
      scale += isFixed[k] ? engine.spring[k] ** 2 : given ** 2;
    }
    residual = scale > 0 ? Math.sqrt(open / scale) : Infinity;
    if (!Number.isFinite(scale)) throw new Error(`MuJoCo diverges with steps of ${settings.step} s; give a shorter --step`);
    if (part === 1 && residual < settings.tolerance) break;
    if (kinetic < energy) engine.v.fill(0);
    energy = kinetic < energy ? 0 : kinetic;
  }
  return { steps, residual };
}

/** Solves a problem at rest. With a depth to press, forces are scaled until force . u is that depth. */
function solve(problem, settings) {
  const isStill = Array.from(nodeMasses(problem), (_, i) => [0, 1, 2].every((c) => problem.fixed[3 * i + c] && problem.prescribed[3 * i + c] === 0));
  const engine = engineOf(problem, isStill, problem.fixed, 0, settings), begin = process.cpuUsage();
  let factor = settings.load, u, work, report;
  for (let round = 0; round < 8; ++round) {
    report = relax(engine, problem, factor, settings);
    u = engine.displacement();
    if (!problem.pressDepth) break;
    work = u.reduce((sum, value, i) => sum + value * problem.force[i], 0);
    if (Math.abs(work / problem.pressDepth - 1) < 1e-4) break;
    factor *= problem.pressDepth / work;
  }
  if (problem.touch) { // springs are in balance over all nodes: those without sliders carry what those with them do not
    const force = [0, 0, 0];
    engine.free.forEach((_, k) => force.forEach((_, c) => (force[c] += engine.spring[3 * k + c] / unit)));
    report = { ...report, at_rest: report.residual < settings.tolerance, force: Math.hypot(...force),
      deepest: deepest(problem.touch, problem.points, u), deepest_facet: engine.sunk() };
  }
  return { u: problem.pressDepth ? u : u.map((value) => value / settings.load), engine, report: { ...report, solve_seconds: seconds(begin) } };
}

/** Moves a scene. Sliders of the tool are set after each step: masses are diagonal, so no other node feels more of it. */
function move(scene, settings) {
  const numNodes = scene.points.length / 3, records = scene.time.length, numTool = scene.tool.length;
  const isStill = new Uint8Array(numNodes), isDriven = new Uint8Array(3 * numNodes);
  scene.held.forEach((node) => (isStill[node] = 1));
  scene.tool.forEach((node) => isDriven.fill(1, 3 * node, 3 * node + 3));
  const perFrame = Math.ceil((scene.time[1] - scene.time[0]) / settings.step - 1e-9), step = (scene.time[1] - scene.time[0]) / perFrame;
  const engine = engineOf(scene, isStill, isDriven, scene.massDamping, { ...settings, step });
  const place = new Map(Array.from(engine.free, (node, k) => [node, k])), at = (record, t, c) => scene.way[3 * (record * numTool + t) + c];
  const displacement = new Float32Array(records * 3 * numNodes), force = new Float64Array(3 * records);
  let used = 0;
  for (let record = 0; record < records; ++record) {
    const begin = process.cpuUsage();
    if (record === scene.lastRecordHeld + 1) engine.release();
    for (let s = 1; record > 0 && s <= perFrame; ++s) {
      engine.step();
      if (record > scene.lastRecordHeld) continue;
      scene.tool.forEach((node, t) => {
        for (let c = 0; c < 3; ++c) {
          const change = at(record, t, c) - at(record - 1, t, c), k = 3 * place.get(node) + c;
          engine.q[k] = at(record - 1, t, c) + (s / perFrame) * change;
          engine.v[k] = change / (step * perFrame);
        }
      });
    }
    used += seconds(begin);
    engine.forces();
    displacement.set(engine.displacement(), 3 * record * numNodes);
    scene.tool.forEach((node) => [0, 1, 2].forEach((c) => (force[3 * record + c] += engine.spring[3 * place.get(node) + c] / unit)));
    if (!Number.isFinite(force[3 * record])) throw new Error(`MuJoCo diverges with ${perFrame} steps in a frame; give a shorter --step`);
  }
  return { displacement, force, secondsPerFrame: used / (records - 1), engine, report: { steps_per_frame: perFrame } };
}

const { input, output, isScene, settings } = commandLine(usage, { step: 0, corrected: 1, tolerance: 1e-6, longest: 20000, load: 1, solimp: 0.9999 });
try {
  const body = isScene ? readScene(input) : readProblem(input);
  if (!settings.step) settings.step = isScene ? 2e-3 : body.touch ? 0.02 : 1;
  const result = isScene ? move(body, settings) : solve(body, settings);
  if (isScene) writeMotion(output, result);
  else writeSolution(output, body.points, result.u);
  console.log(JSON.stringify({
    engine: 'mujoco', version: mujoco.mj_versionString(), settings, ...(isScene && { seconds_per_frame: result.secondsPerFrame }),
    ...result.report, setup_seconds: result.engine.setupSeconds, memory_bytes: process.memoryUsage().rss,
  }));
} catch (error) {
  console.error(error instanceof Error && !error.excPtr ? error.message : `MuJoCo refuses the body: ${error}`);
  process.exit(2);
}
