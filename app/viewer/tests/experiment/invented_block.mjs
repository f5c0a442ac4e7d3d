// A block between two plates with invented measurements, as `livermark experiment` compares models with it; and the page that shows it.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createVisits, frames, livermark, startBrowser, startServer } from '../browser.mjs';

const python = process.env.PYTHON ?? '/usr/bin/python3';
const script = (name) => join(import.meta.dirname, '..', name);

const held = (patch) => `[[state.condition]]\npatch = "${patch}"\ndisplacement = [0.0, 0.0, 0.0]\n`;
const state = (name) => `[[state]]\nname = "${name}"\n${held('z_min')}${held('z_max')}`;
const toml = `title = "A jelly between two plates"
source = "our kitchen"
assumptions = ["it is a jelly"]
markers = "jelly.csv"
unit = "mm"
noise = 0.0002
fit_degree = 1
[body]
box = { size = [0.04, 0.04, 0.04], edge_length = 0.02, corner = [-0.02, -0.02, 0.0] }
[material]
density = 1000.0
young_modulus = 5000.0
poisson_ratio = 0.45
source = "a guess"
${state('little')}${state('much')}`;

/** At rest [mm], the place that it drives, and how far it is off a smooth motion [mm]. */
const corners = [[-15, -15], [15, -15], [15, 15], [-15, 15]];
const markers = [
  ...corners.map(([x, y], i) => [`top ${i + 1}`, 'z_max', [x, y, 40], [0, 0, 0]]),
  ...corners.map(([x, y], i) => [`bottom ${i + 1}`, 'z_min', [x, y, 0], [0, 0, 0]]),
  ['front', '', [0, -20, 20], [0.3, 0, 0.2]],
  ['right', '', [20, 0, 25], [0, 0.2, 0]],
  ['middle', '', [0, 0, 20], [0, 0, -0.4]],
  ['lost', '', [-20, 0, 30], [0, 0, 0.1]],
  ['back', '', [5, 20, 10], [0.1, 0, 0]],
];
export const names = markers.map(([name]) => name);

/** Squeezed by a part of its height; the marker 'lost' was not seen in the second state. */
function measured([x, y, z], off, part) {
  const wider = 1 + 0.4 * part * (4 * (z / 40) * (1 - z / 40));
  return [x * wider + off[0], y * wider + off[1], z * (1 - part) + off[2]];
}
const line = ([name, drives, place, off]) =>
  [name, drives, ...place, ...measured(place, off, 0.05), ...(name === 'lost' ? ['', '', ''] : measured(place, off, 0.15))].join(',');
const csv = ['marker,drives,x,y,z,little_x,little_y,little_z,much_x,much_y,much_z', ...markers.map(line)].join('\n');

/** A folder with jelly.h5, and what else the caller makes in it before the server starts. @param prepare  called with the folder */
export async function startBlock(prepare = () => {}) {
  const folder = mkdtempSync(join(tmpdir(), 'livermark_experiment_'));
  writeFileSync(join(folder, 'jelly.toml'), toml);
  writeFileSync(join(folder, 'jelly.csv'), csv);
  execFileSync(livermark, ['experiment', join(folder, 'jelly.toml'), '--model', 'lloyd', 'fem_p1', '--output', folder]);
  const change = (from, to, changes) => execFileSync(python, [script('change_h5py.py'), join(folder, from), join(folder, to)], { input: JSON.stringify(changes) });
  prepare(folder, change);
  const server = await startServer(folder);
  const browser = await startBrowser();
  const visits = createVisits(browser, server.address, 'body[data-state=ready]');
  const all = {
    get page() {
      return visits.page;
    },
    folder,
    open: (options = {}, fragment = '#jelly.h5') => visits.open(fragment, options),
    async settled() {
      await all.page.waitForSelector('body[data-state=ready]');
      await frames(all.page);
    },
    h5py: (question, name = 'jelly.h5') => JSON.parse(execFileSync(python, [script('ask_h5py.py'), join(folder, name)], { input: JSON.stringify(question) }).toString().replaceAll('NaN', 'null')),
    /** Where the picture has the hue of an entry of the legend, whose lightness depends on the light: places from the corner of the canvas [CSS pixels]. */
    async placesOf(colour) {
      const { x, y, width, height } = await all.page.locator('#experiment-stage canvas').boundingBox();
      const [above, below] = [72, 120]; // the name of the model; axes and scale
      const png = await all.page.screenshot({ clip: { x, y: y + above, width, height: height - above - below } });
      return all.page.evaluate(async ([data, name, top]) => {
        const length = (vector) => Math.hypot(...vector);
        const direction = (vector) => vector.map((value) => value / length(vector));
        const wanted = direction(getComputedStyle(document.querySelector(`#experiment-legend [data-colour=${name}]`)).backgroundColor.match(/\d+/g).map(Number));
        const image = new Image();
        image.src = `data:image/png;base64,${data}`;
        await image.decode();
        const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
        context.drawImage(image, 0, 0);
        const { data: values } = context.getImageData(0, 0, image.width, image.height);
        const places = [];
        for (let i = 0; i < image.width * image.height; i++) {
          const pixel = [...values.subarray(4 * i, 4 * i + 3)];
          const isColoured = Math.max(...pixel) - Math.min(...pixel) > 40;
          if (isColoured && length(direction(pixel).map((value, k) => value - wanted[k])) < 0.12) places.push([i % image.width, top + Math.floor(i / image.width)]);
        }
        return places;
      }, [png.toString('base64'), colour, above]);
    },
    async stop() {
      await browser.close();
      await server.stop();
      rmSync(folder, { recursive: true });
    },
  };
  return all;
}
