// Moves tissue of Livermark with the soft bodies of Jolt (npm jolt-physics, WebAssembly, one thread).
//   node jolt.mjs PROBLEM.problem.h5 SOLUTION.csv     at rest
//   node jolt.mjs SCENE.scene.h5 MOTION.h5            in motion
// --substeps 20 of a frame of 1/60 s; --corrected 1: compliances as below. At rest also --damping 12 [1/s] of velocities,
// --longest 10 [s], and --part 0.003: the part of the body's size that small loads are enlarged to move it by.
//
// A soft body of Jolt is vertices with masses, edges that keep their length and tetrahedra that keep their volume, each
// with a compliance. In each substep of h seconds (mNumIterations of them in a frame) each constraint C moves its nodes
// once, by lambda = -C / (w + compliance / h^2) with w the sum of |grad C|^2 / mass (SoftBodyMotionProperties.cpp). So
// its energy is C^2 / (2 compliance), with C in metres for an edge, and C = 6 V - 6 V_rest [m^3] for a tetrahedron.
// Tissue of shear modulus mu and Lame's lambda needs
//   edge         1 / compliance = k = sum over its tetrahedra of sqrt(2) / 5 l mu [N/m]
//   tetrahedron  compliance = 36 V_rest / (lambda - mu) [m^5/N], energy (lambda - mu) / 2 V_rest (J - 1)^2
// k is Lloyd's stiffness 2 sqrt(2) / 25 l E' (Lloyd, Szekely, Harders 2007), l the edge of the regular tetrahedron of
// equal volume. His springs have lambda = mu = 2 E' / 5, so E' = 5 mu / 2, and the volume adds what lambda lacks.
// Constraints that come later in a substep move the nodes of earlier ones again. At rest that softens each by
// h^2 w / 2 in the mean, so compliance - h^2 w / 2 is typed in; --corrected 0 leaves this out.
// A ball is a static sphere that is set forward before each substep. Jolt puts vertices out of it at the end of a substep.
import { createRequire } from 'node:module';
import initJolt from 'jolt-physics';
import { commandLine, cross, deepest, dot, nodeMasses, readProblem, readScene, subtract, volumes, writeMotion, writeSolution } from '../files.mjs';

/** Edges (2S) with Lloyd's stiffness (S) [N/m] for mu, and stiffness of volumes (M) [N/m^5], 0 where there is none. */
function constraintsOf(body) {
  const stiffness = new Map(), rest = volumes(body), numNodes = body.points.length / 3;
  const ofVolume = rest.map((volume, t) => {
    const young = body.youngModulus[body.material[t]], nu = body.poissonRatio[body.material[t]];
    if (nu < 0.25) throw new Error(`Poisson's ratio is ${nu}: springs of edges have 1/4, and volumes only add to it; give 0.25 or more`);
    const mu = young / (2 + 2 * nu), lambda = young * nu / ((1 + nu) * (1 - 2 * nu));
    const k = (Math.SQRT2 / 5) * Math.cbrt(6 * Math.SQRT2 * volume) * mu, nodes = body.tetrahedra.subarray(4 * t, 4 * t + 4);
    for (const [a, b] of [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]) {
      const key = Math.min(nodes[a], nodes[b]) * numNodes + Math.max(nodes[a], nodes[b]);
      stiffness.set(key, (stiffness.get(key) ?? 0) + k);
    }
    return (lambda - mu) / (36 * volume);
  });
  const edges = Int32Array.from([...stiffness.keys()].flatMap((key) => [Math.floor(key / numNodes), key % numNodes]));
  return { edges, ofEdge: Float64Array.from(stiffness.values()), ofVolume, sixRest: rest.map((volume) => 6 * volume) };
}

const at = (x, node) => x.subarray(3 * node, 3 * node + 3);

/** Gradients of 6 V at the four nodes of a tetrahedron [m^2]. */
function gradients(x, [a, b, c, d]) {
  const ab = subtract(at(x, b), at(x, a)), ac = subtract(at(x, c), at(x, a)), ad = subtract(at(x, d), at(x, a));
  return [cross(subtract(at(x, d), at(x, b)), subtract(at(x, c), at(x, b))), cross(ac, ad), cross(ad, ab), cross(ab, ac)];
}

