// A body that nobody touches comes to rest, and the live page then does nothing; and it goes back to before the last tool.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startLivePage } from './live_page.mjs';

let site, live;

before(async () => {
  site = await startLivePage();
  ({ live } = site);
});
after(() => site?.stop());

/** Steps, pictures and frames of the screen that are asked for in a second, or until a slow machine has drawn. */
const workInASecond = ({ untilDrawn = false } = {}) =>
  live.page.evaluate(async (untilDrawn) => {
    const asked = { messages: 0, frames: 0, drawings: 0 };
    const restore = [];
    const count = (object, name, what) => {
      const own = object[name];
      object[name] = function (...rest) {
        asked[what]++;
        return own.apply(this, rest);
      };
      restore.push(() => (object[name] = own));
    };
    count(Worker.prototype, 'postMessage', 'messages');
    count(window, 'requestAnimationFrame', 'frames');
    count(WebGL2RenderingContext.prototype, 'drawElements', 'drawings');
    const second = () => new Promise((done) => setTimeout(done, 1000));
    await second();
    for (let i = 0; i < 120 && untilDrawn && asked.drawings === 0; i++) await second();
    restore.forEach((put) => put());
    return asked;
  }, untilDrawn);
const nothing = { messages: 0, frames: 0, drawings: 0 };

test('a body at rest is neither stepped nor drawn, and every input wakes it', async () => {
  await live.goLive();
  await live.rests();
  assert.equal(await live.isShown('rest'), true);
  assert.deepEqual(await workInASecond(), nothing);
  // The camera: it is drawn, and still not stepped.
  const time = await live.value('time');
  await live.page.locator('#live-stage canvas').focus();
  const turned = workInASecond({ untilDrawn: true });
  await live.page.keyboard.press('ArrowLeft');
  const { messages, drawings } = await turned;
  assert.equal(messages, 0);
  assert.ok(drawings > 0);
  assert.equal(await live.value('time'), time);
  // A tool.
  await live.page.keyboard.press('Enter');
  await live.page.waitForFunction(() => Number(document.querySelector('#live-indentation').dataset.value) > 0.001 && document.querySelector('#live-rest').hidden);
  await live.page.keyboard.press('Escape');
  await live.below('force', 1e-12);
  await live.rests();
  assert.deepEqual(await workInASecond(), nothing);
  // A setting.
  const before = await live.value('time');
  await live.set('nu', '0.3');
  await live.above('time', before);
});

test('while it pauses it does nothing', async () => {
  await live.goLive();
  await live.poke();
  await live.pause();
  assert.deepEqual(await workInASecond(), nothing);
  const time = await live.value('time');
  await live.page.click('#live-step-once');
  await live.above('time', time);
  assert.equal(await live.value('steps'), 1);
});

test('a tool that keeps still lets the body come to rest as well, and FEM has then answered the forces of that rest', async () => {
  await live.goLive();
  await live.set('alpha', '60');
  await live.page.check('#live-fem');
  await live.poke();
  await live.isJudged();
  assert.ok((await live.value('force')) > 0.01);
  assert.equal(await live.value('fem-springs'), await live.value('indentation'));
  assert.deepEqual(await workInASecond(), nothing);
});

test('the first steps of a body are few, and become more only as they prove to be quick', async () => {
  await live.goLive({}, 'lloyd');
  await live.poke();
  const { rows } = await live.saved();
  let most = 0;
  for (const row of rows) {
    if (row.kind === 'choose') most = 0;
    if (row.kind !== 'move' || row.num_steps === '0') continue;
    assert.ok(Number(row.num_steps) <= Math.max(1, 4 * most), `${row.num_steps} steps after at most ${most}`);
    most = Math.max(most, Number(row.num_steps));
  }
  assert.ok(most > 1);
});

