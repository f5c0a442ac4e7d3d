// The page with the sample result open, as several test files need it.
import { execFileSync } from 'node:child_process';
import { join } from 'node:path';
import { frames, inColours, newPage, pixels, sampleFolder, startBrowser, startServer } from './browser.mjs';

const python = process.env.PYTHON ?? '/usr/bin/python3';

/** Starts server and browser; `open` makes a new page, which `page` then is, in exact colours where the fragment has no view. */
export async function startSamples() {
  const samples = sampleFolder();
  const server = await startServer(samples.folder);
  const browser = await startBrowser();
  const all = {
    page: null,
    folder: samples.folder,
    address: server.address,
    async open(options = {}, fragment = '#sample_result.h5') {
      await all.page?.context().close();
      all.page = await newPage(browser, options);
      await all.page.goto(server.address + (fragment.includes('?') || fragment === '' ? fragment : `${fragment}?${inColours}`));
      await all.page.waitForSelector('body[data-state=ready] #stage[data-drawn]');
      await frames(all.page);
    },
    h5py: (question, name = 'sample_result.h5') => JSON.parse(execFileSync(python, [join(import.meta.dirname, 'ask_h5py.py'), join(samples.folder, name)],
      { input: JSON.stringify(question), maxBuffer: 2 ** 27 }).toString().replaceAll('NaN', 'null')),
    /** A copy of a sample with changes. */
    variant: (from, to, changes) => execFileSync(python, [join(import.meta.dirname, 'change_h5py.py'), join(samples.folder, from), join(samples.folder, to)],
      { input: JSON.stringify(changes) }),
    /** What is seen of a side, below its name. @return rows of [red, green, blue] */
    async side(place = 0) {
      const { x, y, width, height } = await all.page.locator('#stage canvas').boundingBox();
      return pixels(all.page, { x: x + (place * width) / 2 + 4, y: y + 72, width: width / 2 - 8, height: height - 185 });
    },
    async stop() {
      await browser.close();
      await server.stop();
      samples.remove();
    },
  };
  return all;
}
