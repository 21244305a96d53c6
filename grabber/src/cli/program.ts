import { join } from 'node:path';
import { Command, CommanderError } from 'commander';
import { loadSources } from '../sources/load-sources.js';
import { GrabberError, describeError } from '../util/errors.js';
import { readPackageInfo } from '../util/package-info.js';
import type { CliContext } from './context.js';
import { kExit } from './exit-codes.js';
import { addFetchCommand } from './fetch-command.js';
import { addListCommands } from './list-commands.js';
import type { Output } from './output.js';

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
    .option('--config <folder>', 'folder of the configuration: sources/*.toml and the rest', join(info.root, '..', 'config'))
    .configureOutput({ writeOut: output.out, writeErr: output.err })
    .exitOverride()
    .addHelpText(
      'after',
      '\nExit codes: 0 done, 1 failed, 2 wrong usage, 3 done but squares are missing, 130 stopped by SIGINT.',
    );
  const configFolder = (): string => program.opts<{ config: string }>().config;
  const context: CliContext = {
    output,
    signal,
    info,
    configFolder,
    sources: () => loadSources(join(configFolder(), 'sources'), signal),
    exit: (code) => {
      state.exitCode = code;
    },
  };
  addListCommands(program, context);
  addFetchCommand(program, context);
  return program;
}