/** Force of edges and volumes on some nodes together, of the energy that was configured [N]. */
function forceOn(isChosen, body, { edges, ofEdge, ofVolume, sixRest }, x) {
  const force = [0, 0, 0];
  for (let e = 0; e < ofEdge.length; ++e) {
    const [a, b] = edges.subarray(2 * e, 2 * e + 2);
    if (isChosen[a] === isChosen[b]) continue;
    const along = subtract(at(x, b), at(x, a)), rest = Math.hypot(...subtract(at(body.points, b), at(body.points, a)));
    const pull = (isChosen[a] ? 1 : -1) * ofEdge[e] * (1 - rest / Math.hypot(...along));
    for (let c = 0; c < 3; ++c) force[c] += pull * along[c];
  }
  for (let t = 0; t < ofVolume.length; ++t) {
    const nodes = body.tetrahedra.subarray(4 * t, 4 * t + 4);
    if (!nodes.some((node) => isChosen[node])) continue;
    const slopes = gradients(x, nodes), ad = subtract(at(x, nodes[3]), at(x, nodes[0]));
    const push = ofVolume[t] * (dot(slopes[3], ad) - sixRest[t]);
    nodes.forEach((node, corner) => isChosen[node] && slopes[corner].forEach((slope, c) => (force[c] -= push * slope)));
  }
  return force;
}

/**
 * Jolt with one soft body, whose vertices move by step(seconds, substeps). position and velocity get and set components.
 * setBall(centre) moves the rigid ball of body.touch.
 * @param isHeld       (N) whether a node moves by its velocity alone
 * @param substep      [s]
 * @param damping      of the velocity [1/s]
 * @param isCorrected  whether compliances are less by what substeps soften
 */
async function softBody(body, constraints, isHeld, substep, damping, isCorrected) {
  const Jolt = await initJolt(), settings = new Jolt.JoltSettings();
  const pairs = new Jolt.ObjectLayerPairFilterTable(1), layers = new Jolt.BroadPhaseLayerInterfaceTable(1, 1);
  layers.MapObjectToBroadPhaseLayer(0, new Jolt.BroadPhaseLayer(0));
  pairs.EnableCollision(0, 0);
  settings.mMaxWorkerThreads = 0;
  settings.mObjectLayerPairFilter = pairs;
  settings.mBroadPhaseLayerInterface = layers;
  settings.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(layers, 1, pairs, 1);
  const system = new Jolt.JoltInterface(settings).GetPhysicsSystem(), bodies = system.GetBodyInterface();
  system.SetGravity(new Jolt.Vec3(0, 0, 0));

  const shared = new Jolt.SoftBodySharedSettings(), inverseMass = nodeMasses(body).map((mass) => 1 / mass);
  const vertex = new Jolt.SoftBodySharedSettingsVertex(), { edges, ofEdge, ofVolume } = constraints;
  inverseMass.forEach((value, node) => {
    vertex.mPosition = new Jolt.Float3(...at(body.points, node));
    vertex.mInvMass = isHeld[node] ? 0 : value;
    shared.mVertices.push_back(vertex);
  });
  const compliance = (stiffness, nodes, slopes) => {
    const w = slopes.reduce((sum, slope, n) => sum + (isHeld[nodes[n]] ? 0 : inverseMass[nodes[n]] * slope), 0);
    return Math.max(0, 1 / stiffness - (isCorrected ? 0.5 * w * substep ** 2 : 0));
  };
  ofEdge.forEach((stiffness, e) => {
    const nodes = edges.subarray(2 * e, 2 * e + 2);
    shared.mEdgeConstraints.push_back(new Jolt.SoftBodySharedSettingsEdge(...nodes, compliance(stiffness, nodes, [1, 1])));
  });
  ofVolume.forEach((stiffness, t) => {
    const nodes = body.tetrahedra.subarray(4 * t, 4 * t + 4), slopes = gradients(body.points, nodes).map((g) => dot(g, g));
    if (stiffness > 0)
      shared.mVolumeConstraints.push_back(new Jolt.SoftBodySharedSettingsVolume(...nodes, compliance(stiffness, nodes, slopes)));
  });
  shared.CalculateEdgeLengths();
  shared.CalculateVolumeConstraintVolumes();
  shared.Optimize();

  const creation = new Jolt.SoftBodyCreationSettings(shared, new Jolt.RVec3(0, 0, 0), new Jolt.Quat(0, 0, 0, 1), 0);
  creation.mLinearDamping = damping;
  creation.mFriction = 0;
  creation.mUpdatePosition = creation.mAllowSleeping = false;
  const handle = bodies.CreateSoftBody(creation), ball = body.touch && bodies.CreateAndAddBody(new Jolt.BodyCreationSettings(
    new Jolt.SphereShape(body.touch.radius), new Jolt.RVec3(...body.touch.start), new Jolt.Quat(0, 0, 0, 1), Jolt.EMotionType_Static, 0),
  Jolt.EActivation_DontActivate);
  const motion = Jolt.castObject(handle.GetMotionProperties(), Jolt.SoftBodyMotionProperties), vertices = motion.GetVertices();
  const traits = Jolt.SoftBodyVertexTraits.prototype, bytes = Float32Array.BYTES_PER_ELEMENT;
  const first = Jolt.getPointer(vertices.at(0)), stride = Jolt.getPointer(vertices.at(1)) - first;
  const field = (offset) => ({
    get: (i) => Jolt.HEAPF32[(first + Math.floor(i / 3) * stride + offset) / bytes + (i % 3)],
    set: (i, value) => (Jolt.HEAPF32[(first + Math.floor(i / 3) * stride + offset) / bytes + (i % 3)] = value),
  });
  return {
    inverseMass, position: field(traits.mPositionOffset), velocity: field(traits.mVelocityOffset),
    setBall: (centre) => bodies.SetPosition(ball, new Jolt.RVec3(...centre), Jolt.EActivation_DontActivate),
    release: (node) => (vertices.at(node).mInvMass = inverseMass[node]),
    step(seconds, substeps) {
      motion.SetNumIterations(substeps);
      motion.CustomUpdate(seconds, handle, system);
    },
  };
}

