import type { Command } from 'commander';
import {
  convertRecord,
  indexRecord,
  needsConversion,
  type ConvertOptions,
  type ConvertTools,
  convertTools,
} from '../convert/convert-record.js';
import { removeStaleWork } from '../convert/work-folder.js';
import type { State, StoreRecord, Store } from '../model/store.js';
import { describeError, isOfFile, recordedCode } from '../util/errors.js';
import { type CliContext, kExit, formatBytes, type Output } from './context.js';
import { checkSource, storeOption, writeStore } from './with-store.js';

type Options = { store: string; source?: string; index?: boolean; keepOriginal?: boolean };
type Tally = { converted: number; indexed: number; failed: number };

/**
 * States of records whose file may be converted: whole files, files that await conversion, and
 * files whose last conversion failed.
 */
const kConvertible: readonly State[] = ['fetched', 'verified', 'converted', 'failed'];

export function addConvertCommand(program: Command, context: CliContext): void {
  program
    .command('convert')
    .description('bring files of a store into the form that is kept: zLAS and LAS to LAZ')
    .addOption(storeOption())
    .option('--source <id>', 'files of this source only')
    .option('--index', 'write a spatial index (.lax) next to each LAZ file that has none')
    .option(
      '--keep-original',
      'move what was converted to lidar/<source>/original/ instead of removing it',
    )
    .action(async (options: Options) => {
      const { signal } = context;
      const tools = await convertTools(
        { configFolder: context.configFolder(), packageRoot: context.info.root },
        signal,
      );
      await writeStore(options.store, signal, async (store) => {
        checkSource(store, options.source);
        await removeStaleWork(store.root);
        const tally = await convertAll(store, options, tools, context);
        context.output.outLine(
          `${tally.converted} converted, ${tally.indexed} indexed, ${tally.failed} failed`,
        );
        context.exit(tally.failed > 0 ? kExit.failed : kExit.done);
      });
    });
}

async function convertAll(
  store: Store,
  options: Options,
  tools: ConvertTools,
  context: CliContext,
): Promise<Tally> {
  const { output, signal } = context;
  const tally: Tally = { converted: 0, indexed: 0, failed: 0 };
  const how: ConvertOptions = {
    index: options.index ?? false,
    keepOriginal: options.keepOriginal ?? false,
  };
  for (const record of store.squares.list({ states: kConvertible, source: options.source })) {
    if (!needsConversion(record) && !how.index) continue;
    try {
      await convertOne(record, store, tools, how, tally, output, signal);
    } catch (error) {
      signal.throwIfAborted();
      if (!isOfFile(error)) throw error;
      const code = recordedCode(error);
      store.squares.failed(record.key, code, describeError(error));
      ++tally.failed;
      output.errLine(
        `error: ${record.key.source}/${record.key.name} ${code}: ${describeError(error)}`,
      );
    }
  }
  return tally;
}

async function convertOne(
  record: StoreRecord,
  store: Store,
  tools: ConvertTools,
  how: ConvertOptions,
  tally: Tally,
  output: Output,
  signal: AbortSignal,
): Promise<void> {
  const done = await convertRecord(record, store, tools, how, signal);
  if (done !== undefined) {
    ++tally.converted;
    const before = record.file?.bytes ?? 0;
    output.outLine(
      `converted ${done.from} to ${done.file.path}  ${formatBytes(before)} to ` +
        `${formatBytes(done.file.bytes)}`,
    );
    for (const warning of done.warnings) output.errLine(`warning: ${warning}`);
  }
  const now = store.squares.get(record.key);
  if (!how.index || now === undefined) return;
  const lax = await indexRecord(now, store, tools, signal);
  if (lax === undefined) return;
  ++tally.indexed;
  output.outLine(`indexed ${now.file?.path ?? ''}`);
}
