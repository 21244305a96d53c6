import { join } from 'node:path';
import { Command, CommanderError } from 'commander';
import { loadSources } from '../sources/load-sources.js';
import type { Source } from '../sources/source.js';
import { GrabberError, describeError } from '../util/errors.js';
import { readPackageInfo, userAgent } from '../util/package-info.js';
import { kExit } from './exit-codes.js';
import { fetchCommand, type FetchOptions } from './fetch-command.js';
import { listCommand, sourcesCommand } from './list-commands.js';
import { integerIn } from './option-parsers.js';
import type { Output } from './output.js';
import { addSelectionOptions, type SelectionOptions } from './selection.js';

/**
 * Runs one command line.
 * @return the exit code
 * @throws the signal's reason when it aborts
 */
export async function run(args: readonly string[], output: Output, signal: AbortSignal): Promise<number> {
  const state = { exitCode: kExit.done as number };
  try {
    await buildProgram(state, output, signal).parseAsync(args, { from: 'user' });
    return state.exitCode;
  } catch (error) {
    signal.throwIfAborted();
    // Commander has printed its own message by now; help and version come this way too, with exit code 0.
    if (error instanceof CommanderError) return error.exitCode === 0 ? kExit.done : kExit.usage;
    output.err(`error: ${describeError(error)}\n`);
    return error instanceof GrabberError && error.code === 'USAGE' ? kExit.usage : kExit.failed;
  }
}

function buildProgram(state: { exitCode: number }, output: Output, signal: AbortSignal): Command {
  const info = readPackageInfo();
  const program = new Command('terravox-grab')
    .description('Fills a Terravox store with LiDAR squares from open-data portals or local files.')
    .version(info.version)
    .option('--sources-dir <folder>', 'folder of source files (*.toml)', join(info.root, '..', 'config', 'sources'))
    .configureOutput({ writeOut: output.out, writeErr: output.err })
    .exitOverride()
    .addHelpText(
      'after',
      '\nExit codes: 0 done, 1 failed, 2 wrong usage, 3 done but squares are missing, 130 stopped by SIGINT.',
    );
  const sources = (): Promise<ReadonlyMap<string, Source>> =>
    loadSources(program.opts<{ sourcesDir: string }>().sourcesDir, signal);

  program
    .command('sources')
    .description('list the sources')
    .option('--json', 'print JSON')
    .action(async (options: { json?: boolean }) => sourcesCommand(await sources(), options.json ?? false, output));

  addSelectionOptions(program.command('list').description('print the address of each square'))
    .option('--json', 'print one JSON object a line')
    .action(async (options: SelectionOptions & { json?: boolean }) =>
      listCommand(options, await sources(), options.json ?? false, output),
    );

  addSelectionOptions(program.command('fetch').description('download or copy squares into a store'))
    .requiredOption('--store <folder>', 'store to fill; made when it is not there')
    .option('--from <folder>', 'take LAZ and LAS files of this folder instead of the web')
    .option(
      '--concurrency <n>',
      "files at a time, 1 to 32 (default: the source's, else 4)",
      integerIn(1, 32, 'files at a time'),
    )
    .option('--retries <n>', 'tries after the first, 0 to 20', integerIn(0, 20, 'tries after the first'), 5)
    .option('--timeout-s <s>', 'longest silence of a server, seconds, 1 to 3600', integerIn(1, 3600, 'seconds'), 60)
    .option(
      '--max-wait-s <s>',
      'longest Retry-After to obey, seconds, 1 to 86400',
      integerIn(1, 86_400, 'seconds'),
      600,
    )
    .option('--refetch', 'fetch again what is verified already')
    .option('--json', 'log one JSON object a line to standard output')
    .action(async (options: FetchOptions) => {
      state.exitCode = await fetchCommand(options, await sources(), userAgent(info), output, signal);
    });
  return program;
}
