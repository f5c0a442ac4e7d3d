// The live page of a body under a finger, and what `livermark run` says of the same touch.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import * as hdf5 from 'h5wasm/node';
import { livermark } from '../browser.mjs';
import { startLivePage } from './live_page.mjs';

const margin = 0.1; // of the force at the same depth: the direction of a load case is the mean normal of a disc, that of the page the normal of a node
const radius = 0.012; // of a finger [m]

/** What `livermark run` says to a ball that is set down there and goes as deep. @return its force [N] */
function forceOfRun(body, model, { point, depth }) {
  const folder = mkdtempSync(join(tmpdir(), 'livermark_live_'));
  const numbers = (vector) => `[${vector.map((x) => x.toExponential(16)).join(', ')}]`;
  const lines = [
    'title = "What the live page did"', 'regime = "large"', 'path = [0.5, 1.0]', 'target_peak_displacement = 0.01',
    '[[condition]]', 'patch = "posterior"', 'displacement = [0.0, 0.0, 0.0]',
    '[touch]', `disc = { point = ${numbers(point)}, radius = ${radius} }`, `radius = ${radius}`, `depth = ${depth.toExponential(16)}`, 'friction = 0.3', ''];
  try {
    writeFileSync(join(folder, 'live.toml'), lines.join('\n'));
    execFileSync(livermark, ['run', '--static', '--reference-on-mesh', '--body', body, '--load-case', join(folder, 'live.toml'), '--model', model, '--output', folder], { stdio: 'ignore' });
    const file = new hdf5.File(join(folder, body, 'live.h5'), 'r');
    const reactions = file.get(`solutions/${model}/reaction`).to_array();
    file.close();
    return Math.hypot(...reactions.at(-1));
  } finally {
    rmSync(folder, { recursive: true });
  }
}

/** The live page of a body that ships, as startLivePage() has it, and what is asked of it. */
export async function startTouch(body) {
  await hdf5.ready;
  const site = await startLivePage(body);
  const { live } = site;

  /** Opens Live. Seconds of motion take long where the page does all by itself, and the server moves the same springs. */
  async function movedByServer() {
    await live.open();
    const { page } = live;
    await page.locator('#live-engine').evaluate((engine) => (engine.value = 'native')); // before the page fits springs of its own
    await page.check('#mode [value=live]', { force: true });
    await live.moving();
    return page;
  }

  async function agreesWithRun(t) {
    const page = await movedByServer();
    const model = await page.locator('#live-law').inputValue();
    assert.equal(await live.value('radius-shown'), radius, 'a finger at first');
    await live.set('alpha', '40');
    await page.check('#live-stays');
    await page.click('#live-touch');
    await live.above('indentation', 0.002);
    await live.rests();
    const force = await live.value('force');
    assert.equal(await live.value('disc'), radius);
    const centre = (await page.locator('#live-disc').getAttribute('data-middle')).split(',').map(Number);
    const { rows } = await live.saved();
    // The ball is led from where it just touches to 5 mm below, straight inwards.
    const targets = rows.filter(({ tool }) => tool === 'probe').map((row) => ['target_x', 'target_y', 'target_z'].map((name) => Number(row[name])));
    const way = targets.at(-1).map((x, i) => x - targets[0][i]);
    const inwards = way.map((x) => x / Math.hypot(...way));
    const start = targets.at(-1).map((x, i) => x - 0.005 * inwards[i]);
    const depth = centre.reduce((sum, x, i) => sum + (x - start[i]) * inwards[i], 0);
    const expected = forceOfRun(body, model, { point: start.map((x, i) => x + radius * inwards[i]), depth });
    t.diagnostic(`${model}: ${(1000 * depth).toFixed(2)} mm, in Live ${force.toFixed(4)} N, in livermark run ${expected.toFixed(4)} N`);
    assert.ok(Math.abs(force / expected - 1) < margin, `${force} N, and ${expected} N in livermark run`);
  }

  return { ...site, movedByServer, agreesWithRun };
}
