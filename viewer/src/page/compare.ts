// Comparing the models of a file: the reader chooses, and what follows from the choice is read and drawn.
import { Closed, type OpenFile } from '../data/client.ts';
import type { Field, Largest, NodeValues, ProbeMotion, Result } from '../data/types.ts';
import { goodExaggeration, nearestExaggeration } from '../picture/fields.ts';
import { defaultSkin } from '../picture/materials.ts';
import type { Side, Stage } from '../picture/stage.ts';
import { comparison } from './comparison.ts';
import { conditionsKey } from './conditions_key.ts';
import { showChoice } from './controls.ts';
import { byId, refill, showInside } from './elements.ts';
import { legend } from './legend.ts';
import { choiceOf } from './link.ts';
import { motionPlot } from './motion_plot.ts';
import { nodeCard } from './node_card.ts';
import { colouredValues, exaggerationOf, legendEnd, partsOf, referenceOf, validModels, type Choice } from './state.ts';

/** All that is drawn of a choice. */
interface Read {
  fields: [Field, Field];
  largest: Largest[];
  values: NodeValues[];
  motions: ProbeMotion[];
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
  result(): Result | null;
  /** What the reader wants, which may not be drawn yet. */
  choice(): Choice | null;
  /** Resolves when it is drawn. */
  apply(part: Partial<Choice>): Promise<void>;
}

export interface CompareHooks {
  complain(name: string, error: unknown): void;
  /** Another choice is drawn. */
  drawn(): void;
}

/** What a reader sees of a side besides the body. */
function about(file: Result, name: string, reference: string): string {
  const model = file.models.find((m) => m.name === name)!;
  const role = name === reference ? 'Reference' : model.comparison ? '' : 'Not compared';
  const state = model.status === 'ok' ? '' : `${model.status.replace('_', ' ')}${model.message ? `: ${model.message}` : ''}`;
  return [role, model.summary, state].filter(Boolean).join(' – ');
}

async function readChoice({ result, ask }: OpenFile, { models, frame, node, quantity }: Choice): Promise<Read> {
  const strain = quantity === 'strain';
  const [fields, largest, values, motions] = await Promise.all([
    Promise.all(models.map((model) => ask('field', { model, frame, strain }))),
    Promise.all(models.map((model) => ask('largest', { model, moving: frame !== null, strain }))),
    node === null ? [] : ask('node', { node, frame }),
    result.frameTimes.length > 0 && result.probes.length > 0 ? ask('motion', { probe: 0, reference: result.motionReference }) : [],
  ]);
  return { fields: fields as [Field, Field], largest, values, motions };
}

export function createCompareView(stage: Stage, hooks: CompareHooks): CompareView {
  let file: OpenFile | null = null;
  let drawn: Choice | null = null;
  let wanted: Choice | null = null;
  let numChanges = 0;
  let numDrawn = 0;
  const change = (part: Partial<Choice>) => void apply(part);

  function draw(result: Result, choice: Choice, { fields, largest, values, motions }: Read): void {
    const reference = referenceOf(result, choice.frame !== null);
    const end = legendEnd(result, choice.models, largest, choice.quantity);
    for (const side of [0, 1] as Side[]) {
      const { displacement } = fields[side];
      const coloured = colouredValues(fields[side], choice.quantity, choice.models[side] === reference);
      stage.show(side, { ...choice, displacement, values: coloured, end, exaggeration: exaggerationOf(choice) });
      const line = document.querySelectorAll<HTMLElement>('#stage .side p')[side]!;
      line.textContent = line.title = about(result, choice.models[side]!, reference);
    }
    // Tractions are let go when motion begins.
    const shows = choice.showsConditions;
    stage.showConditions({ constrained: shows, loaded: shows && choice.frame === null });
    stage.setCut(choice.cut);
    stage.showNames(!choice.showsNames ? 'none' : choice.skin === 'translucent' ? 'all' : 'cut');
    const exceeds = largest.some((l) => l[choice.quantity] > end);
    const shade = choice.skin === 'flat' ? '' : 'Light and glass shift colours; “Exact colours” shows them as here.';
    const strain = choice.quantity === 'strain' ? 'Of straight-edged tetrahedra between the nodes; at a node the mean around it, weighted by volume.' : '';
    byId('legend').replaceChildren(...legend(choice.quantity, end, exceeds, [shade, strain].filter(Boolean).join(' ')));
    byId('conditions').replaceChildren(...(shows ? conditionsKey(result, choice.frame !== null) : []));
    const strains = new Map(choice.models.flatMap((model, side) => {
      const at = choice.node === null ? undefined : fields[side]!.strain?.[choice.node];
      return at === undefined ? [] : [[model, at] as const];
    }));
    refill(byId('node'), nodeCard(result, choice, values, strains, (node) => change({ node })));
    if (choice.node !== null && choice.node !== drawn?.node) showInside(byId('node'));
    showChoice(result, choice);
    drawMotion(result, choice, motions);
    if (drawn?.models.join() !== choice.models.join() || drawn.frame !== choice.frame)
      refill(byId('comparison'), comparison(result, choice.models, showOnTheRight));
    drawn = choice;
    byId('stage').dataset['drawn'] = String(++numDrawn);
    hooks.drawn();
  }

  function drawMotion(result: Result, choice: Choice, motions: ProbeMotion[]): void {
    byId('motion').hidden = motions.length === 0;
    if (motions.length === 0) return;
    const shown = [...new Set(choice.models)].flatMap((model) => motions.filter((m) => m.model === model));
    const now = choice.frame === null ? null : result.frameTimes[choice.frame]!;
    byId('motion').replaceChildren(...motionPlot(result.probes[0]!, shown.length > 0 ? shown : motions.slice(0, 1), now));
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
    // A model that does not move is shown at rest.
    const canMove = file.result.models.find((m) => m.name === model)?.moves;
    change({ models: [wanted.models[0], model], ...(canMove ? {} : { frame: null }) });
  }

  return {
    async prepare(next, view) {
      const { result } = next;
      const largest = await next.ask('largest', { model: result.reference, moving: false, strain: false });
      const choice: Choice = {
        models: validModels(result, false, wanted?.models ?? [result.reference, '']),
        quantity: wanted?.quantity ?? 'displacement',
        skin: wanted?.skin ?? defaultSkin,
        exaggeration: nearestExaggeration(goodExaggeration(result.points, largest.displacement)),
        frame: null,
        node: null,
        cut: null,
        showsConditions: wanted?.showsConditions ?? true,
        showsNames: wanted?.showsNames ?? true,
        ...choiceOf(view, result),
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
    result: () => file?.result ?? null,
    choice: () => wanted,
    apply,
  };
}
