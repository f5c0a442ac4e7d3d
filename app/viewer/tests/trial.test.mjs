// A reckless user of the springs of the live page, in a browser: no motion is lost. kernel_trial.mjs tries for longer.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { frameOf, noReplay, playNatively, startHarness } from './springs.mjs';
import { bodyOfMessage, noTrial, rowOfMessage, trialMessages } from './trial.mjs';

let harness;
before(async () => {
  if (!noTrial) harness = await startHarness();
});
after(() => harness?.stop());

async function opened(name, numSteps, seed) {
  const [first, ...messages] = trialMessages(name, numSteps, seed);
  const body = bodyOfMessage(first);
  const laws = await harness.open(body);
  return { body, laws, rows: messages.map((message) => rowOfMessage(message, laws)) };
}

async function losesNothing(name, numSteps, seed) {
  const { rows } = await opened(name, numSteps, seed);
  const answers = await harness.play(rows);
  let smallest = 1, strongest = 0;
  rows.forEach(({ kind }, i) => {
    if (kind !== 'move') return;
    const { finite, restarts, force, indentation, smallestVolume } = answers[i];
    assert.ok(finite && [...force, indentation, smallestVolume].every(Number.isFinite), `row ${i}`);
    assert.equal(restarts, 0, `row ${i}: the motion left all bounds`);
    smallest = Math.min(smallest, smallestVolume);
    strongest = Math.max(strongest, Math.hypot(...force));
  });
  assert.ok(smallest < 0.5 && strongest > 2, 'the hand was a rough one');
  assert.ok(rows.filter(({ kind }) => kind === 'choose').length > 1);
}

test('a trial of 60 steps loses no motion of a beam of 63 nodes', { skip: noTrial }, () => losesNothing('small_beam', 60, 1));
test('a trial of 16 steps loses no motion of the liver', { skip: noTrial }, () => losesNothing('liver_healthy', 16, 1));

test('what is torn moves as natively, bit for bit', { skip: noTrial || noReplay }, async () => {
  const { body, laws, rows } = await opened('small_beam', 20, 3);
  // The longest step is told by an eigenvalue, whose last digits are those of a C library: so it is asked for by name.
  const choices = rows.filter(({ kind }) => kind === 'choose');
  const chosen = await harness.play(choices);
  choices.forEach(({ settings }, i) => (settings.timeStep = chosen[i].timeStep));
  const inPage = await harness.play(rows, { whole: true });
  const natively = playNatively(body, rows, laws);
  rows.forEach((row, i) => {
    if (row.kind !== 'move') return;
    const { stepSeconds, ...frame } = inPage[i];
    assert.deepEqual(frame, frameOf(natively[i], row.tool), `row ${i}`);
  });
});
