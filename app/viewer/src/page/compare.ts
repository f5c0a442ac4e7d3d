// Comparing the models of a file: the reader chooses, and what follows from the choice is read and drawn.
import { Closed, type OpenFile } from '../data/client.ts';
import { courseOf, type Field, type ForcePlot, type Largest, type Model, type NodeValues, type PointErrors, type ProbeMotion, type Result } from '../data/types.ts';
import type { Colouring, Quantity, SolvedQuantity } from '../picture/colour_maps.ts';
import { goodExaggeration, nearestExaggeration } from '../picture/fields.ts';
import { short } from '../picture/scale.ts';
import type { Names } from '../picture/section.ts';
import type { Side, Stage } from '../picture/stage.ts';
import { comparison, verdict } from './comparison.ts';
import { conditionsKey } from './conditions_key.ts';
import { showChoice } from './controls.ts';
import { byId, refill, showInside } from './elements.ts';
import { forcePlots } from './force_plot.ts';
import { legend, scales } from './legend.ts';
import { choiceOf } from './link.ts';
import { atPoint, endOfPath, loadName, loadOf } from './loads.ts';
import { motionPlot } from './motion_plot.ts';
import { nodeCard } from './node_card.ts';
import { patchLegend, tissueLegend } from './patch_legend.ts';
import { vesselsKey } from './vessels_key.ts';
import { atLoad, colouredValues, exaggerationOf, firstLook, legendEnd, lookOf, modulusEnd, partsOf, referenceOf, validModels, validQuantity, type Choice } from './state.ts';

/** All that is drawn of a choice. */
interface Read {
  fields: [Field, Field];
  largest: Largest[];
  values: NodeValues[];
  motions: ProbeMotion[];
  errors: PointErrors[]; // at a part of the load
  forces: ForcePlot[];
}

/** A file, and what is shown of it first. */
export interface Prepared {
  file: OpenFile;
  choice: Choice;
  read: Read;
}

export interface CompareView {
  /** @throws Fault if something of it cannot be read */
  prepare(file: OpenFile, view: URLSearchParams): Promise<Prepared>;
  show(prepared: Prepared): void;
  /** Another kind of file is shown. */
  close(): void;
  result(): Result | null;
  /** The result with the errors of the moment that is drawn. */
  seen(): Result | null;
  /** What the reader wants, which may not be drawn yet. */
  choice(): Choice | null;
  /** Resolves when it is drawn. */
  apply(part: Partial<Choice>): Promise<void>;
}

export interface CompareHooks {
  complain(name: string, error: unknown): void;
  /** Another choice is drawn. @param fields  of the two models */
  drawn(result: Result, choice: Choice, fields: [Field, Field]): void;
}

/** What a model is to the others. */
function roleOf(model: Model, reference: string, { quantity }: Choice): string {
  if (model.name !== reference) return model.comparison ? '' : 'Not compared';
  return quantity === 'error' ? 'Reference, from which errors are measured: it has none, and is grey' : 'Reference';
}

function stateOf({ status, message }: Model): string {
  if (status === 'ok') return '';
  return status.replace('_', ' ') + (message ? `: ${message}` : '');
}

/** Value at the end of the colours. */
function endOf(result: Result, { quantity, models }: Choice, largest: Largest[]): number {
  if (quantity === 'modulus' && result.modulus) return modulusEnd(result.modulus);
  return quantity === 'patches' || quantity === 'tissue' ? 1 : legendEnd(result, models, largest, quantity as SolvedQuantity);
}

/** What of the inside has its name in the picture. */
function namesIn({ showsNames, skin }: Choice): Names {
  if (!showsNames) return 'none';
  return skin === 'translucent' ? 'all' : 'cut';
}

/** What a reader sees of a side besides the body. */
function about(file: Result, name: string, reference: string, choice: Choice): string {
  const model = file.models.find((m) => m.name === name)!;
  return [roleOf(model, reference, choice), endOfPath(file, model, choice), model.summary, stateOf(model)].filter(Boolean).join(' – ');
}

