// A browser, the server and a folder of result files, as the tests need them.
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { chromium } from 'playwright-core';

const top = resolve(import.meta.dirname, '../../..');
/** A view in which colours are numbers: a liver looks like one at first. */
export const inColours = 'colours=displacement&surface=exact';
/** Where CMake has built livermark and write_sample_result. */
const build = process.env.LIVERMARK_BUILD ?? join(top, 'build/release');
export const livermark = join(build, 'livermark');
export const builtTests = join(build, 'tests');
const browserProgram = process.env.CHROMIUM ?? '/usr/bin/chromium';

export const builtPage = join(top, 'app/viewer/dist/index.html');

const program = (path) => {
  if (existsSync(path)) return path;
  throw new Error(`${path} is not there: the tests of the page need all that cmake --build --preset release builds`);
};

/** A new folder with the result files that the tests of the writer use. */
export function sampleFolder() {
  const write = program(join(builtTests, 'write_sample_result'));
  const folder = mkdtempSync(join(tmpdir(), 'livermark_viewer_'));
  execFileSync(write, [folder]);
  return { folder, remove: () => rmSync(folder, { recursive: true }) };
}

/** A new folder with a result of a body that ships: <name>/palpation.h5. @param loadCase  another one, by its name or its file */
export function shippedFolder(name, loadCase = 'palpation') {
  const run = program(livermark);
  const folder = mkdtempSync(join(tmpdir(), 'livermark_shipped_'));
  execFileSync(run, ['run', '--static', '--reference-on-mesh', '--body', name, '--load-case', loadCase, '--model', 'lloyd', '--output', folder]);
  return { folder, remove: () => rmSync(folder, { recursive: true }) };
}

/** Starts `livermark view` on any free port. @return its address, with the token */
export async function startServer(folder, more = [], environment = {}) {
  const child = spawn(livermark, ['view', folder, '--port', '0', ...more], { env: { ...process.env, ...environment } });
  const ended = new Promise((done) => child.once('exit', done));
  let said = '';
  const address = await new Promise((found, failed) => {
    child.stdout.on('data', (text) => {
      said += text;
      const match = said.match(/http:\/\/127\.0\.0\.1:\d+\/\?token=[0-9a-f]+/);
      if (match) found(match[0]);
    });
    child.stderr.on('data', (text) => (said += text));
    child.once('exit', () => failed(new Error(`livermark view ended: ${said}`)));
  });
  /** As Ctrl-C does. @return the exit status */
  const stop = () => (child.kill('SIGINT'), ended);
  return { address, stop };
}

/** What a machine with other things to do may take for one thing [ms]: no test asks how fast it goes. */
const patience = 240_000;

/** Software rendering, because a machine that runs tests has no graphics card. */
export const startBrowser = () =>
  chromium.launch({
    timeout: patience,
    executablePath: browserProgram,
    args: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox'],
  });

/** A page of its own. @param options  of its context */
export async function newPage(browser, options = {}) {
  const page = await (await browser.newContext({ viewport: { width: 1200, height: 800 }, ...options })).newPage();
  page.setDefaultTimeout(patience);
  return page;
}

/** What follows # in the address, once that is the view that is shown. */
export async function fragment(page) {
  await frames(page); // a camera that was turned is seen in the next one
  await page.waitForSelector('body[data-address=shown]');
  return page.evaluate(() => location.hash);
}

const drawings = (page) => page.locator('#stage').getAttribute('data-drawn');

/** Does something that changes the picture, and waits until it has changed. */
export async function andDraw(page, action) {
  const before = await drawings(page);
  await action();
  await page.waitForFunction((count) => document.querySelector('#stage').dataset.drawn !== count, before ?? undefined);
  await frames(page);
}

/** Lets the page draw what it has been asked to. */
export const frames = (page) =>
  page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)))));

/** Colours of the screen. @return rows of [red, green, blue] of a part of the page, one behind the other */
export const pixels = async (page, clip) => pixelsOf(page, await page.screenshot({ clip }));

/** The same of a PNG, decoded by the page. @param lastRows how many from below; all if left out */
export const pixelsOf = (page, png, lastRows) =>
  page.evaluate(async ([data, lastRows]) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const rows = lastRows ?? image.height;
    const all = context.getImageData(0, image.height - rows, image.width, rows).data;
    return Array.from({ length: all.length / 4 }, (_, i) => [all[4 * i], all[4 * i + 1], all[4 * i + 2]]);
  }, [png.toString('base64'), lastRows]);

/** Each of some colours once, as 'red,green,blue'. */
export const distinct = (colours) => new Set(colours.map(String));

/** The number that a text of the page shows. */
export const shown = (text) => Number(text.replace('−', '-'));
