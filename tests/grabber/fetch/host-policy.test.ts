import assert from 'node:assert/strict';
import { test } from 'node:test';
import { kNoAccess, type HttpClientOptions } from '../../../grabber/src/fetch/http-client.js';
import {
  addressAllowed,
  checkUrl,
  policedLookup,
  type HostAccess,
} from '../../../grabber/src/fetch/host-policy.js';
import {
  readSecretHeaders,
  redactError,
  makeRedactor,
  shownUrl,
} from '../../../grabber/src/fetch/redact.js';
import { GrabberError, describeError } from '../../../grabber/src/util/errors.js';
import { toProfile } from '../../../grabber/src/sources/source.js';
import { openCatalogue } from '../../../grabber/src/sources/catalogue/open-catalogue.js';
import { regionOfBox } from '../../../grabber/src/select/region.js';
import { clientFor, found, sourceWith } from '../support/catalogue-fixture.js';
import { kHere, sendFile, sendStatus, serve } from '../support/http-fixture.js';
import { makeLaz } from '../support/las-fixture.js';
import { fetchFixture, kName, kNever, makeSquare } from '../support/store-fixture.js';

const kPublic = {
  hosts: ['data.example', 'files.example:8080', '8.8.8.8', '[2001:4860:4860::8888]'],
  privateOrigins: [],
};
const kOfficeHosts = [
  '127.0.0.1',
  '127.0.0.1:8000',
  '10.0.0.5:8080',
  '224.0.0.1',
  '0.0.0.0',
  '[::1]',
  '[::ffff:7f00:1]',
];
const kOffice = {
  hosts: [...kOfficeHosts, '10.0.0.7'],
  privateOrigins: [...kOfficeHosts, '10.0.0.6:8080'].map((host) => `http://${host}`),
};

test("only addresses of the source's hosts may be requested", async (t) => {
  const cases: [url: string, access: HostAccess, problem: RegExp | undefined][] = [
    ['https://data.example/a.laz', kPublic, undefined],
    ['https://DATA.example:443/a.laz', kPublic, undefined],
    ['http://files.example:8080/a', kPublic, undefined],
    ['http://files.example/a', kPublic, /host files\.example is not one/],
    ['http://files.example:22/a', kPublic, /host files\.example:22 is not one/],
    ['https://evil.example/a', kPublic, /host evil\.example is not one/],
    ['https://data.example.evil.example/a', kPublic, /not one/],
    ['https://data.example@evil.example/a', kPublic, /user name or password/],
    ['https://user:word@data.example/a', kPublic, /user name or password/],
    ['ftp://data.example/a', kPublic, /scheme ftp:/],
    ['file:///etc/passwd', kPublic, /scheme file:/],
    ['data:text/plain,x', kPublic, /scheme data:/],
    ['nonsense', kPublic, /no address/],
    ['http://8.8.8.8/a', kPublic, /numeric host 8\.8\.8\.8/],
    ['http://[2001:4860:4860::8888]/a', kPublic, /numeric host/],
    ['http://127.0.0.1/a', kPublic, /numeric host/],
    ['http://2130706433/a', kPublic, /numeric host 127\.0\.0\.1/],
    ['http://127.0.0.1:8000/a', kOffice, undefined],
    ['http://10.0.0.5:8080/a', kOffice, undefined],
    ['http://[::1]/a', kOffice, undefined],
    ['http://10.0.0.6:8080/a', kOffice, /not one/],
    ['http://2130706433/a', kOffice, /disguised/],
    ['http://0x7f.1/a', kOffice, /disguised/],
    ['http://0177.0.0.1/a', kOffice, /disguised/],
    ['http://127.1/a', kOffice, /disguised/],
    ['http://[::ffff:127.0.0.1]/a', kOffice, /disguised|IPv4 within IPv6/],
    ['http://[::ffff:7f00:1]/a', kOffice, /IPv4 within IPv6/],
    ['http://127.0.0.1:8001/a', kOffice, /numeric host 127\.0\.0\.1:8001; allowed: names, http/],
    ['https://127.0.0.1/a', kOffice, /numeric host/],
    ['http://10.0.0.7/a', kOffice, /numeric host/],
    ['http://224.0.0.1/a', kOffice, /address 224\.0\.0\.1/],
    ['http://0.0.0.0/a', kOffice, /address 0\.0\.0\.0/],
  ];
  for (const [url, access, problem] of cases) {
    await t.test(`${url} ${access === kOffice ? 'in an office' : ''}`, () => {
      if (problem === undefined) assert.equal(checkUrl(url, access).href, new URL(url).href);
      else assert.throws(() => checkUrl(url, access), { code: 'HOST_REFUSED', message: problem });
    });
  }
});

