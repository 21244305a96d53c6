import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import type { State } from '../../../grabber/src/model/store.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { DatabaseSync, readValue } from '../../../grabber/src/store/sqlite.js';
import { keyOfSquare, seeded } from '../support/record-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

const kWriter = fileURLToPath(new URL('../support/store-writer.js', import.meta.url));
const kOrder: readonly State[] = ['known', 'wanted', 'fetching', 'fetched', 'verified'];

/**
 * Runs the writer until it has reported `lines` calls, kills it, and returns the reports.
 */
function killAfter(root: string, first: number, lines: number): Promise<string[]> {
  return new Promise((resolve, reject) => {
    const child = spawn(process.execPath, [kWriter, root, String(first)], {
      stdio: ['ignore', 'pipe', 'inherit'],
    });
    let reported = '';
    child.stdout.setEncoding('utf8').on('data', (text: string) => {
      reported += text;
      if (reported.split('\n').length > lines) child.kill('SIGKILL');
    });
    child.on('error', reject);
    child.on('close', (_code, signal) => {
      if (signal === 'SIGKILL') resolve(reported.split('\n').slice(0, -1));
      else reject(new Error(`the writer ended by itself after: ${reported.slice(-200)}`));
    });
  });
}

test('a process killed 50 times while it writes keeps every finished call', async (t) => {
  const root = await temporaryFolder(t);
  const random = seeded(20260621);
  const reported = new Map<string, State>();
  let next = 100;
  for (let round = 0; round < 50; ++round) {
    for (const line of await killAfter(root, next, random(60))) {
      const [e = '', state = ''] = line.split(' ');
      reported.set(`${e}_101`, state as State);
      next = Math.max(next, Number(e));
    }
    const store = openStore(root, {}, kNever);
    for (const [name, state] of reported) {
      const record = store.squares.get(keyOfSquare(name));
      assert.ok(
        record !== undefined && kOrder.indexOf(record.state) >= kOrder.indexOf(state),
        `round ${round}: ${name} was ${state}, is ${record?.state ?? 'lost'}`,
      );
    }
    assert.ok(
      store.squares.list({}).length <= reported.size + round + 1,
      'at most one square more than was reported of each round',
    );
    store.close();
    // The square that was cut off is begun again by the next writer, under another name.
    next += 2;
  }
  assert.ok(reported.size > 50, `${reported.size} squares`);
  const db = new DatabaseSync(join(root, 'fishnet.gpkg'), { readOnly: true });
  assert.equal(readValue(db, 'PRAGMA integrity_check'), 'ok');
  db.close();
});
