import assert from 'node:assert/strict';
import { readFile, readdir, writeFile } from 'node:fs/promises';
import { hostname } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { lockStore } from '../../grabber/src/store/lock.js';
import { Manifest, type SquareRecord } from '../../grabber/src/store/manifest.js';
import { kNever, temporaryFolder } from './support/store-fixture.js';

function missing(square: string): SquareRecord {
  return {
    source: 'test',
    square,
    url: `http://h/${square}`,
    state: 'missing',
    crs: null,
    class_table: null,
    licence: null,
    attribution: null,
    file: null,
    warnings: [],
    last_error: null,
  };
}

test('records put at the same time all reach the disk, in order of their names', async (t) => {
  const folder = await temporaryFolder(t);
  const path = join(folder, 'manifest.json');
  const manifest = await Manifest.open(path, kNever);
  const names = Array.from({ length: 200 }, (_unused, index) => String((index * 37) % 200).padStart(3, '0'));
  await Promise.all(
    names.map(async (name, index) => {
      if (index % 3 === 0) await Promise.resolve();
      await manifest.put(missing(name));
      const onDisk = JSON.parse(await readFile(path, 'utf8')) as { squares: SquareRecord[] };
      assert.ok(
        onDisk.squares.some((record) => record.square === name),
        `${name} is on disk when its put resolves`,
      );
    }),
  );
  const records = (await Manifest.open(path, kNever)).records();
  assert.deepEqual(
    records.map((record) => record.square),
    [...names].sort(),
  );
  assert.deepEqual(await readdir(folder), ['manifest.json']);
});

test('a manifest that cannot be understood is an error, not an empty store', async (t) => {
  const cases: { name: string; text: string; message: RegExp }[] = [
    { name: 'another version', text: '{"version": 2, "squares": []}', message: /version is 2; allowed: 1/ },
    { name: 'no version', text: '[]', message: /version is missing; allowed: 1/ },
    { name: 'cut off', text: '{"version": 1, "squ', message: /not JSON/ },
    { name: 'a wrong record', text: '{"version": 1, "squares": [{"source": 3}]}', message: /field squares\.0\.source/ },
  ];
  const path = join(await temporaryFolder(t), 'manifest.json');
  for (const { name, text, message } of cases) {
    await t.test(name, async () => {
      await writeFile(path, text);
      await assert.rejects(Manifest.open(path, kNever), { code: 'MANIFEST', message });
    });
  }
});

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