test('addresses that a name leads to are judged one by one', () => {
  const open = '8.8.8.8 2001:4860:4860::8888'.split(' ');
  const office = [
    ...'127.0.0.1 10.1.2.3 192.168.1.1 172.16.0.1 169.254.169.254 100.64.0.1'.split(' '),
    ...'::1 fe80::1 fd00::1 ::ffff:127.0.0.1'.split(' '),
  ];
  const never = [
    ...'0.0.0.0 224.0.0.1 255.255.255.255 240.0.0.1 192.0.2.1'.split(' '),
    ...':: ff02::1 64:ff9b::7f00:1 nonsense'.split(' '),
  ];
  for (const address of open) assert.ok(addressAllowed(address, false), address);
  for (const address of [...office, ...never]) assert.ok(!addressAllowed(address, false), address);
  for (const address of [...open, ...office]) assert.ok(addressAllowed(address, true), address);
  for (const address of never) assert.ok(!addressAllowed(address, true), address);
});

const kToThisMachine: HttpClientOptions['resolve'] = (_name, _options, done) =>
  done(null, [{ address: '127.0.0.1', family: 4 }]);

test('a public name that leads to this machine is refused when it is connected to', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, Buffer.from('secret')));
  const { port } = new URL(server.base);
  const url = `http://rebound.example:${port}/a.laz`;
  const strict = clientFor(t, { hosts: [`rebound.example:${port}`] }, { resolve: kToThisMachine });
  await assert.rejects(strict.get(url, {}, kNever), {
    code: 'HOST_REFUSED',
    retryable: false,
    message: /leads to 127\.0\.0\.1/,
  });
  assert.equal(server.seen.length, 0);
  const access = { hosts: [`rebound.example:${port}`], privateOrigins: [new URL(url).origin] };
  const office = clientFor(t, access, { resolve: kToThisMachine });
  assert.equal((await office.get(url, {}, kNever)).status, 200);
});

test('of a name that leads to this machine and elsewhere, elsewhere is connected to', () => {
  const here = { address: '127.0.0.1', family: 4 };
  const elsewhere = { address: '8.8.8.8', family: 4 };
  const lookup = policedLookup(false, (_name, _options, done) => done(null, [here, elsewhere]));
  lookup('rebound.example', { all: true }, (_error, found) => {
    assert.deepEqual(found, [elsewhere]);
  });
  lookup('rebound.example', {}, (_error, found) => assert.equal(found, elsewhere.address));
  const office = policedLookup(true, (_name, _options, done) => done(null, [here, elsewhere]));
  office('rebound.example', { all: true }, (_error, found) => {
    assert.deepEqual(found, [here, elsewhere]);
  });
});

test('a permitted private address is permitted at its own port only', async (t) => {
  const other = await serve(t, (_request, response) => sendFile(response, makeLaz()));
  const { port } = new URL(other.base);
  const targets = [other.base, `http://office.example:${port}`, `http://files.example:${port}`];
  const own = await serve(t, (request, response) => {
    sendStatus(response, 302, { location: targets[Number(request.url?.slice(1))] ?? '' });
  });
  const { port: ownPort } = new URL(own.base);
  const allowed = `http://office.example:${ownPort}`;
  const hosts = ['127.0.0.1', 'office.example', 'files.example'];
  const http = clientFor(t, { hosts, privateOrigins: [allowed] }, { resolve: kToThisMachine });
  for (const index of targets.keys()) {
    await assert.rejects(http.get(`${allowed}/${index}`, {}, kNever), {
      code: 'HOST_REFUSED',
      retryable: false,
    });
  }
  assert.deepEqual([own.seen.length, other.seen.length], [targets.length, 0]);
  http.permit({ ...kNoAccess, hosts, privateOrigins: [allowed, ...targets] });
  for (const index of targets.keys()) {
    const response = await http.get(`${allowed}/${index}`, {}, kNever);
    await response.discard();
    assert.equal(response.status, 200);
  }
});

