// The page with the sample result open, as several test files need it.
import { execFileSync } from 'node:child_process';
import { join } from 'node:path';
import { createVisits, inColours, pixels, sampleFolder, startBrowser, startServer } from './browser.mjs';

const python = process.env.PYTHON ?? '/usr/bin/python3';

/** Starts server and browser; after `open`, `page` shows what a new page would, in exact colours where the fragment has no view. */
export async function startSamples() {
  const samples = sampleFolder();
  const server = await startServer(samples.folder);
  const browser = await startBrowser();
  const visits = createVisits(browser, server.address, 'body[data-state=ready] #stage[data-drawn]');
  const all = {
    get page() {
      return visits.page;
    },
    folder: samples.folder,
    address: server.address,
    open: (options = {}, fragment = '#sample_result.h5') => visits.open(fragment.includes('?') || fragment === '' ? fragment : `${fragment}?${inColours}`, options),
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
