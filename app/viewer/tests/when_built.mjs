// node when_built.mjs PART.test.mjs STATUS: the tests of a part; or, where the page is not built, why not, and that exit status.
import { spawnSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { delimiter, join } from 'node:path';

const [part, notThere] = process.argv.slice(2);
const viewer = join(import.meta.dirname, '..');
const found = (process.env.PATH ?? '').split(delimiter)
  .flatMap((folder) => ['chromium', 'chromium-browser', 'google-chrome'].map((name) => join(folder, name))).find(existsSync);
const browser = process.env.CHROMIUM ?? found ?? '';
const needs = [
  [join(viewer, 'node_modules/playwright-core'), 'no playwright-core (cd viewer && npm ci)'],
  [join(viewer, 'dist/index.html'), 'no page (cd viewer && npm ci && npm run build)'],
  [browser, `no browser${browser && ` at ${browser}`} (Debian package chromium, or name one in CHROMIUM)`],
];
const missing = needs.filter(([path]) => !existsSync(path)).map(([, sentence]) => sentence);
if (missing.length > 0) {
  console.log(`The page of livermark view is not tested: ${missing.join(', ')}`);
  process.exit(Number(notThere));
}
const { status } = spawnSync(process.execPath, ['--test', join(import.meta.dirname, part)], { stdio: 'inherit', env: { ...process.env, CHROMIUM: browser } });
process.exit(status ?? 1);