const displacement = (engine, points) => Float64Array.from(points, (x, i) => engine.position.get(i) - x);
const heldNodes = ({ points, fixed }) => Array.from({ length: points.length / 3 }, (_, node) => at(fixed, node).every((value) => value));
const norm = (u) => Math.sqrt(u.reduce((sum, value) => sum + value * value, 0));
const work = ({ force }, u) => u.reduce((sum, value, i) => sum + value * force[i], 0);

/**
 * Equilibrium under a multiple of the forces and prescribed displacements: the mean over half a second [m], when the
 * next differs by less than a thousandth, or after longest seconds. A step is a substep, because Jolt has no nodal
 * forces: they are velocities here. Its damping acts on these as well, hence the quotient. A ball
 * moves in during the first half second.
 */
async function relax(problem, constraints, multiple, { substeps, damping, longest, corrected }) {
  const { points, fixed, prescribed, force, touch } = problem, h = 1 / 60 / substeps, halfSecond = 30 * substeps;
  const isHeld = heldNodes(problem);
  const engine = await softBody(problem, constraints, isHeld, h, damping, corrected);
  const loaded = [...force.keys()].filter((i) => force[i] !== 0 && !fixed[i]), held = [...fixed.keys()].filter((i) => fixed[i]);
  const kick = (i) => (multiple * h * force[i] * engine.inverseMass[Math.floor(i / 3)]) / (1 - damping * h);
  let mean = new Float64Array(points.length), seconds = 0, change = Infinity;
  while (change > 1e-3 && seconds < longest) {
    const before = mean;
    mean = new Float64Array(points.length);
    for (let step = 0; step < halfSecond; ++step) {
      for (const i of held) {
        engine.position.set(i, points[i] + multiple * prescribed[i]);
        engine.velocity.set(i, 0);
      }
      if (touch && seconds === 0) engine.setBall(touch.start.map((x, c) => x + ((step + 1) / halfSecond) * touch.press[c]));
      for (const i of loaded) engine.velocity.set(i, engine.velocity.get(i) + kick(i));
      engine.step(h, 1);
      for (let i = 0; i < points.length; ++i) mean[i] += (engine.position.get(i) - points[i]) / halfSecond;
    }
    for (const i of held) mean[i] = multiple * prescribed[i];
    change = norm(mean.map((value, i) => value - before[i])) / norm(mean);
    seconds += 0.5;
  }
  if (!(change < 0.1)) throw new Error(`Jolt comes to no rest, the last change is ${change}; take more --substeps or --damping`);
  return { u: mean, seconds, change };
}

/**
 * Small loads are too small for positions in single precision, and the answer is linear: it is half the difference of
 * loads that move a small part of the body there and back, which has no quadratic part.
 */
