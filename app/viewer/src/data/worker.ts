// Reads one file, off the thread that draws. The file stays where it is: only what is asked for is read.
import * as hdf5 from 'h5wasm';
import { has, setMaker } from './hdf5.ts';
import type { Content, Kind, Message, Questions, Reply } from './messages.ts';
import { nodalVolumes } from './nodal_volumes.ts';
import { readBody } from './read_body.ts';
import { readExperiment } from './read_experiment.ts';
import { readField, readLargest, readMotion, readNode } from './read_fields.ts';
import { readMesh } from './read_mesh.ts';
import { readForces, readPointErrors } from './read_path.ts';
import { readResult } from './read_result.ts';
import { nodalStrain, strainMesh, type StrainMesh } from './strain.ts';
import { Fault, type Field, type Largest, type Moment, type Result } from './types.ts';

const signature = [0x89, 0x48, 0x44, 0x46, 0x0d, 0x0a, 0x1a, 0x0a]; // of HDF5

interface Opened {
  file: hdf5.File;
  result: Result;
  strain: StrainMesh | null; // once somebody has asked for it, like the volumes
  volumes: Float64Array | null; // (N) m^3
}
let opened: Opened | null = null;

async function refuseWhatIsNotHdf5(file: File): Promise<void> {
  const start = new Uint8Array(await file.slice(0, signature.length).arrayBuffer());
  if (file.size === 0) throw new Fault('It is empty. Choose a result file that livermark run wrote.');
  if (signature.some((byte, i) => start[i] !== byte))
    throw new Fault('It is not an HDF5 file. Choose a result file that livermark run wrote, such as palpation.h5.');
}

function openMounted(path: string): hdf5.File {
  let file: hdf5.File | null = null;
  try {
    file = new hdf5.File(path, 'r');
  } catch {
    // The library says no more than the sentence below.
  }
  if (!file || file.file_id < 0n) throw new Fault('It is cut off or damaged. Copy it again, or make it again with livermark run.');
  return file;
}

async function open(file: File): Promise<Content> {
  await refuseWhatIsNotHdf5(file);
  const { FS } = await hdf5.ready;
  const folder = '/opened';
  FS.mkdir(folder);
  FS.mount(FS.filesystems['WORKERFS']!, { blobs: [{ name: 'result.h5', data: file }] }, folder);
  const mounted = openMounted(`${folder}/result.h5`);
  if (has(mounted, '/experiment')) {
    setMaker(mounted, 'livermark experiment');
    return { experiment: readExperiment(mounted, file.name) };
  }
  const result = readResult(mounted, file.name);
  opened = { file: mounted, result, strain: null, volumes: null };
  return { result };
}

function shown(): Opened {
  if (!opened) throw new Fault('No file is open.');
  return opened;
}

const source = () => ({ file: shown().file, reference: shown().result.reference, numNodes: shown().result.points.length / 3 });

function strainOf(displacement: Float32Array): Float32Array {
  const mine = shown();
  mine.strain ??= strainMesh(readMesh(mine.file).points, mine.result.tetrahedra);
  return nodalStrain(mine.strain, displacement);
}

function volumes(): Float64Array {
  const mine = shown();
  mine.volumes ??= nodalVolumes(readMesh(mine.file).points, mine.result.tetrahedra);
  return mine.volumes;
}

function field({ model, moment, strain }: Questions['field']['question']): Field {
  const read = readField(source(), model, moment);
  return { ...read, strain: strain ? strainOf(read.displacement) : null };
}

const greatestStrains = new Map<string, number>();

/** Those that have one legend. */
function momentsOf(model: string, moving: boolean): Moment[] {
  const { frameTimes, models } = shown().result;
  if (moving) return frameTimes.map((_, frame) => ({ frame, point: null }));
  const numPoints = models.find(({ name }) => name === model)?.numPoints ?? 0;
  return [{ frame: null, point: null }, ...Array.from({ length: numPoints }, (_, point) => ({ frame: null, point }))];
}

function largestStrain(model: string, moving: boolean): number {
  const key = `${moving} ${model}`;
  const find = () => {
    let most = 0;
    for (const moment of momentsOf(model, moving))
      for (const value of strainOf(readField(source(), model, moment).displacement))
        if (value > most && value < Infinity) most = value;
    return most;
  };
  const known = greatestStrains.get(key) ?? find();
  greatestStrains.set(key, known);
  return known;
}

const greatestLengths = new Map<string, Omit<Largest, 'strain'>>();

function largest({ model, moving, strain }: Questions['largest']['question']): Largest {
  const key = `${moving} ${model}`;
  const known = greatestLengths.get(key) ?? readLargest(source(), model, moving);
  greatestLengths.set(key, known);
  return { ...known, strain: strain ? largestStrain(model, moving) : 0 };
}

type Answers = { [K in Kind]: (question: Questions[K]['question']) => Questions[K]['answer'] | Promise<Questions[K]['answer']> };
const answers: Answers = {
  open: ({ file }) => open(file),
  field,
  largest,
  node: ({ node, moment }) => readNode(source(), node, moment),
  motion: ({ probe, reference }) => readMotion(shown().file, probe, shown().result.probes.length, reference),
  errors: ({ point }) => readPointErrors(shown().file, shown().result, point, volumes()),
  forces: () => readForces(shown().file, shown().result),
  body: () => readBody(shown().file),
};

async function reply<K extends Kind>({ id, kind, question }: Message<K>): Promise<Reply> {
  try {
    return { id, answer: await answers[kind](question) };
  } catch (error) {
    if (error instanceof Fault) return { id, fault: error.message };
    return { id, fault: `It cannot be read (${String(error)}). Make it again with livermark run.` };
  }
}

// One after the other: a file that is still being opened must not be asked for fields.
let last: Promise<void> = Promise.resolve();
self.onmessage = (event: MessageEvent<Message>) => {
  last = last.then(async () => self.postMessage(await reply(event.data)));
};
