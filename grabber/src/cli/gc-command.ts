import type { Command } from 'commander';
import { removeStaleWork } from '../convert/work-folder.js';
import type { Store } from '../model/store.js';
import { findLeftovers, removeLeftovers } from '../report/leftovers.js';
import type { CliContext } from './context.js';
import { parseSourceId } from './option-parsers.js';
import { formatBytes } from './output.js';
import { checkSource, storeOption, writeStore, type StoreOption } from './with-store.js';

type GcOptions = StoreOption & { readonly source?: string; readonly dryRun?: boolean };

export function addGcCommand(program: Command, context: CliContext): void {
  program
    .command('gc')
    .description(
      'remove files of the store that no record names, and unfinished ones that are no ' +
        'longer needed',
    )
    .addOption(storeOption())
    .option('--source <id>', 'drop all files of this source; its squares stay known', parseSourceId)
    .option('--dry-run', 'only list what would be removed')
    .action((options: GcOptions) =>
      writeStore(options.store, context.signal, (store) => gcCommand(store, options, context)),
    );
}

async function gcCommand(
  store: Store,
  { source, dryRun = false }: GcOptions,
  { output, signal }: CliContext,
): Promise<void> {
  checkSource(store, source);
  const { files, leftAlone } = await findLeftovers(store, source, signal);
  // Records first: a run that is cut off here leaves files that no record names, which the next one
  // finds.
  const dropped = source === undefined ? 0 : dropRecords(store, source, dryRun);
  if (!dryRun) {
    await removeStaleWork(store.root);
    await removeLeftovers(store, files, signal);
  }
  for (const { path, bytes } of files) {
    output.outLine(`${dryRun ? 'would remove' : 'removed'} ${path}  ${formatBytes(bytes)}`);
  }
  for (const path of leftAlone) {
    output.errLine(
      `warning: left alone ${path}: a link, not in the store, or no file of the grabber's`,
    );
  }
  const total = files.reduce((sum, { bytes }) => sum + bytes, 0);
  const records =
    source === undefined
      ? ''
      : `, ${dropped} records of ${source}${dryRun ? ' would be' : ''} dropped`;
  output.outLine(
    `${files.length} files, ${formatBytes(total)}${dryRun ? ' would go' : ' removed'}${records}`,
  );
}

function dropRecords(store: Store, source: string, dryRun: boolean): number {
  let dropped = 0;
  for (const table of [store.squares, store.orthophotos]) {
    for (const { key, state } of table.list({ source })) {
      if (state === 'known') continue;
      ++dropped;
      if (!dryRun) table.forget(key);
    }
  }
  return dropped;
}
