import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import { hostname } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { lockStore } from '../../grabber/src/store/lock.js';
import { kNever, temporaryFolder } from './support/store-fixture.js';

test('a store has one grabber at a time', async (t) => {
  const path = join(await temporaryFolder(t), '.lock');
  const unlock = await lockStore(path, kNever);
  await assert.rejects(lockStore(path, kNever), {
    code: 'STORE_LOCKED',
    message: new RegExp(`process ${process.pid} on`),
  });
  await unlock();
  await (
    await lockStore(path, kNever)
  )();
});

test('the lock of a process that has ended is taken over, that of another machine is not', async (t) => {
  const path = join(await temporaryFolder(t), '.lock');
  // Above the largest process id of any system that Node.js runs on.
  await writeFile(path, `999999999 ${hostname()}\n`);
  await (
    await lockStore(path, kNever)
  )();
  await writeFile(path, '999999999 another-machine\n');
  await assert.rejects(lockStore(path, kNever), { code: 'STORE_LOCKED', message: /on another-machine/ });
});
