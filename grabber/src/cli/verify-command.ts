import { rm } from 'node:fs/promises';
import { join } from 'node:path';
import type { Command } from 'commander';
import type { Store } from '../model/store.js';
import {
  chooseTable,
  verifyFiles,
  wholeFiles,
  type BadFile,
  type VerifyProgress,
} from '../report/verify-store.js';
import type { CliContext } from './context.js';
import { kExit } from './exit-codes.js';
import { parseSourceId } from './option-parsers.js';
import { formatBytes, type Output } from './output.js';
import { checkSource, readStore, storeOption, writeStore, type StoreOption } from './with-store.js';

type VerifyOptions = StoreOption & {
  readonly source?: string;
  readonly repair?: boolean;
  readonly json?: boolean;
};

export function addVerifyCommand(program: Command, context: CliContext): void {
  program
    .command('verify')
    .description('read all finished files again: length, SHA-256, header')
    .addOption(storeOption())
    .option('--source <id>', 'only files of this source', parseSourceId)
    .option('--repair', 'remove bad files and want them again; "resume" fetches them')
    .option('--json', 'print JSON')
    .addHelpText('after', '\nExit codes: 0 all are good, 1 some are bad.')
    .action(async (options: VerifyOptions) => {
      const work = (store: Store): Promise<number> => verifyCommand(store, options, context);
      const run = options.repair === true ? writeStore : readStore;
      context.exit(await run(options.store, context.signal, work));
    });
}

async function verifyCommand(
  store: Store,
  options: VerifyOptions,
  { output, signal }: CliContext,
): Promise<number> {
  checkSource(store, options.source);
  const files = wholeFiles(store, options.source);
  const bad = await verifyFiles(store, files, progressTo(output, process.stderr.isTTY), signal);
  if (options.repair === true) for (const one of bad) await repair(store, one);
  if (options.json === true) {
    const reported = bad.map(({ kind, key, file, reason }) => ({ kind, key, file, reason }));
    const result = { checked: files.length, repaired: options.repair === true, bad: reported };
    output.out(`${JSON.stringify(result, undefined, 2)}\n`);
  } else {
    for (const { key, file, reason } of bad) {
      output.outLine(`bad ${key.source}/${key.name}  ${file.path}: ${reason}`);
    }
    const repaired = options.repair === true ? ', wanted again' : '; --repair wants them again';
    const then = bad.length === 0 ? '' : repaired;
    output.outLine(`${files.length} files checked, ${bad.length} bad${then}`);
  }
  return bad.length === 0 ? kExit.done : kExit.failed;
}

/**
 * Removes a bad file and marks it as wanted. The file goes first: after a kill the record names a
 * missing file, which the next run finds.
 */
async function repair(store: Store, { kind, key, file }: BadFile): Promise<void> {
  await rm(join(store.root, file.path), { force: true });
  chooseTable(store, kind).forget(key);
  chooseTable(store, kind).want([key]);
}

/**
 * Shows progress: one line that is overwritten in a terminal, else a line for every tenth of the
 * files.
 */
function progressTo(output: Output, terminal: boolean): VerifyProgress {
  let reported = 0;
  return (done, total, bytes) => {
    const tenth = Math.floor((10 * done) / total);
    if (!terminal && tenth === reported) return;
    reported = tenth;
    const text = `verify ${done}/${total} files, ${formatBytes(bytes)}`;
    if (terminal) output.drawn.err(`\r${text}${done === total ? '\n' : ''}`);
    else output.errLine(text);
  };
}
