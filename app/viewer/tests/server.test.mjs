// `livermark view` over HTTP; how it decides is tested in tests/app/server/fast/site_test.cpp.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { request } from 'node:http';
import { delimiter, dirname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { builtPage, newPage, sampleFolder, startBrowser, startServer } from './browser.mjs';

let samples, server, browser, cookie;
before(async () => {
  samples = sampleFolder();
  server = await startServer(samples.folder);
  browser = await startBrowser();
  const first = await ask(`/${new URL(server.address).search}`);
  cookie = first.headers['set-cookie'][0].split(';')[0];
});
after(async () => {
  await browser?.close();
  samples?.remove();
});

/** With the cookie of the first visit, as a browser does. */
function ask(path, { headers = {}, ...options } = {}) {
  const { hostname, port } = new URL(server.address);
  return new Promise((done, failed) => {
    const asked = request({ hostname, port, path, headers: { ...(cookie && { Cookie: cookie }), ...headers }, ...options }, (response) => {
      const parts = [];
      response.on('data', (part) => parts.push(part));
      response.on('end', () => done({ status: response.statusCode, headers: response.headers, body: Buffer.concat(parts) }));
    });
    asked.on('error', failed);
    asked.end();
  });
}

test('the page and the files arrive byte by byte', async () => {
  assert.deepEqual((await ask('/')).body, readFileSync(builtPage));
  const file = readFileSync(join(samples.folder, 'sample_result.h5'));
  assert.deepEqual((await ask('/files/sample_result.h5')).body, file);
  const head = await ask('/files/sample_result.h5', { method: 'HEAD' });
  assert.equal(head.headers['content-length'], String(file.length));
  assert.equal(head.body.length, 0);
});

test('without the token nothing is shown', async () => {
  for (const path of ['/', '/files.json', '/files/sample_result.h5', '/?token=', '/?token=0123']) {
    const refused = await ask(path, { headers: { Cookie: '' } });
    assert.equal(refused.status, 403, path);
    assert.match(String(refused.body), /open the address that `livermark view` printed/);
    assert.equal(refused.headers['set-cookie'], undefined);
  }
  assert.equal((await ask('/files.json', { headers: { Cookie: cookie.replace(/.$/, (c) => (c === '0' ? '1' : '0')) } })).status, 403);
  assert.equal((await ask('/files.json', { headers: { 'Sec-Fetch-Site': 'cross-site' } })).status, 403);
  assert.equal((await ask('/files.json')).status, 200);
});

test('the page breaks none of its own rules', async () => {
  const { headers } = await ask('/');
  assert.equal(headers['cross-origin-opener-policy'], 'same-origin');
  assert.match(headers['content-security-policy'], /^default-src 'none'; /);
  const page = await newPage(browser);
  try {
    const said = [];
    page.on('console', (message) => message.type() === 'error' && said.push(message.text()));
    page.on('pageerror', (error) => said.push(String(error)));
    // Noticed by the document, and so also what the console would not call an error.
    await page.addInitScript(() => {
      globalThis.violations = [];
      document.addEventListener('securitypolicyviolation', ({ effectiveDirective, blockedURI }) => violations.push(`${effectiveDirective}: ${blockedURI}`));
    });
    await page.goto(`${server.address}#small_result.h5`); // the other one is long and uniform: its highest frequency takes minutes
    await page.locator('#stage[data-drawn]').waitFor();
    await page.locator('#mode input[value=live]').check({ force: true });
    await page.locator('#live[data-state=moving]').waitFor();
    await page.evaluate(() => fetch('http://127.0.0.1:1/').catch(() => {}));
    await page.waitForFunction(() => violations.length > 0);
    assert.deepEqual(await page.evaluate(() => violations), ['connect-src: http://127.0.0.1:1/']);
    // A script that somebody brings into the page does not run.
    await page.evaluate(() => document.body.append(Object.assign(document.createElement('script'), { textContent: 'globalThis.hasRun = true' })));
    assert.equal(await page.evaluate(() => globalThis.hasRun), undefined);
    assert.deepEqual(said.filter((text) => !text.includes('127.0.0.1:1/') && !/inline script/.test(text)), []);
  } finally {
    await page.context().close();
  }
});

test('it opens a browser with a file for its user alone, and not with the token in a command line', async () => {
  const tools = join(samples.folder, 'tools');
  mkdirSync(tools);
  const asked = join(tools, 'asked');
  writeFileSync(join(tools, 'xdg-open'), `#!/bin/sh\nprintf '%s' "$*" >'${asked}.part' && mv '${asked}.part' '${asked}'\n`, { mode: 0o755 });
  const opening = await startServer(samples.folder, ['--browser'], { PATH: `${tools}${delimiter}${process.env.PATH}` });
  while (!existsSync(asked)) await new Promise((done) => setTimeout(done, 20));
  const file = readFileSync(asked, 'utf8');
  const token = new URL(opening.address).searchParams.get('token');
  assert.ok(!file.includes(token));
  assert.equal(statSync(dirname(file)).mode & 0o077, 0, 'nobody else may look into its folder');
  const page = await newPage(browser);
  try {
    await page.goto(`file://${file}`);
    await page.locator('#stage[data-drawn]').waitFor();
    assert.equal(new URL(page.url()).origin, new URL(opening.address).origin);
  } finally {
    await page.context().close();
  }
  assert.equal(await opening.stop(), 0);
  assert.equal(existsSync(file), false);
});

test('other hosts, origins and methods are refused', async () => {
  assert.equal((await ask('/', { headers: { Host: 'example.org' } })).status, 403);
  assert.equal((await ask('/', { headers: { Origin: 'http://localhost.example.org' } })).status, 403);
  assert.equal((await ask('/', { method: 'DELETE' })).status, 405);
  assert.equal((await ask('/files/../../etc/passwd')).status, 404);
});

/** Asks for a WebSocket. @return the status, and the socket if it is 101 */
function upgrade(path, origin, withCookie = cookie) {
  const { hostname, port } = new URL(server.address);
  const headers = {
    Connection: 'Upgrade',
    Upgrade: 'websocket',
    'Sec-WebSocket-Version': '13',
    'Sec-WebSocket-Key': 'dGhlIHNhbXBsZSBub25jZQ==',
    Cookie: withCookie,
    ...(origin && { Origin: origin }),
  };
  return new Promise((done, failed) => {
    const asked = request({ hostname, port, path, headers });
    asked.on('upgrade', (response, socket) => done({ status: response.statusCode, socket }));
    asked.on('response', (response) => done({ status: response.statusCode }));
    asked.on('error', failed);
    asked.end();
  });
}

test('it converses with its own page about a file', async () => {
  const { origin } = new URL(server.address);
  const path = '/live/fem?file=sample_result.h5';
  assert.equal((await upgrade(path)).status, 403);
  assert.equal((await upgrade(path, origin, '')).status, 403);
  assert.equal((await upgrade(path, 'http://example.org')).status, 403);
  assert.equal((await upgrade('/live/nothing', origin)).status, 404);
  const { status, socket } = await upgrade(path, origin);
  assert.equal(status, 101);
  const question = Buffer.from('young_modulus=4000&poisson_ratio=0.45');
  const reply = new Promise((done) => socket.once('data', done));
  socket.write(Buffer.concat([Buffer.from([0x81, 0x80 | question.length, 0, 0, 0, 0]), question])); // the mask is zero
  assert.equal((await reply).subarray(2).toString(), 'chosen=fem_p2');
  // It stays open: Ctrl-C has to end it.
});

test('Ctrl-C ends it with status 0', async () => {
  assert.equal(await server.stop(), 0);
});
