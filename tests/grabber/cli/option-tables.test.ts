import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { OptionTable } from '../../../grabber/src/cli/option-tables.js';
import { cli } from '../support/cli.js';

test('tables hold each option of each command that help lists', async () => {
  const printed = await cli(['--option-tables']);
  assert.equal(printed.code, 0);
  const table = JSON.parse(printed.out) as OptionTable;
  assert.ok(table.commands.length >= 12);
  for (const command of table.commands) {
    const help = (await cli([command.name, '--help'])).out;
    const listed = [...help.matchAll(/^ {2}(?:-\w, )?(--[\w-]+)/gm)].map((match) => match[1]);
    const names = command.options.flatMap((option) => option.names);
    assert.deepEqual(
      names.filter((name) => name.startsWith('--')),
      listed,
      command.name,
    );
  }
  assert.doesNotMatch(printed.out, /"default": "\//);
});
