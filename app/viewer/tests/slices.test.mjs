// Slices of the label image that a body was made of: the image of the server, and contours of the mesh over its voxels.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { appendFileSync, existsSync, mkdtempSync, readFileSync, renameSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { fragment, livermark, newPage, startBrowser, startServer } from './browser.mjs';

const skip = !existsSync(join(dirname(livermark), 'livermark-segment')) && 'bodies of images need livermark-segment';
const place = '/seg/palpation.h5';
let folder, image, server, browser, page;
before(async () => {
  if (skip) return;
  folder = mkdtempSync(join(tmpdir(), 'livermark_slices_'));
  image = join(folder, 'seg, turned.nrrd');
  const run = (...words) => execFileSync(livermark, words, { cwd: folder, stdio: ['ignore', 'ignore', 'pipe'] });
  // Voxels of three lengths, along axes that are far from the patient's. One label is nothing of the liver's.
  run('mesh', '--phantom', '--spacing', '0.003', '0.002', '0.004', '--turn', '0.4', '0.3', '-0.5', '-o', image);
  run('mesh', '--labels', image, '--tumours', '2', '3', '--role', '4=cyst', '--role', '5=ignore', '--tetrahedra', '4000', '-o', 'seg.msh');
  run('run', '--body', 'seg.toml', '--static', '--load-case', 'palpation', '--model', 'lloyd', '--reference-on-mesh', '--output', '.');
  server = await startServer(folder);
  browser = await startBrowser();
  page = await newPage(browser, { viewport: { width: 900, height: 600 } });
  await page.goto(`${server.address}#seg%2Fpalpation.h5?surface=exact&times=0`);
  await page.waitForSelector('#stage[data-drawn]');
});
after(async () => {
  await browser?.close();
  await server?.stop();
  if (folder) rmSync(folder, { recursive: true });
});

const ask = (path, token = new URL(server.address).search) => fetch(new URL(path + token, server.address));
const places = async () => (await fragment(page)).match(/slices=([-\d.,]+)/)[1].split(',').map(Number);
const slice = (name) => page.getByRole('img', { name: `${name} slice` });
/** Draws slices again by what is done. */
async function andSlice(action) {
  const before = await page.locator('#slices').getAttribute('data-drawn');
  await action();
  await page.waitForFunction((count) => document.querySelector('#slices').dataset.drawn !== count, before ?? undefined);
}

test('the server has the voxels around the body, by the choice of labels that it was made with', { skip }, async () => {
  assert.equal((await ask(`/image${place}`, '')).status, 403);
  assert.equal((await ask('/image/seg/none.h5')).status, 404);
  const { size, steps, parts, runs } = await (await ask(`/image${place}`)).json();
  assert.deepEqual(steps.map((step) => Number(Math.hypot(...step).toFixed(9))), [0.003, 0.002, 0.004]);
  const count = Object.fromEntries(parts.map((part) => [part, 0]));
  for (let i = 0; i < runs.length; i += 2) count[parts[runs[i]]] += runs[i + 1];
  assert.equal(Object.values(count).reduce((a, b) => a + b), size[0] * size[1] * size[2]);
  const litres = (number) => 1000 * 0.003 * 0.002 * 0.004 * number;
  const toml = readFileSync(join(folder, 'seg.toml'), 'utf8'), volume = (name) => 1000 * Number(toml.match(new RegExp(`^${name} = ([\\d.e-]+)$`, 'm'))[1]);
  const lesions = ['tumour_1', 'tumour_2', 'cyst_1'].reduce((sum, name) => sum + volume(name), 0);
  assert.ok(Math.abs(litres(count.lesion) - lesions) < 1e-4 * lesions, 'tumours and cysts are lesions');
  assert.ok(count.other > 0 && Math.abs(litres(count.liver + count.other) - volume('parenchyma')) < 1e-3 * volume('parenchyma'));
});