test('private origins of a source are those in its file, with their own ports', () => {
  const access = `
[access]
kind = "stac"
items = "http://api.example.org:8443/items"
[[access.assets]]
href = 'laz$'
`;
  const head = 'crs_in_files = true\nhosts = ["assets.example.org", "files.example.org:8080"]';
  assert.deepEqual(toProfile(sourceWith(access, head)).privateOrigins, []);
  assert.deepEqual(
    toProfile(sourceWith(access, `${head}\nallow_private_addresses = true`)).privateOrigins,
    [
      'http://api.example.org:8443',
      'http://assets.example.org',
      'http://files.example.org:8080',
      'https://assets.example.org',
      'https://files.example.org:8080',
    ],
  );
});

test('a client may contact no host before hosts are permitted', async (t) => {
  const server = await serve(t, (_request, response) => sendStatus(response, 200));
  const http = clientFor(t, {});
  await assert.rejects(http.get(server.base, {}, kNever), { code: 'HOST_REFUSED' });
  http.permit(kHere);
  assert.equal((await http.get(server.base, {}, kNever)).status, 200);
});

test('secret headers go to the requested host, and on no redirect elsewhere', async (t) => {
  const other = await serve(t, (_request, response) => sendFile(response, makeLaz()));
  const own = await serve(t, (request, response) => {
    if (request.url === '/there') return sendStatus(response, 302, { location: '/here' });
    if (request.url === '/away') {
      return sendStatus(response, 302, { location: `${other.base}/a.laz` });
    }
    sendFile(response, makeLaz());
  });
  const http = clientFor(t, {
    ...kHere,
    secretHeaders: { 'x-key': 'hush-hush' },
    secretOrigins: [own.base],
  });
  for (const path of ['/here', '/there', '/away']) {
    await (await http.get(`${own.base}${path}`, {}, kNever)).discard();
  }
  assert.deepEqual(
    own.seen.map(({ path, headers }) => [path, headers['x-key']]),
    [
      ['/here', 'hush-hush'],
      ['/there', 'hush-hush'],
      ['/here', 'hush-hush'],
      ['/away', 'hush-hush'],
    ],
  );
  assert.deepEqual(
    other.seen.map(({ headers }) => headers['x-key']),
    [undefined],
  );
});

test('secret headers do not travel unencrypted through the internet', async (t) => {
  const http = clientFor(t, {
    hosts: ['data.example'],
    secretHeaders: { 'x-key': 'hush' },
    secretOrigins: ['http://data.example'],
  });
  await assert.rejects(http.get('http://data.example/a', {}, kNever), {
    code: 'SECRET',
    message: /over http:; allowed: https:/,
  });
});

test('a secret that a server sends back is in no message and no record', async (t) => {
  const echo: ((key: string) => string)[] = [
    (key) => `<html><title>Bad key ${key}</title></html>`,
    (key) => `<html><title>Bad key ${encodeURIComponent(key)}</title></html>`,
  ];
  for (const page of echo) {
    const server = await serve(t, (request, response) =>
      sendFile(response, Buffer.from(page(String(request.headers['x-key'])))),
    );
    const fixture = await fetchFixture(t, server.base, {
      retries: 0,
      access: { secretHeaders: { 'x-key': 'hush/hush 1' }, secretOrigins: [server.base] },
    });
    const [outcome] = await fixture.fetch([makeSquare(kName, [`${server.base}/a`])]);
    assert.match(outcome?.state === 'failed' ? outcome.message : '', /Bad key \*\*\*/);
    assert.ok(!JSON.stringify([outcome, fixture.record()]).includes('hush'));
  }
});

test('secrets come from the environment, and a bad one is not shown', () => {
  assert.deepEqual(readSecretHeaders({ 'X-Key': 'NAME' }, { NAME: 'hush' }), { 'x-key': 'hush' });
  assert.throws(() => readSecretHeaders({ 'x-key': 'NAME' }, {}), {
    code: 'SECRET',
    message: /NAME is not set/,
  });
  assert.throws(
    () => readSecretHeaders({ 'x-key': 'NAME' }, { NAME: 'hush\nX-Other: 1' }),
    (error: Error) =>
      /characters that no header may have/.test(error.message) && !error.message.includes('hush'),
  );
});

test('addresses are shown without what is secret in them', () => {
  assert.equal(
    shownUrl('https://me:word@h.example/a?X-Amz-Signature=abc&x=1'),
    'https://h.example/a?X-Amz-Signature=...&x=1',
  );
});