async function rest(problem, constraints, settings) {
  const size = Math.max(...[0, 1, 2].map((c) => {
    const x = problem.points.filter((_, i) => i % 3 === c);
    return x.reduce((a, b) => Math.max(a, b)) - x.reduce((a, b) => Math.min(a, b));
  }));
  const enlarged = problem.isLarge ? 1 : (settings.part * size) / problem.targetPeak, depth = problem.pressDepth * enlarged;
  let multiple = enlarged, run;
  const relaxed = (value) => relax(problem, constraints, value, settings);
  if (depth > 0) { // by secants from the origin, from a guess
    multiple = 0.1 * problem.youngModulus[0] * size * depth;
    for (let error = 1, turns = 0; error > (problem.isLarge ? 1e-3 : 0.2) && turns < 10; ++turns) {
      run = await relaxed(multiple);
      error = Math.abs(work(problem, run.u) / depth - 1);
      multiple *= depth / work(problem, run.u);
    }
  }
  if (!problem.isLarge || !run) run = await relaxed(multiple);
  let { u, seconds, change } = run;
  if (!problem.isLarge) {
    const back = await relaxed(-multiple);
    u = u.map((value, i) => (value - back.u[i]) / (2 * multiple));
    if (depth > 0) u = u.map((value) => (value * problem.pressDepth) / work(problem, u));
  }
  const report = { relaxed_seconds: seconds, last_change: change, work: work(problem, u) };
  if (!problem.touch) return { u, report };
  const force = Math.hypot(...forceOn(heldNodes(problem), problem, constraints, u.map((value, i) => value + problem.points[i])));
  return { u, report: { ...report, at_rest: change <= 1e-3, force, deepest: deepest(problem.touch, problem.points, u) } };
}

const processorSeconds = () => 1e-6 * (process.cpuUsage().user + process.cpuUsage().system);

/** The scene in frames; the tool moves its nodes by their velocities. Set-up is all until the first frame. */
async function move(scene, constraints, { substeps, corrected }) {
  const { points, tool, time, way } = scene, numNodes = points.length / 3;
  const isTool = new Uint8Array(numNodes), isHeld = new Uint8Array(numNodes);
  for (const node of tool) isTool[node] = isHeld[node] = 1;
  for (const node of scene.held) isHeld[node] = 1;
  const engine = await softBody(scene, constraints, isHeld, (time[1] - time[0]) / substeps, scene.massDamping, corrected);
  const setupSeconds = processorSeconds();
  const motion = { displacement: new Float32Array(time.length * points.length), force: new Float64Array(3 * time.length) };
  let seconds = 0;
  for (let k = 1; k < time.length; ++k) {
    const duration = time[k] - time[k - 1], isTouched = k <= scene.lastRecordHeld;
    tool.forEach((node, n) => {
      for (let c = 0; c < 3 && isTouched; ++c) {
        const i = 3 * node + c, goal = points[i] + way[3 * (k * tool.length + n) + c];
        engine.velocity.set(i, (goal - engine.position.get(i)) / duration);
      }
      if (k === scene.lastRecordHeld + 1) engine.release(node);
    });
    const before = processorSeconds();
    engine.step(duration, substeps);
    seconds += processorSeconds() - before;
    const u = displacement(engine, points);
    motion.displacement.set(u, k * u.length);
    if (isTouched) motion.force.set(forceOn(isTool, scene, constraints, u.map((value, i) => value + points[i])), 3 * k);
  }
  return { ...motion, secondsPerFrame: seconds / (time.length - 1), setupSeconds };
}

const defaults = { substeps: 20, corrected: 1, damping: 12, longest: 10, part: 0.003 };
const usage = 'node jolt.mjs PROBLEM.problem.h5 SOLUTION.csv | SCENE.scene.h5 MOTION.h5 [--OPTION NUMBER]...';
const { input, output, isScene, settings } = commandLine(usage, defaults);
const report = { engine: 'jolt', version: createRequire(import.meta.url)('jolt-physics/package.json').version, settings };
try {
  if (isScene) {
    const scene = readScene(input), motion = await move(scene, constraintsOf(scene), settings);
    writeMotion(output, motion);
    Object.assign(report, { seconds_per_frame: motion.secondsPerFrame, setup_seconds: motion.setupSeconds });
  } else {
    const problem = readProblem(input), solution = await rest(problem, constraintsOf(problem), settings);
    writeSolution(output, problem.points, solution.u);
    Object.assign(report, solution.report, { solve_seconds: processorSeconds() });
  }
  console.log(JSON.stringify({ ...report, memory_bytes: process.memoryUsage().rss }));
} catch (error) {
  console.error(`jolt.mjs: ${error.message}`);
  process.exitCode = 2;
}
