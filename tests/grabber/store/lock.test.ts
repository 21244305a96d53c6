import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { lockStore } from '../../../grabber/src/store/open-store.js';
import { makeFolder } from '../../../grabber/src/util/files.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

const kModule = new URL('../../../grabber/src/store/open-store.js', import.meta.url).href;

test('a store has one grabber at a time', async (t) => {
  const path = join(await temporaryFolder(t), '.lock');
  const unlock = lockStore(path, kNever);
  assert.throws(() => lockStore(path, kNever), {
    code: 'STORE_LOCKED',
    message: /another grabber holds .*\.lock; allowed: one/,
  });
  unlock();
  lockStore(path, kNever)();
});

test('a killed process leaves no lock, and an empty file is none', async (t) => {
  const path = join(await temporaryFolder(t), '.lock');
  await writeFile(path, '');
  const script =
    `const { lockStore } = await import(${JSON.stringify(kModule)}); globalThis.unlock = ` +
    `lockStore(${JSON.stringify(path)}, new AbortController().signal); console.log('held'); ` +
    'setInterval(() => {}, 1000);';
  const child = spawn(process.execPath, ['--input-type=module', '--eval', script], {
    cwd: fileURLToPath(new URL('.', import.meta.url)),
  });
  t.after(() => child.kill('SIGKILL'));
  await once(child.stdout, 'data');
  assert.throws(() => lockStore(path, kNever), { code: 'STORE_LOCKED' });
  child.kill('SIGKILL');
  await once(child, 'exit');
  lockStore(path, kNever)();
});

test('a folder is made with its parents, and the attempt ends where it cannot be', async (t) => {
  const root = await temporaryFolder(t);
  await makeFolder(join(root, 'a', 'b', 'c'));
  await makeFolder(join(root, 'a', 'b', 'c'));
  await writeFile(join(root, 'file'), '');
  await assert.rejects(makeFolder(join(root, 'file')), { code: 'EEXIST' });
  await assert.rejects(makeFolder(join(root, 'file', 'below')), { code: 'ENOTDIR' });
  await assert.rejects(makeFolder('/proc/no-such-process/x'), { code: 'ENOENT' });
});
