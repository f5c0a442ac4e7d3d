// `livermark view` over HTTP; how it decides is tested in tests/unit/site_test.cpp.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { request } from 'node:http';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { builtPage, sampleFolder, startServer } from './browser.mjs';

let samples, server;
before(async () => {
  samples = sampleFolder();
  server = await startServer(samples.folder);
});
after(() => samples?.remove());

function ask(path, options = {}) {
  const { hostname, port } = new URL(server.address);
  return new Promise((done, failed) => {
    const asked = request({ hostname, port, path, ...options }, (response) => {
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

test('other hosts, origins and methods are refused', async () => {
  assert.equal((await ask('/', { headers: { Host: 'example.org' } })).status, 403);
  assert.equal((await ask('/', { headers: { Origin: 'http://localhost.example.org' } })).status, 403);
  assert.equal((await ask('/', { method: 'DELETE' })).status, 405);
  assert.equal((await ask('/files/../../etc/passwd')).status, 404);
});

/** Asks for a WebSocket. @return the status, and the socket if it is 101 */
function upgrade(path, origin) {
  const { hostname, port } = new URL(server.address);
  const headers = {
    Connection: 'Upgrade',
    Upgrade: 'websocket',
    'Sec-WebSocket-Version': '13',
    'Sec-WebSocket-Key': 'dGhlIHNhbXBsZSBub25jZQ==',
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
  const origin = server.address.slice(0, -1);
  const path = '/live/fem?file=sample_result.h5';
  assert.equal((await upgrade(path)).status, 403);
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