test('the secrets of a source are for the addresses in its file, not for its further hosts', () => {
  const source = sourceWith(
    `
[access]
kind = "stac"
items = "https://api.example.org:8443/items"
sign = "https://sign.example.org/sign?href={href}"
[[access.assets]]
href = 'laz$'
`,
    'crs_in_files = true\nhosts = ["assets.example.org"]',
  );
  const { hosts, secretOrigins } = toProfile(source);
  assert.deepEqual(hosts, ['api.example.org', 'assets.example.org', 'sign.example.org']);
  assert.deepEqual(secretOrigins, ['https://api.example.org:8443', 'https://sign.example.org']);
});

test('secrets are hidden whole, cut, encoded and without their scheme', () => {
  const cases: [secret: string, text: string, shown: string][] = [
    ['hush', 'bad hush, hus', 'bad ***, hus'],
    ['hush-hush-hush', 'bad hush-hush-hush!', 'bad ***!'],
    ['hush-hush-hush', 'bad hush-hush-hu', 'bad ***'],
    ['hush-hush-hush', 'bad hush-hus', 'bad ***'],
    ['hush-hush-hush', 'bad hush-hu', 'bad hush-hu'],
    ['hush/hush 1', 'bad hush%2Fhush%201, hush%2Fhu', 'bad ***, ***'],
    ['Bearer abcdefghij', 'bad token abcdefghij', 'bad token ***'],
    ['say "hush"', JSON.stringify({ key: 'say "hush"' }), '{"key":"***"}'],
  ];
  for (const [secret, text, shown] of cases) {
    assert.equal(makeRedactor([secret])(text), shown, `${secret} in ${text}`);
  }
});

test('an error shows no secret of its cause', () => {
  const redact = makeRedactor(['hush-hush']);
  const bad = new GrabberError('NETWORK', 'fetch', {
    cause: new Error('bad hush-hush'),
    retryable: true,
    retryAfterMs: 5,
  });
  const safe = redactError(bad, redact);
  assert.ok(safe instanceof GrabberError && safe.retryable && safe.retryAfterMs === 5);
  assert.equal(describeError(safe), 'fetch: bad ***');
  const good = new GrabberError('NETWORK', 'fetch');
  assert.equal(redactError(good, redact), good);
});

test('a secret in a title is hidden before the title is cut', async (t) => {
  const filler = 'x'.repeat(195);
  const page = (key: unknown): Buffer =>
    Buffer.from(`<html><title>${filler}${String(key)}</title></html>`);
  const server = await serve(t, (request, response) =>
    sendFile(response, page(request.headers['x-key'])),
  );
  const fixture = await fetchFixture(t, server.base, {
    retries: 0,
    access: { secretHeaders: { 'x-key': 'hush-hush' }, secretOrigins: [server.base] },
  });
  const [outcome] = await fixture.fetch([makeSquare(kName, [`${server.base}/a`])]);
  assert.match(outcome?.state === 'failed' ? outcome.message : '', /x\*\*\*"/);
});

test('no error of a catalogue shows a secret, whichever call failed', async (t) => {
  const replies: ((key: string) => string)[] = [
    (key) => `<ows:ExceptionText>Bad key ${key}</ows:ExceptionText>`,
    (key) => JSON.stringify({ features: [{ id: key, properties: {}, assets: {} }] }),
    (key) =>
      JSON.stringify({
        features: [],
        links: [{ rel: 'next', href: `http://evil.example/?${key}` }],
      }),
    (key) => `no JSON: ${key}`,
  ];
  for (const reply of replies) {
    const server = await serve(t, (request, response) =>
      response.end(reply(String(request.headers['x-key']))),
    );
    const http = clientFor(t, {
      ...kHere,
      secretHeaders: { 'x-key': 'hush-hush-hush' },
      secretOrigins: [server.base],
    });
    const source = sourceWith(`
[access]
kind = "stac"
items = "${server.base}/items"
name_pattern = '_(?<E>\\d+)-(?<N>\\d+)'
[[access.assets]]
href = 'laz$'
`);
    await assert.rejects(
      found(openCatalogue(source, http), regionOfBox([462_000, 101_000, 464_000, 103_000])),
      (error: Error) => {
        assert.equal(server.seen[0]?.headers['x-key'], 'hush-hush-hush');
        assert.match(describeError(error), /\*\*\*|no JSON/);
        return !describeError(error).includes('hush');
      },
    );
  }
});