async function readChoice({ result, ask }: OpenFile, { models, frame, point, node, quantity }: Choice): Promise<Read> {
  const strain = quantity === 'strain';
  const moment = { frame, point };
  const course = courseOf(moment);
  const [fields, largest, values, motions, errors, forces] = await Promise.all([
    Promise.all(models.map((model) => ask('field', { model, moment, strain }))),
    Promise.all(models.map((model) => ask('largest', { model, moving: frame !== null, strain }))),
    node === null ? [] : ask('node', { node, moment }),
    result.frameTimes.length > 0 && result.probes.length > 0 ? ask('motion', { probe: 0, reference: result.motionReference }) : [],
    course === 'path' ? ask('errors', { point: point! }) : [],
    result.loads.length > 0 && result.places.length > 0 ? ask('forces', null) : [],
  ]);
  return { fields: fields as [Field, Field], largest, values, motions, errors, forces };
}

export function createCompareView(stage: Stage, hooks: CompareHooks): CompareView {
  let file: OpenFile | null = null;
  let drawn: Choice | null = null;
  let wanted: Choice | null = null;
  let seen: Result | null = null;
  let numChanges = 0;
  let numDrawn = 0;
  const change = (part: Partial<Choice>) => void apply(part);

  function draw(result: Result, choice: Choice, { fields, largest, values, motions, errors, forces }: Read): void {
    const reference = referenceOf(result, choice.frame !== null);
    const load = loadName(result, choice);
    seen = atPoint(result, choice, errors);
    const modulus = choice.quantity === 'modulus' ? result.modulus : null;
    const ofBody = choice.quantity === 'tissue' ? result.tissue : modulus;
    const end = endOf(result, choice, largest);
    for (const side of [0, 1] as Side[]) {
      const { displacement } = fields[side];
      const coloured = ofBody ?? colouredValues(fields[side], choice.quantity as SolvedQuantity | 'patches');
      stage.show(side, { ...choice, displacement, values: coloured, end, exaggeration: exaggerationOf(choice) });
      const line = document.querySelectorAll<HTMLElement>('#stage .side p')[side]!;
      line.textContent = line.title = about(seen, choice.models[side]!, reference, choice);
    }
    // Tractions are let go when motion begins.
    const shows = choice.showsConditions;
    stage.showConditions({ constrained: shows, loaded: shows && choice.frame === null });
    stage.showVessels(choice.showsVessels);
    stage.setCut(choice.cut);
    stage.showSurfaceNames(choice.quantity === 'patches' && choice.showsNames);
    stage.showNames(namesIn(choice));
    const shade = choice.skin === 'flat' ? '' : 'Light and glass shift colours; “Exact colours” shows them as here.';
    byId('legend').replaceChildren(...legendOf(result, choice, end, largest, [loadNote(fields, choice.quantity, load), shade]));
    byId('verdict').textContent = verdict(seen, choice.models[1], load);
    byId('conditions').replaceChildren(...(shows ? conditionsKey(result, choice.frame !== null, loadOf(result, choice)) : []),
      ...(choice.showsVessels ? vesselsKey(result, choice.skin === 'translucent' || choice.cut !== null) : []));
    const strains = new Map(choice.models.flatMap((model, side) => {
      const at = choice.node === null ? undefined : fields[side]!.strain?.[choice.node];
      return at === undefined ? [] : [[model, at] as const];
    }));
    refill(byId('node'), nodeCard(result, choice, values, strains, (node) => change({ node })));
    if (choice.node !== null && choice.node !== drawn?.node) showInside(byId('node'));
    showChoice(result, choice);
    drawMotion(result, choice, motions);
    drawForces(result, choice, forces);
    if (drawn?.models.join() !== choice.models.join() || drawn.frame !== choice.frame || drawn.point !== choice.point)
      refill(byId('comparison'), comparison(seen, choice.models, load, showOnTheRight));
    drawn = choice;
    byId('stage').dataset['drawn'] = String(++numDrawn);
    hooks.drawn(result, choice, fields);
  }

  function drawMotion(result: Result, choice: Choice, motions: ProbeMotion[]): void {
    byId('motion').hidden = motions.length === 0;
    if (motions.length === 0) return;
    const shown = [...new Set(choice.models)].flatMap((model) => motions.filter((m) => m.model === model));
    const now = choice.frame === null ? null : result.frameTimes[choice.frame]!;
    byId('motion').replaceChildren(...motionPlot(result.probes[0]!, shown.length > 0 ? shown : motions.slice(0, 1), now));
  }

  /** What the colours mean. @param notes  beside numbers; the last stands beside patches as well */
  function legendOf(result: Result, { quantity }: Choice, end: number, largest: Largest[], notes: [load: string, shade: string]): Node[] {
    if (quantity === 'patches') return patchLegend(result, notes[1]);
    return quantity === 'tissue' ? [tissueLegend(result)] : scaleOf(quantity, end, largest, notes);
  }

  function scaleOf(quantity: Quantity, end: number, largest: Largest[], notes: string[]): Node[] {
    if (quantity === 'modulus')
      return legend(quantity, end, false, [...notes, 'Of the map of stiffness; at a node the mean around it, weighted by volume.'].filter(Boolean).join(' '));
    const exceeds = largest.some((l) => l[quantity] > end * (1 + 1e-6));
    const strain = quantity === 'strain' ? 'Of straight-edged tetrahedra between the nodes; at a node the mean around it, weighted by volume.' : '';
    return legend(quantity, end, exceeds, [...notes, strain].filter(Boolean).join(' '));
  }

  /** Beside the legend, which is the same at all parts of the load. */
  function loadNote(fields: [Field, Field], quantity: Colouring, load: string): string {
    if (!load || quantity === 'modulus' || quantity === 'patches' || quantity === 'tissue') return '';
    const largest = fields.map((field) => {
      const known = colouredValues(field, quantity).filter(Number.isFinite);
      return known.length > 0 ? `${short(scales[quantity].factor * known.reduce((a, b) => Math.max(a, b)))} ${quantity === 'strain' ? '%' : 'mm'}` : '–';
    });
    return `The same colours at all parts of the load; largest at ${load}: ${largest.join(' and ')}.`;
  }

  function drawForces(result: Result, choice: Choice, forces: ForcePlot[]): void {
    byId('forces').hidden = forces.length === 0 || choice.frame !== null;
    const now = choice.point ?? result.loads.length - 1;
    refill(byId('forces'), forces.length === 0 ? [] : forcePlots(forces, result, choice.models, now, (point) => change(atLoad(result, choice, point))));
  }

  async function apply(part: Partial<Choice>): Promise<void> {
    if (!file || !wanted) return;
    wanted = { ...wanted, ...part };
    const [mine, of, choice] = [++numChanges, file, wanted];
    try {
      const read = await readChoice(of, choice);
      if (mine === numChanges) draw(of.result, choice, read);
    } catch (error) {
      if (mine !== numChanges || error instanceof Closed) return;
      // The controls say what is drawn, not what could not be read.
      wanted = drawn;
      if (drawn) showChoice(of.result, drawn);
      hooks.complain(of.result.file, error);
    }
  }

  function showOnTheRight(model: string): void {
    if (!file || !wanted) return;
    // A model that does not move is shown at rest, and one without a path under the whole load.
    const known = file.result.models.find((m) => m.name === model);
    change({ models: [wanted.models[0], model], ...(known?.moves ? {} : { frame: null }), ...(known?.numPoints ? {} : { point: null }) });
  }

  return {
    async prepare(next, view) {
      const { result } = next;
      const largest = await next.ask('largest', { model: result.reference, moving: false, strain: false });
      const asked = choiceOf(view, result);
      const look = wanted ? { quantity: validQuantity(result, wanted.quantity), skin: wanted.skin } : firstLook(result);
      const choice: Choice = {
        models: validModels(result, 'load', wanted?.models ?? [result.reference, '']),
        ...look,
        ...(asked.quantity ? lookOf(asked.quantity, look) : {}),
        exaggeration: nearestExaggeration(goodExaggeration(result.points, largest.displacement)),
        frame: null,
        point: null,
        node: null,
        cut: null,
        showsConditions: wanted?.showsConditions ?? true,
        showsNames: wanted?.showsNames ?? true,
        showsVessels: wanted?.showsVessels ?? true,
        ...asked,
      };
      return { file: next, choice, read: await readChoice(next, choice) };
    },
    show(prepared) {
      file?.close();
      file = prepared.file;
      drawn = null;
      wanted = prepared.choice;
      numChanges++; // what was asked of the file before is not drawn any more
      stage.setBody(file.result.points, file.result.surfaces, partsOf(file.result));
      draw(file.result, prepared.choice, prepared.read);
    },
    close() {
      file?.close();
      file = drawn = seen = null;
      numChanges++;
    },
    result: () => file?.result ?? null,
    seen: () => seen,
    choice: () => wanted,
    apply,
  };
}
