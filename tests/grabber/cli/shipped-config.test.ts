import assert from 'node:assert/strict';
import { mkdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { findLazTool } from '../../../grabber/src/convert/converters.js';
import { shippedConfig } from '../../../grabber/src/util/package-info.js';
import { temporaryFolder } from '../support/store-fixture.js';

test('the configuration is found in a checkout and in a prefix, unless it is named', async (t) => {
  const folder = await temporaryFolder(t);
  const findConfig = (root: string): string => shippedConfig({ version: '1', root });
  const checkout = join(folder, 'checkout');
  await mkdir(join(checkout, 'config'), { recursive: true });
  await writeFile(join(checkout, 'config', 'materials.toml'), '');
  const before = process.env['TERRAVOX_CONFIG'];
  try {
    delete process.env['TERRAVOX_CONFIG'];
    assert.equal(findConfig(join(checkout, 'grabber')), join(checkout, 'config'));
    assert.equal(
      findConfig(join(folder, 'lib', 'terravox', 'grabber')),
      join(folder, 'share', 'terravox', 'config'),
    );
    process.env['TERRAVOX_CONFIG'] = '/own';
    assert.equal(findConfig(join(checkout, 'grabber')), '/own');
  } finally {
    delete process.env['TERRAVOX_CONFIG'];
    if (before !== undefined) process.env['TERRAVOX_CONFIG'] = before;
  }
});

test('the tool for LAZ files is found among installed programs', async (t) => {
  const programs = await temporaryFolder(t);
  const tool = join(programs, 'terravox-laz');
  await writeFile(tool, '', { mode: 0o755 });
  assert.equal(await findLazTool({ id: 'converters' }, join(programs, 'grabber')), tool);
});