test('contours at rest fit the voxels, and sides of the patient are where they are said to be', { skip }, async () => {
  assert.doesNotMatch(await fragment(page), /slices=/);
  await andSlice(() => page.locator('#slices summary').click());
  for (const name of ['Axial', 'Coronal', 'Sagittal']) {
    // In each row the outermost pixels of the liver and of the contour, which at rest is drawn three times. Some rows have a corner alone.
    const apart = await slice(name).evaluate((canvas) => {
      const { data, width, height } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      const isBody = (at) => [152, 62, 46].every((x, i) => Math.abs(x - data[at + i]) < 24), isLine = (at) => data[at] > 190 && data[at + 1] > 150 && data[at + 2] < 150;
      const found = [];
      for (let y = 0; y < height; y++) {
        const columns = (is) => Array.from({ length: width }, (_, x) => x).filter((x) => is(4 * (y * width + x)));
        const [body, line] = [columns(isBody), columns(isLine)];
        if (body.length > 0 && line.length > 0) found.push(Math.abs(body[0] - line[0]), Math.abs(body.at(-1) - line.at(-1)));
      }
      return { rows: found.length / 2, median: found.sort((a, b) => a - b)[Math.floor(found.length / 2)] };
    });
    // The line has 3 pixels with what is around it, and a voxel 2 to 4.
    assert.ok(apart.rows > 40 && apart.median <= 5, `${name}: ${JSON.stringify(apart)}`);
  }
  // A click moves the place to where one clicks: x goes to the left, y to the back, z to the head.
  for (const [name, ...axes] of [['Axial', 0, 1], ['Coronal', 0, 2], ['Sagittal', 1, 2]]) {
    const at = async (part) => {
      await andSlice(() => slice(name).evaluate((canvas, part) => {
        const { left, top, width, height } = canvas.getBoundingClientRect();
        canvas.dispatchEvent(new MouseEvent('click', { clientX: left + part * width, clientY: top + part * height }));
      }, part));
      return places();
    };
    const [first, second] = [await at(0.4), await at(0.6)];
    for (const axis of axes) assert.ok((axis === 2 ? -1 : 1) * (second[axis] - first[axis]) > 10, `${name} ${axis}: ${first}, ${second}`);
  }
});

test('the deformed mesh follows the scale, and a link keeps what is unfolded', { skip }, async () => {
  const seen = () => slice('Axial').evaluate((canvas) => canvas.toDataURL());
  await page.getByRole('slider', { name: 'Axial slice' }).fill('20');
  const atRest = await seen();
  await andSlice(() => page.locator('#exaggeration').fill('17'));
  const deformed = await seen();
  assert.notEqual(deformed, atRest);
  assert.match(await page.locator('#slices-about').textContent(), /drawn 60 times as large.*turned by \d\d°/);
  assert.deepEqual(await page.locator('#slices-legend li').allTextContents(), ['mesh at rest', 'fem_p2p1', 'lloyd', 'liver', 'lesion', 'other labels']);
  const saving = page.waitForEvent('download');
  await page.click('#slices-save');
  assert.equal(readFileSync(await (await saving).path()).subarray(1, 4).toString(), 'PNG');
  await fragment(page);
  await page.reload();
  await page.waitForSelector('#slices[data-drawn]');
  assert.equal(await seen(), deformed);
});

test('without the image the page says why', { skip }, async () => {
  const again = async (expected) => {
    await page.evaluate(() => dispatchEvent(new HashChangeEvent('hashchange')));
    await page.locator('#slices-note', { hasText: expected }).waitFor();
    assert.ok(await page.locator('#slices-shown').isHidden());
  };
  appendFileSync(image, '\0');
  await again('this label image has changed since the body was made of it; put the old one back');
  renameSync(image, `${image}.old`);
  await again('the label image of this body is not there any more; put it back');
  rmSync(join(folder, 'seg.toml'));
  await again('this file is not there, which says what image the body was made of');
  await page.locator('#chosen').setInputFiles(join(folder, 'seg/palpation.h5'));
  await page.locator('#slices:not([open])').waitFor();
  await page.locator('#slices summary').click();
  await page.locator('#slices-note', { hasText: 'The image is not in this file. Start livermark view where the image is' }).waitFor();
});
