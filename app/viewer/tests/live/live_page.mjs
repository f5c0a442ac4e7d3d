// The live page in a browser, as tests handle it. Machines that run tests are slow and draw in software, so nothing here asks how
// fast it goes.
import { readFileSync } from 'node:fs';
import { basename } from 'node:path';
import { frames, newPage, shippedFolder, startBrowser, startServer } from '../browser.mjs';

/** A server with a result of a liver, a browser, and the live page of that file; stop() ends all. @param loadCase  of shippedFolder() */
export async function startLivePage(body = 'liver_tumours', loadCase = 'palpation') {
  const site = { shipped: shippedFolder(body, loadCase) };
  site.stop = async () => {
    await site.browser?.close();
    await site.server?.stop();
    site.shipped.remove();
  };
  try {
    site.server = await startServer(site.shipped.folder);
    site.browser = await startBrowser();
  } catch (error) {
    await site.stop();
    throw error;
  }
  site.live = createLivePage(site.browser, `${site.server.address}#${encodeURIComponent(`${body}/${basename(loadCase, '.toml')}.h5`)}`);
  return site;
}

/** @param browser  of startBrowser() @param address  of the page with its file */
export function createLivePage(browser, address) {
  let page = null;
  let firstNode = ''; // that the page offers to touch
  const linkTo = (law) => `${address}?mode=live&law=${law}&live_colours=displacement&live_surface=exact`;
  const at = {
    get page() {
      return page;
    },
    /** A new page of any address. */
    async visit(other, options = {}) {
      await page?.context().close();
      page = await newPage(browser, { viewport: { width: 1200, height: 850 }, ...options });
      await page.goto(other);
    },
    async open(options = {}, other = address) {
      await at.visit(other, options);
      await page.waitForSelector('#stage[data-drawn]', { state: 'attached' }); // a link may lead to Live
    },
    moving: () => page.waitForSelector('#live[data-state=moving]'),
    /**
     * The body at rest in colours that can be measured, on a new page if there are options for one. It is opened by a link, because springs of the law
     * that a page begins with take seconds to be fitted. @param law  a quicker one
     */
    async goLive(options, law = 'van_gelder') {
      if (!options && (await at.goBack())) return;
      await at.open(options, linkTo(law));
      await at.moving();
      firstNode = await page.locator('#live-node').inputValue();
    },
    /** The same body from the beginning, with nothing done to it: its file is opened again in the page of the test before, or in a new one. */
    async goAnew(law = 'van_gelder') {
      if (!(await page?.locator('#live[data-state=moving]').isVisible())) return at.goLive({}, law);
      await page.check('[name=tool][value=probe]');
      for (const id of ['#live-fem', '#live-stays']) await page.uncheck(id);
      await page.evaluate((link) => {
        document.querySelector('#live').dataset.state = 'before';
        document.querySelector('#live-needle-capsule').checked = false;
        document.querySelector('#live-engine').value = 'wasm'; // as of the next start
        history.replaceState(null, '', link);
        dispatchEvent(new HashChangeEvent('hashchange'));
      }, new URL(linkTo(law)).hash);
      await at.moving();
    },
    /** What the page of the test before has become is as at first again. @return whether it can go on */
    async goBack() {
      if (!(await page?.locator('#live[data-state=moving]').isVisible())) return false;
      if ((await page.locator('#live-pause').textContent()).includes('Go on')) await page.click('#live-pause');
      for (const one of ['[name=live-shown][value=displacement]', '#live-legend-follows', '[name=live-skin][value=flat]', '[name=tool][value=probe]'])
        await page.check(one);
      for (const id of ['#live-fem', '#live-stays']) await page.uncheck(id);
      // The depth below is that of the next tool, not of one that still holds on.
      if (await page.locator('#live-let-go').isEnabled()) await page.click('#live-let-go');
      await page.locator('#live-depth').fill('5');
      await page.locator('#live-node').fill(firstNode);
      for (const [name, text] of [['nu', '0.45'], ['alpha', '10'], ['step-length', '0']])
        if ((await page.locator(`#live-${name}`).inputValue()) !== text) await at.set(name, text);
      await page.click('#live-reset');
      await page.click('#live-view');
      await at.rests();
      return true;
    },
    value: async (name) => Number(await page.locator(`#live-${name}`).getAttribute('data-value')),
    text: (name) => page.locator(`#live-${name}`).textContent(),
    isShown: (name) => page.locator(`#live-${name}`).isVisible(),
    above: (name, least) =>
      page.waitForFunction(([id, least]) => Number(document.querySelector(id).dataset.value) > least, [`#live-${name}`, least]),
    below: (name, most) =>
      page.waitForFunction(([id, most]) => Number(document.querySelector(id).dataset.value) < most, [`#live-${name}`, most]),
    /** Nothing moves, and nothing is asked of the engine: every number that is read from here on is that of the rest. */
    rests: () => page.waitForSelector('#live[data-at-rest=true]'),
    /** The same, and FEM has said all that it says to the forces of that rest. */
    async isJudged() {
      await at.rests();
      await page.waitForSelector('#live-fem-readings[data-judged=true]');
    },
    /** Who moves the springs: wasm or native. */
    async take(engine) {
      await page.selectOption('#live-engine', engine);
      await at.moving();
    },
    /** Changes a setting, and waits until the springs have it. */
    async set(name, text) {
      const field = page.locator(`#live-${name}`);
      await page.locator('#live').evaluate((live) => (live.dataset.state = 'choosing'));
      if (name === 'law') await field.selectOption(text);
      else await field.fill(text).then(() => field.press('Tab'));
      await page.waitForFunction(() => document.querySelector('#live').dataset.state !== 'choosing');
    },
    /** A place on the screen: the middle of the right lobe of the springs, which have half of a wide picture beside FEM. */
    async place() {
      const canvas = page.locator('#live-stage canvas');
      await canvas.scrollIntoViewIfNeeded();
      const box = await canvas.boundingBox();
      const isHalved = (await at.isShown('names')) && box.width >= box.height;
      const [width, height] = [isHalved ? box.width / 2 : box.width, box.height];
      return [box.x + width / 2 - 0.15 * Math.min(width, height), box.y + 0.55 * height];
    },
    /** Another one, in the view that the page begins with: the edge of the left lobe. */
    async edge() {
      const canvas = page.locator('#live-stage canvas');
      await canvas.scrollIntoViewIfNeeded();
      const { x, y, width, height } = await canvas.boundingBox();
      return [x + width / 2 + 0.29 * Math.min(width, height), y + 0.38 * height];
    },
    async press() {
      await page.mouse.move(...(await at.place()));
      await page.mouse.down();
    },
    /** Touches it with a tool that stays there. */
    async poke() {
      await page.check('#live-stays');
      await at.press();
      await page.mouse.up();
      await at.above('indentation', 0.001);
    },
    /** The last answer is there. */
    sleeps: () => page.waitForSelector('#live[data-asleep=true]'),
    async pause() {
      await page.click('#live-pause');
      await at.sleeps();
      await frames(page); // a picture that was asked for before is drawn by now
    },
    /** Pauses. @return what was done, as rows of the file that is saved */
    async saved() {
      await at.pause();
      const [download] = await Promise.all([page.waitForEvent('download'), page.click('#live-save')]);
      const [head, ...lines] = readFileSync(await download.path(), 'utf8').trimEnd().split('\n').map((line) => line.split(','));
      return { head, rows: lines.map((line) => Object.fromEntries(line.map((text, i) => [head[i], text]))) };
    },
    close: () => page?.context().close(),
  };
  return at;
}
