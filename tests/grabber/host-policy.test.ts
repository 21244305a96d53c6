import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createHttpClient, type Access, type HttpClientOptions } from '../../grabber/src/fetch/http-client.js';
import { addressAllowed, checkUrl } from '../../grabber/src/fetch/host-policy.js';
import { readSecretHeaders } from '../../grabber/src/fetch/secret-headers.js';
import { shownUrl } from '../../grabber/src/fetch/shown-url.js';
import { sendFile, sendStatus, serve } from './support/http-fixture.js';
import { makeLaz } from './support/las-fixture.js';
import { fetchFixture, kName, kNever, squareOf } from './support/store-fixture.js';

const kPublic = { hosts: ['data.example', 'files.example:8080', '8.8.8.8', '[2001:4860:4860::8888]'], allowPrivate: false };
const kOffice = { hosts: ['127.0.0.1', '10.0.0.5:8080', '224.0.0.1', '0.0.0.0', '[::1]', '[::ffff:7f00:1]'], allowPrivate: true };

test('only addresses of the source\'s hosts may be asked', async (t) => {
  const cases: { url: string; access: typeof kPublic; problem: RegExp | undefined }[] = [
    { url: 'https://data.example/a.laz', access: kPublic, problem: undefined },
    { url: 'https://DATA.example:443/a.laz', access: kPublic, problem: undefined },
    { url: 'http://files.example:8080/a', access: kPublic, problem: undefined },
    { url: 'http://files.example/a', access: kPublic, problem: /host files\.example is not one/ },
    { url: 'http://files.example:22/a', access: kPublic, problem: /host files\.example:22 is not one/ },
    { url: 'https://evil.example/a', access: kPublic, problem: /host evil\.example is not one/ },
    { url: 'https://data.example.evil.example/a', access: kPublic, problem: /not one/ },
    { url: 'https://data.example@evil.example/a', access: kPublic, problem: /user name or password/ },
    { url: 'https://user:word@data.example/a', access: kPublic, problem: /user name or password/ },
    { url: 'ftp://data.example/a', access: kPublic, problem: /scheme ftp:/ },
    { url: 'file:///etc/passwd', access: kPublic, problem: /scheme file:/ },
    { url: 'data:text/plain,x', access: kPublic, problem: /scheme data:/ },
    { url: 'nonsense', access: kPublic, problem: /no address/ },
    { url: 'http://8.8.8.8/a', access: kPublic, problem: /numeric host 8\.8\.8\.8/ },
    { url: 'http://[2001:4860:4860::8888]/a', access: kPublic, problem: /numeric host/ },
    { url: 'http://127.0.0.1/a', access: kPublic, problem: /numeric host/ },
    { url: 'http://2130706433/a', access: kPublic, problem: /numeric host 127\.0\.0\.1/ },
    { url: 'http://127.0.0.1:8000/a', access: kOffice, problem: undefined },
    { url: 'http://10.0.0.5:8080/a', access: kOffice, problem: undefined },
    { url: 'http://[::1]/a', access: kOffice, problem: undefined },
    { url: 'http://10.0.0.6:8080/a', access: kOffice, problem: /not one/ },
    { url: 'http://2130706433/a', access: kOffice, problem: /disguised/ },
    { url: 'http://0x7f.1/a', access: kOffice, problem: /disguised/ },
    { url: 'http://0177.0.0.1/a', access: kOffice, problem: /disguised/ },
    { url: 'http://127.1/a', access: kOffice, problem: /disguised/ },
    { url: 'http://[::ffff:127.0.0.1]/a', access: kOffice, problem: /disguised|IPv4 within IPv6/ },
    { url: 'http://[::ffff:7f00:1]/a', access: kOffice, problem: /IPv4 within IPv6/ },
    { url: 'http://224.0.0.1/a', access: kOffice, problem: /address 224\.0\.0\.1/ },
    { url: 'http://0.0.0.0/a', access: kOffice, problem: /address 0\.0\.0\.0/ },
  ];
  for (const { url, access, problem } of cases) {
    await t.test(`${url} ${access.allowPrivate ? 'in an office' : ''}`, () => {
      if (problem === undefined) assert.equal(checkUrl(url, access).href, new URL(url).href);
      else assert.throws(() => checkUrl(url, access), { code: 'HOST_REFUSED', message: problem });
    });
  }
});

test('addresses that a name leads to are judged one by one', () => {
  const open = ['8.8.8.8', '2001:4860:4860::8888'];
  const office = ['127.0.0.1', '10.1.2.3', '192.168.1.1', '172.16.0.1', '169.254.169.254', '100.64.0.1', '::1', 'fe80::1', 'fd00::1', '::ffff:127.0.0.1'];
  const never = ['0.0.0.0', '224.0.0.1', '255.255.255.255', '::', 'ff02::1', '240.0.0.1', '192.0.2.1', '64:ff9b::7f00:1', 'nonsense'];
  for (const address of open) assert.ok(addressAllowed(address, kPublic), address);
  for (const address of [...office, ...never]) assert.ok(!addressAllowed(address, kPublic), address);
  for (const address of [...open, ...office]) assert.ok(addressAllowed(address, kOffice), address);
  for (const address of never) assert.ok(!addressAllowed(address, kOffice), address);
});

