import type { Command } from 'commander';
import type { Source } from '../sources/source.js';
import type { CliContext } from './context.js';
import { formatTable, type Output } from './output.js';
import { addSelectionOptions, remoteSelection, type SelectionOptions } from './selection.js';

export function addListCommands(program: Command, context: CliContext): void {
  program
    .command('sources')
    .description('list the sources')
    .option('--json', 'print JSON')
    .action(async (options: { json?: boolean }) =>
      sourcesCommand(await context.sources(), options.json ?? false, context.output),
    );

  addSelectionOptions(program.command('list').description('print the address of each square'))
    .option('--json', 'print one JSON object a line')
    .action(async (options: SelectionOptions & { json?: boolean }) =>
      listCommand(options, await context.sources(), options.json ?? false, context.output),
    );
}

/** Prints the configured sources. */
function sourcesCommand(sources: ReadonlyMap<string, Source>, json: boolean, output: Output): void {
  const all = [...sources.values()];
  if (json) {
    output.out(`${JSON.stringify(all, undefined, 2)}\n`);
    return;
  }
  const rows = all.map((source) => [
    source.id,
    source.crs,
    `${source.square_m} m`,
    source.class_table,
    String(source.max_concurrent),
    Object.keys(source.variables).join(' ') || '-',
    source.licence,
    source.title,
  ]);
  output.out(formatTable(['id', 'crs', 'square', 'classes', 'at once', 'needs', 'licence', 'title'], rows));
}

/** Prints the address of each square, without asking anybody whether it exists. */
function listCommand(
  options: SelectionOptions,
  sources: ReadonlyMap<string, Source>,
  json: boolean,
  output: Output,
): void {
  const selection = remoteSelection(options, sources);
  for (const square of selection.squares) {
    const url = selection.urlOf(square);
    output.out(
      json
        ? `${JSON.stringify({ source: selection.profile.id, square: square.name, url })}\n`
        : `${square.name}\t${url}\n`,
    );
  }
}
