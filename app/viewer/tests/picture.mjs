// The picture of the live page in the README: node tests/picture.mjs OUT.png, with the page and build/release built.
import { join } from 'node:path';
import { newPage, shippedFolder, startBrowser, startServer } from './browser.mjs';

const [out] = process.argv.slice(2);
if (!out) {
  console.error('usage: node tests/picture.mjs OUT.png');
  process.exit(2);
}
const { folder, remove } = shippedFolder('liver_tumours');
const server = await startServer(folder);
const browser = await startBrowser();
try {
  const page = await newPage(browser, { viewport: { width: 1280, height: 800 }, deviceScaleFactor: 1.25 });
  await page.goto(`${server.address}#${encodeURIComponent(join('liver_tumours', 'palpation.h5'))}`);
  await page.waitForSelector('#stage[data-drawn]');
  await page.check('#mode [value=live]', { force: true });
  await page.waitForSelector('#live[data-state=moving]');
  // Whole seconds of motion take minutes where the page draws in software, and the server moves the same springs.
  await page.selectOption('#live-engine', 'native');
  await page.waitForSelector('#live[data-state=moving]');
  await page.check('#live-translucent', { force: true });
  await page.check('#live-fem');
  await page.check('#live-stays');
  await page.click('#live-view');
  const { x, y, width, height } = await page.locator('#live-stage canvas').boundingBox();
  await page.mouse.click(x + 0.27 * width, y + 0.58 * height);
  await page.locator('#live-depth').fill('10');
  await page.locator('#live-stage canvas').focus();
  for (let i = 0; i < 2; i++) await page.keyboard.press('ArrowLeft');
  for (let i = 0; i < 2; i++) await page.keyboard.press('ArrowDown');
  await page.waitForFunction(() => document.querySelector('#live-fem-readings').dataset.judged === 'true' && Number(document.querySelector('#live-indentation').dataset.value) > 0.005);
  await page.screenshot({ path: out });
} finally {
  await browser.close();
  await server.stop();
  remove();
}
