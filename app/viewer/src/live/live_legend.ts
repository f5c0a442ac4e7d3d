// The legend of the live page, and the controls of what the colours show and where they end.
import { byId, element } from '../page/elements.ts';
import { listed, type ColourEntry } from '../page/patch_legend.ts';
import type { PictureFrame } from '../page/save.ts';
import { gradient } from '../picture/colour_maps.ts';
import { ticks } from '../picture/scale.ts';
import { createColourRange, type ColourRange } from './colour_range.ts';
import { shownFields, type Shown, type ShownQuantity } from './shown_field.ts';

export interface LiveLegend {
  shown(): Shown;
  end(): number;
  /** @param values  of what is drawn now, on both sides @return whether the colours end elsewhere now */
  see(values: readonly (Float32Array | null)[]): boolean;
  /** What the picture adds, as that light shifts colours. */
  note(sentence: string): void;
  /** As it is now; the end in the unit of the name. */
  now(): PictureFrame['legend'];
  /** What the body is made of. */
  setTissue(entries: ColourEntry[]): void;
  /** Where the colours end if they stay there, in the unit of the legend; null where they follow. */
  fixedEnd(): number | null;
  /** @param fixedEnd  as above */
  set(shown: Shown, fixedEnd: number | null): void;
  /** Whether the springs move on from where FEM was asked: the difference is that of a moment. */
  setMoving(isMoving: boolean): void;
  /** Whether FEM is there to be compared with. */
  allowDifference(isThere: boolean): void;
}

const endField = () => byId<HTMLInputElement>('live-legend-end');
const followsBox = () => byId<HTMLInputElement>('live-legend-follows');
const form = () => byId<HTMLFormElement>('live-colours');
const radio = (shown: Shown) => form().querySelector<HTMLInputElement>(`[value=${shown}]`)!;

const largestOf = (values: readonly (Float32Array | null)[]) =>
  values.reduce((most, list) => list?.reduce((m, value) => (value > m && value < Infinity ? value : m), most) ?? most, 0);

/** @param changed  is called when the reader wants other colours */
export function createLiveLegend(changed: () => void): LiveLegend {
  const rangeOf = ({ inUnit, least }: (typeof shownFields)[ShownQuantity]) => createColourRange(inUnit, least);
  const ranges: Record<ShownQuantity, ColourRange> = {
    displacement: rangeOf(shownFields.displacement),
    difference: rangeOf(shownFields.difference),
    strain: rangeOf(shownFields.strain),
  };
  let shown: Shown = 'displacement';
  let isExceeded = false;
  let added = '';
  let isMoving = false;
  let tissue: ColourEntry[] = [];

  const endInUnit = (field: ShownQuantity) => Number((ranges[field].end() / shownFields[field].inUnit).toPrecision(6));

  /** The field and its unit. */
  function heading(field: ShownQuantity): string {
    const { name, unit } = shownFields[field];
    return `${name}${isMoving && field === 'difference' ? ', still moving' : ''} [${unit}]`;
  }

  function draw(): void {
    const notes = added && shown !== 'tissue' ? [element('p', { class: 'note' }, added)] : [];
    endField().disabled = followsBox().disabled = shown === 'tissue';
    if (shown === 'tissue') return byId('live-legend').replaceChildren(listed(tissue, 'What the body is made of'));
    const { quantity, unit } = shownFields[shown];
    const range = ranges[shown];
    const end = endInUnit(shown);
    const numbers = ticks(end).map((value) => {
      const isLast = Math.abs(value - end) < 1e-9 * end;
      return element('span', { style: `left: ${(100 * value) / end}%` }, `${isLast && isExceeded ? '≥ ' : ''}${value}`);
    });
    byId('live-legend').replaceChildren(
      element('div', { class: 'what' }, heading(shown)),
      element('div', { class: 'strip', style: `background: ${gradient(quantity)}` }),
      element('div', { class: 'numbers', 'data-end': end }, ...numbers),
      ...notes);
    followsBox().checked = range.follows();
    byId('live-legend-unit').textContent = unit;
    if (document.activeElement !== endField()) endField().value = String(end); // not while somebody types in it
  }

  form().addEventListener('submit', (event) => event.preventDefault());
  form().addEventListener('change', (event) => {
    const input = event.target as HTMLInputElement;
    if (input.name === 'live-shown') shown = input.value as Shown;
    else if (shown !== 'tissue' && input === followsBox()) input.checked ? ranges[shown].follow() : ranges[shown].fix();
    else if (shown !== 'tissue' && input === endField() && input.valueAsNumber > 0 && input.valueAsNumber < Infinity)
      ranges[shown].fix(input.valueAsNumber * shownFields[shown].inUnit);
    draw();
    changed();
  });
  draw();

  return {
    shown: () => shown,
    end: () => (shown === 'tissue' ? 1 : ranges[shown].end()),
    see(values) {
      if (shown === 'tissue') return false;
      const range = ranges[shown];
      const largest = largestOf(values);
      const isNew = range.see(largest, performance.now() / 1000);
      const exceeds = largest > range.end();
      if (isNew || exceeds !== isExceeded) {
        isExceeded = exceeds;
        draw();
      }
      return isNew;
    },
    note(sentence) {
      added = sentence;
      draw();
    },
    now: () => (shown === 'tissue' ? tissue : { name: heading(shown), end: endInUnit(shown), quantity: shownFields[shown].quantity }),
    setTissue(entries) {
      tissue = entries;
      draw();
    },
    fixedEnd: () => (shown === 'tissue' || ranges[shown].follows() ? null : endInUnit(shown)),
    set(next, fixedEnd) {
      if (radio(next).disabled) return;
      shown = next;
      radio(shown).checked = true;
      if (next !== 'tissue') {
        if (fixedEnd === null) ranges[next].follow();
        else ranges[next].fix(fixedEnd * shownFields[next].inUnit);
      }
      draw();
      changed();
    },
    setMoving(moves) {
      if (moves === isMoving) return;
      isMoving = moves;
      draw();
    },
    allowDifference(isThere) {
      radio('difference').disabled = !isThere;
      if (isThere || shown !== 'difference') return;
      shown = 'displacement';
      radio(shown).checked = true;
      draw();
    },
  };
}