function clientOf(access: Partial<Access>, resolve?: HttpClientOptions['resolve']) {
  return createHttpClient({
    userAgent: 'terravox-grabber/test',
    timeout_ms: 2000,
    access: { hosts: [], allowPrivate: false, secretHeaders: {}, ...access },
    ...(resolve === undefined ? {} : { resolve }),
  });
}

test('a public name that leads to this machine is refused when it is connected to', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, Buffer.from('secret')));
  const { port } = new URL(server.base);
  const resolve: HttpClientOptions['resolve'] = (_name, _options, done) => done(null, [{ address: '127.0.0.1', family: 4 }]);
  const url = `http://rebound.example:${port}/a.laz`;
  const strict = clientOf({ hosts: [`rebound.example:${port}`] }, resolve);
  t.after(() => strict.close());
  await assert.rejects(strict.get(url, {}, kNever), { code: 'HOST_REFUSED', retryable: false, message: /leads to 127\.0\.0\.1/ });
  assert.equal(server.seen.length, 0);
  const office = clientOf({ hosts: [`rebound.example:${port}`], allowPrivate: true }, resolve);
  t.after(() => office.close());
  assert.equal((await office.get(url, {}, kNever)).status, 200);
});

test('a client may talk to nobody before it is told to whom', async (t) => {
  const server = await serve(t, (_request, response) => sendStatus(response, 200));
  const http = clientOf({});
  t.after(() => http.close());
  await assert.rejects(http.get(server.base, {}, kNever), { code: 'HOST_REFUSED' });
  http.permit({ hosts: ['127.0.0.1'], allowPrivate: true, secretHeaders: {} });
  assert.equal((await http.get(server.base, {}, kNever)).status, 200);
});

test('secret headers go to the host that was asked, and on no redirect elsewhere', async (t) => {
  const other = await serve(t, (_request, response) => sendFile(response, makeLaz()));
  const own = await serve(t, (request, response) => {
    if (request.url === '/there') return sendStatus(response, 302, { location: '/here' });
    if (request.url === '/away') return sendStatus(response, 302, { location: `${other.base}/a.laz` });
    sendFile(response, makeLaz());
  });
  const http = clientOf({ hosts: ['127.0.0.1'], allowPrivate: true, secretHeaders: { 'x-key': 'hush-hush' } });
  t.after(() => http.close());
  for (const path of ['/here', '/there', '/away']) await (await http.get(`${own.base}${path}`, {}, kNever)).discard();
  assert.deepEqual(own.seen.map(({ path, headers }) => [path, headers['x-key']]), [
    ['/here', 'hush-hush'],
    ['/there', 'hush-hush'],
    ['/here', 'hush-hush'],
    ['/away', 'hush-hush'],
  ]);
  assert.deepEqual(other.seen.map(({ headers }) => headers['x-key']), [undefined]);
});

test('secret headers do not travel unencrypted through the open net', async (t) => {
  const http = clientOf({ hosts: ['data.example'], secretHeaders: { 'x-key': 'hush' } });
  t.after(() => http.close());
  await assert.rejects(http.get('http://data.example/a', {}, kNever), { code: 'SECRET', message: /over http:; allowed: https:/ });
});

test('a secret that a server sends back is in no message and no record', async (t) => {
  const echo: ((key: string) => string)[] = [
    (key) => `<html><title>Bad key ${key}</title></html>`,
    (key) => `<html><title>Bad key ${encodeURIComponent(key)}</title></html>`,
  ];
  for (const page of echo) {
    const server = await serve(t, (request, response) => sendFile(response, Buffer.from(page(String(request.headers['x-key'])))));
    const fixture = await fetchFixture(t, server.base, { retries: 0, access: { secretHeaders: { 'x-key': 'hush/hush 1' } } });
    const [outcome] = await fixture.fetch([squareOf(kName, [`${server.base}/a`])]);
    assert.match(outcome?.state === 'failed' ? outcome.message : '', /Bad key \*\*\*/);
    assert.ok(!JSON.stringify([outcome, fixture.record()]).includes('hush'));
  }
});

test('secrets come from the environment, and a bad one is not shown', () => {
  assert.deepEqual(readSecretHeaders({ 'X-Key': 'NAME' }, { NAME: 'hush' }), { 'x-key': 'hush' });
  assert.throws(() => readSecretHeaders({ 'x-key': 'NAME' }, {}), { code: 'SECRET', message: /NAME is not set/ });
  assert.throws(
    () => readSecretHeaders({ 'x-key': 'NAME' }, { NAME: 'hush\nX-Other: 1' }),
    (error: Error) => /characters that no header may have/.test(error.message) && !error.message.includes('hush'),
  );
});

test('addresses are shown without what is secret in them', () => {
  assert.equal(shownUrl('https://me:word@h.example/a?X-Amz-Signature=abc&x=1'), 'https://h.example/a?X-Amz-Signature=...&x=1');
});
