// Random actions on the live page, as of somebody who tries everything: the same ones for the same seed.
import { frames } from '../browser.mjs';

/** Numbers in [0, 1) by a linear congruence (Knuth's MMIX). */
function createDice(seed) {
  let state = BigInt(seed);
  const roll = () => Number((state = (state * 6364136223846793005n + 1442695040888963407n) % (1n << 64n)) >> 32n) / 2 ** 32;
  return { roll, below: (count) => Math.floor(roll() * count), between: (low, high) => low + (high - low) * roll(), of: (all) => all[Math.floor(roll() * all.length)] };
}

/**
 * @param live  of createLivePage(), whose body moves
 * @param check  told each action by its name, after it
 * @return how often each was done
 */
export async function actAtRandom(live, numActions, seed, check) {
  const { page } = live;
  const dice = createDice(seed);
  const canvas = page.locator('#live-stage canvas');
  const place = async () => {
    await canvas.scrollIntoViewIfNeeded();
    const box = await canvas.boundingBox();
    return [box.x + dice.between(0.15, 0.85) * box.width, box.y + dice.between(0.15, 0.85) * box.height];
  };
  const choose = (selector) => page.evaluate(([selector, part]) => {
    const all = [...document.querySelectorAll(selector)].filter((input) => !input.disabled && input.offsetParent !== null);
    const one = all[Math.floor(part * all.length)];
    if (!one) return;
    if (one.tagName === 'OPTION') {
      one.parentElement.value = one.value;
      one.parentElement.dispatchEvent(new Event('change', { bubbles: true }));
    } else one.click();
  }, [selector, dice.roll()]);
  const slide = (selector) => page.evaluate(([selector, where, which]) => {
    const all = [...document.querySelectorAll(selector)].filter((input) => input.offsetParent !== null);
    const one = all[Math.floor(which * all.length)];
    if (!one) return;
    one.value = String(Number(one.min) + where * (Number(one.max) - Number(one.min)));
    for (const event of ['input', 'change']) one.dispatchEvent(new Event(event, { bubbles: true }));
  }, [selector, dice.roll(), dice.roll()]);
  const click = async (selector) => {
    const button = page.locator(selector);
    if ((await button.isVisible()) && (await button.isEnabled())) await button.click();
  };
  const actions = {
    async drag() {
      await page.mouse.move(...(await place()));
      await page.mouse.down({ button: dice.roll() < 0.85 ? 'left' : 'right' });
      for (let i = dice.below(5); i > 0; i--) {
        await page.mouse.move(...(await place()), { steps: 1 + dice.below(6) });
        if (dice.roll() < 0.3) await page.mouse.wheel(0, dice.between(-400, 400));
      }
      for (const button of ['left', 'right']) await page.mouse.up({ button });
    },
    async press() {
      await page.mouse.move(...(await place()));
      await page.mouse.down();
      await page.waitForTimeout(dice.below(600));
      await page.mouse.up();
    },
    wheel: async () => (await page.mouse.move(...(await place())), page.mouse.wheel(0, dice.between(-800, 800))),
    key: async () => (await canvas.focus(), page.keyboard.press(dice.of(['ArrowLeft', 'ArrowUp', '+', '-', 'r', ' ', '.', 'Escape', 'Enter', 'PageDown', 'PageUp', 'Shift+ArrowLeft', 'Shift+ArrowDown', 'Control+z']))),
    tool: () => choose('#live-tools [name=tool]'),
    box: () => choose('#live-tools input[type=checkbox]'),
    list: () => choose('#live-tools option'),
    tool_slider: () => slide('#live-tools input[type=range]'),
    cut_out: () => click('#live-blade-cut'),
    touch: async () => {
      const node = page.locator('#live-node');
      if (await node.isVisible()) await node.fill(String(dice.below(9000)));
      await click('#live-touch');
    },
    let_go: () => click('#live-let-go'),
    undo: () => click('#live-undo'),
    reset: () => click('#live-reset'),
    pause: () => click('#live-pause'),
    step: () => click('#live-step-once'),
    view: () => click('#live-view'),
    colours: () => choose('#live-colours input[type=radio]'),
    skin: () => choose('#live-skin input'),
    open: () => choose('#live-cut option'),
    open_place: () => slide('#live-cut-place'),
    elements: () => choose('#live-fem'),
    law: () => choose('#live-law option'),
    async number() {
      const [name, low, high] = dice.of([['young', 1, 20], ['nu', 0.25, 0.49], ['alpha', 0, 100], ['beta', 0, 0.01], ['step-length', 0, 0]]);
      const field = page.locator(`#live-${name}`);
      await field.fill(dice.between(low, high).toPrecision(2));
      await field.press('Tab');
    },
    window: () => page.setViewportSize(dice.of([{ width: 1200, height: 850 }, { width: 1440, height: 900 }, { width: 400, height: 800 }, { width: 1024, height: 768 }])),
    async compare() {
      for (const mode of ['compare', 'live']) {
        await page.check(`#mode [value=${mode}]`, { force: true });
        await frames(page);
      }
    },
  };
  const often = ['drag', 'drag', 'drag', 'drag', 'drag', 'press', 'press', 'tool', 'tool', 'tool_slider', 'key', 'key', 'touch', 'undo', 'cut_out', 'wheel'];
  const counts = {};
  for (let i = 0; i < numActions; i++) {
    const name = dice.of(dice.roll() < 0.7 ? often : Object.keys(actions));
    await actions[name]();
    counts[name] = (counts[name] ?? 0) + 1;
    await page.waitForTimeout(dice.below(250));
    await check(`${i + 1} (${name})`);
  }
  return counts;
}
