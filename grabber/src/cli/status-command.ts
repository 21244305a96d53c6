import type { Command } from 'commander';
import { readStatus, statusText } from '../report/status.js';
import type { CliContext } from './context.js';
import { readStore, storeOption, type StoreOption } from './with-store.js';

const kColumns = 80;
const kMaxPictureRows = 40;

type StatusOptions = StoreOption & { readonly json?: boolean };

export function addStatusCommand(program: Command, context: CliContext): void {
  program
    .command('status')
    .description(
      'what the store holds: counts by source and state, a picture of the squares, the last errors',
    )
    .addOption(storeOption())
    .option('--json', 'print JSON, without the picture')
    .action((options: StatusOptions) => statusCommand(options, context));
}

/** Also while a fetch runs. */
function statusCommand(options: StatusOptions, { output, signal }: CliContext): Promise<void> {
  return readStore(options.store, signal, (store) => {
    const status = readStatus(store);
    if (options.json === true) return output.out(`${JSON.stringify(status, undefined, 2)}\n`);
    const { isTTY, columns } = process.stdout;
    const colour = isTTY && (process.env['NO_COLOR'] ?? '') === '';
    const size = {
      columns: Math.max(10, (isTTY && columns > 0 ? columns : kColumns) - 1),
      rows: kMaxPictureRows,
    };
    output.drawn.out(statusText(status, store.squares.places(), size, { colour }));
  });
}
