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

const usual = { width: 1200, height: 800 };

/** A page of its own. @param options  of its context */
export async function newPage(browser, options = {}) {
  const page = await (await browser.newContext({ viewport: usual, ...options })).newPage();
  page.setDefaultTimeout(patience);
  return page;
}

/** What each control of a file says, in the order of the page. Of a node that is marked, links know. */
const controlsOf = (page) =>
  page.evaluate(() => Array.from(document.querySelectorAll('main:not([hidden], #live) :is(input, select)'), ({ id, name, type, value, checked }) => ({ id, name, type, value, checked }))
    .filter(({ id, type }) => type !== 'file' && id !== 'node_number'));

/** Sets controls, marks nothing and looks from where the camera is at first. */
const setControls = (page, controls) =>
  page.evaluate((controls) => {
    for (const { id, name, type, value, checked } of controls) {
      const control = document.querySelector(id ? `#${id}` : `main:not([hidden], #live) [name="${name}"][value="${value}"]`);
      const isSwitch = type === 'checkbox' || type === 'radio';
      if (!control || (isSwitch ? control.checked === checked || (type === 'radio' && !checked) : control.value === value)) continue;
      if (isSwitch) control.checked = checked;
      else control.value = value;
      for (const event of ['input', 'change']) control.dispatchEvent(new Event(event, { bubbles: true }));
    }
    const canvas = document.querySelector('main:not([hidden], #live) canvas');
    for (const key of ['r', 'Escape']) canvas.dispatchEvent(new KeyboardEvent('keydown', { key }));
  }, controls);

/**
 * One page for the tests of a file. To load the page takes most of the time of a short test: so `open` takes the page of the test before back to
 * what a new one would show, by its controls or by a link, until it writes the same link as at first. A new page is for what has not been opened yet,
 * and for what only a new one can have.
 * @param address  of the server, with its token
 * @param isShown  selector that is there once the page shows what it was asked for
 */
export function createVisits(browser, address, isShown) {
  const known = new Map(); // what a new page wrote into its address, and its controls, for all that was asked for
  let page = null, context = '';

  async function canGoOn() {
    if (!page || page.isClosed() || !page.url().startsWith(new URL(address).origin)) return false;
    return page.evaluate(() => localStorage.length === 0 && [...document.querySelectorAll('.lost')].every((lost) => lost.hidden));
  }
  async function goBack({ link, controls }) {
    const isThere = async () => (await fragment(page)) === link && (await page.locator('#message').isHidden());
    await page.mouse.move(0, 0);
    await page.evaluate(() => (document.activeElement.blur(), scrollTo(0, 0)));
    if (await isThere()) return;
    if (page.url().split('#')[1]?.split('?')[0] === link.slice(1).split('?')[0] && (await page.locator('#message').isHidden())) {
      const before = await page.locator('main:not([hidden], #live) [data-drawn]').getAttribute('data-drawn');
      await setControls(page, controls);
      await page.waitForFunction((count) => document.querySelector('main:not([hidden], #live) [data-drawn]').dataset.drawn !== count, before);
      if (await isThere()) return;
    }
    await page.evaluate((link) => {
      delete document.querySelector('#stage').dataset.drawn;
      history.replaceState(null, '', link);
      dispatchEvent(new HashChangeEvent('hashchange'));
    }, link);
  }
  return {
    get page() {
      return page;
    },
    /** @param asked  what follows the address, from # on @param options  of a context: light, dark and the size of the window need no new one */
    async open(asked, { colorScheme = 'light', viewport = usual, ...options } = {}) {
      const first = known.get(asked);
      if (first && JSON.stringify(options) === context && (await canGoOn())) {
        await page.unrouteAll();
        await page.emulateMedia({ colorScheme });
        await page.setViewportSize(viewport);
        await goBack(first);
      } else {
        await page?.context().close();
        context = JSON.stringify(options);
        page = await newPage(browser, { colorScheme, viewport, ...options });
        await page.goto(address + asked);
      }
      await page.waitForSelector(isShown, { state: 'attached' });
      await frames(page);
      if (!first) known.set(asked, { link: await fragment(page), controls: await controlsOf(page) });
    },
  };
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
export async function pixelsOf(page, png, lastRows) {
  const text = await page.evaluate(async ([data, lastRows]) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const rows = lastRows ?? image.height;
    const { data: all } = context.getImageData(0, image.height - rows, image.width, rows);
    // As text: half a million numbers one by one take seconds.
    return new Promise((done) => {
      const reader = new FileReader();
      reader.onload = () => done(reader.result);
      reader.readAsDataURL(new Blob([all]));
    });
  }, [png.toString('base64'), lastRows]);
  const all = Buffer.from(text.slice(text.indexOf(',') + 1), 'base64');
  return Array.from({ length: all.length / 4 }, (_, i) => [all[4 * i], all[4 * i + 1], all[4 * i + 2]]);
}

/** Each of some colours once, as 'red,green,blue'. */
export const distinct = (colours) => new Set(colours.map(String));

/** The number that a text of the page shows. */
export const shown = (text) => Number(text.replace('−', '-'));