test('a motion that is slower than life says so where the force is read', async () => {
  await live.goLive();
  // More steps than any machine takes in a frame.
  await live.set('step-length', '0.0005');
  await live.page.check('#live-stays');
  await live.press();
  await live.page.mouse.up();
  await live.page.waitForSelector('#live-pace:not([hidden])');
  assert.match(await live.text('pace'), /^Slower than real time: 1 s of motion takes [\d.]+ s, because (steps of 0\.000500 ms are \d+ times the steps that are needed|drawing takes the time)\.$/);
  assert.ok((await live.value('pace')) < 0.9);
  assert.ok((await live.value('pace-now')) < 0.9);
  // So slow because a frame of motion takes longer than one of the screen.
  assert.ok((await live.value('work')) > 1 / 60);
  assert.match(await live.text('work'), /^[\d.]+ of 16\.7 ms$/);
  const [force, pace] = await Promise.all(['#live-force', '#live-pace'].map((id) => live.page.locator(id).boundingBox()));
  assert.ok(pace.y - (force.y + force.height) < 40, 'below the force');
  // One click takes the longest steps, and the step is the same fact wherever it stands.
  await live.page.waitForSelector('#live-longest-steps:not([hidden])');
  assert.equal(await live.isShown('opaque'), false, 'nothing is of glass');
  await live.page.click('#live-longest-steps');
  await live.page.waitForFunction(() => document.querySelector('#live-step').dataset.value === document.querySelector('#live-longest').dataset.value);
  assert.equal(await live.page.locator('#live-step-length').inputValue(), '0');
  const [step, critical] = [await live.value('step'), await live.value('critical')];
  const said = await live.text('limit');
  assert.match(said, /^A step of ([\d.]+) ms is [\d.]+ of the critical one at rest, [\d.]+ ms: a pressed body decides, which bears [\d.]+ ms: while something is pressed a step goes in 3 parts\.$/);
  const [taken, part, atRest, pressed] = said.match(/\d[\d.]*/g).map(Number);
  const near = (a, b) => assert.ok(Math.abs(a / b - 1) < 0.006, `${a}, ${b}`);
  near(taken, 1000 * step);
  near(part, step / critical);
  near(atRest, 1000 * critical);
  near(3 * pressed, taken);
  const [short, longest] = (await live.saved()).rows.filter((row) => row.kind === 'choose').slice(-2);
  assert.deepEqual([longest.time_step, longest.longest_time_step, longest.critical_time_step].map(Number), [step, step, critical]);
  assert.equal(longest.step_limit, 'pressed');
  assert.equal(Number(short.time_step), 5e-7);
  assert.ok(Number(short.critical_time_step) < 0.8 * critical, 'of masses as they are');
  assert.equal(short.longest_time_step, longest.longest_time_step);
});

test('the last tool is undone: the body and the tool before it are as they were', async () => {
  await live.goLive();
  assert.equal(await live.page.isDisabled('#live-undo'), true);
  await live.poke();
  const { page } = live;
  await page.check('[name=tool][value=pull]');
  // Letting go of the poke for another tool is no tool.
  await live.below('force', 1e-12);
  await page.uncheck('#live-stays');
  await live.rests();
  const [x, y] = await live.place();
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x - 30, y - 60, { steps: 4 });
  await live.above('indentation', 0.003);
  await page.mouse.up();
  await page.click('#live-undo');
  await live.below('indentation', 1e-12);
  assert.equal(await page.isDisabled('#live-undo'), true);
  const { rows } = await live.saved();
  const kept = rows.findLastIndex((row) => row.kind === 'keep'), undone = rows.findLastIndex((row) => row.kind === 'undo');
  assert.ok(kept > 0 && undone > kept);
  const [was, is] = [rows[kept - 1], rows[undone + 1]];
  assert.equal(is.num_steps, '0');
  assert.equal(is.smallest_volume, was.smallest_volume);
  assert.notEqual(rows[undone - 1].smallest_volume, was.smallest_volume);
});

test('a tool that stayed is there again when the one after it is undone', async () => {
  await live.goLive();
  await live.poke();
  const { page } = live;
  await live.pause();
  const [force, indentation] = [await live.value('force'), await live.value('indentation')];
  const node = await page.locator('#live-node').inputValue();
  const [x, y] = await live.place();
  await page.mouse.click(x + 60, y - 20);
  await page.click('#live-pause');
  await page.waitForFunction((force) => Math.abs(Number(document.querySelector('#live-force').dataset.value) - force) > 0.05 * force, force);
  await live.pause();
  await page.locator('#live-stage canvas').focus();
  await page.keyboard.press('Control+z');
  await page.waitForFunction((force) => Number(document.querySelector('#live-force').dataset.value) === force, force);
  assert.equal(await live.value('indentation'), indentation);
  assert.equal(await page.locator('#live-node').inputValue(), node);
});
