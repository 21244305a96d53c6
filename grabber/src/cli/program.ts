import { join } from 'node:path';
import { Command, CommanderError } from 'commander';
import { GrabberError, describeError, type ErrorCode } from '../util/errors.js';
import { readPackageInfo, shippedConfig } from '../util/package-info.js';
import { type CliContext, kExit, outputTo, type Output, type Streams } from './context.js';

/** Codes of errors that the user corrects: in the command line, or in a configuration file. */
const kUsageCodes: readonly ErrorCode[] = ['USAGE', 'CONFIG'];

type AddCommand = (program: Command, context: CliContext) => void;

/**
 * The commands, in the order of the help text. Each module is imported when its command is used:
 * HTTP, GDAL's formats and the schemas take longer to load than `status` takes to run.
 */
const kCommands: Readonly<Record<string, () => Promise<AddCommand>>> = {
  sources: async () => (await import('./list-command.js')).addSourcesCommand,
  areas: async () => (await import('./list-command.js')).addAreasCommand,
  list: async () => (await import('./list-command.js')).addListCommand,
  fishnet: async () => (await import('./fishnet-command.js')).addFishnetCommand,
  fetch: async () => (await import('./fetch-command.js')).addFetchCommand,
  resume: async () => (await import('./resume-command.js')).addResumeCommand,
  ortho: async () => (await import('./ortho-command.js')).addOrthoCommand,
  convert: async () => (await import('./convert-command.js')).addConvertCommand,
  status: async () => (await import('./status-command.js')).addStatusCommand,
  verify: async () => (await import('./verify-command.js')).addVerifyCommand,
  attribution: async () => (await import('./attribution-command.js')).addAttributionCommand,
  gc: async () => (await import('./gc-command.js')).addGcCommand,
};

/**
 * Runs one command line.
 * @return the exit code
 * @throws the signal's reason when it aborts
 */
export async function run(
  args: readonly string[],
  streams: Streams,
  signal: AbortSignal,
): Promise<number> {
  const output = outputTo(streams);
  const state = { exitCode: kExit.done as number };
  try {
    const program = await buildProgram(args, state, output, signal);
    if (args.length === 1 && args[0] === '--option-tables') {
      const { optionTable } = await import('./option-tables.js');
      output.out(`${JSON.stringify(optionTable(program), null, 1)}\n`);
      return kExit.done;
    }
    await program.parseAsync(args, { from: 'user' });
    return state.exitCode;
  } catch (error) {
    signal.throwIfAborted();
    // Commander has printed its own message by now; help and version come this way too, with exit
    // code 0.
    if (error instanceof CommanderError) return error.exitCode === 0 ? kExit.done : kExit.usage;
    output.errLine(`error: ${describeError(error)}`);
    return error instanceof GrabberError && kUsageCodes.includes(error.code)
      ? kExit.usage
      : kExit.failed;
  }
}

async function buildProgram(
  args: readonly string[],
  state: { exitCode: number },
  output: Output,
  signal: AbortSignal,
): Promise<Command> {
  const info = readPackageInfo();
  const program = new Command('terravox-grab')
    .description(
      'Fills a Terravox store with LiDAR squares and orthophotos from open-data portals or ' +
        'local files.',
    )
    .version(info.version)
    .option(
      '--config <folder>',
      'folder of the configuration: sources, areas, converters',
      shippedConfig(info),
    )
    .configureOutput({ writeOut: output.out, writeErr: output.err })
    .exitOverride()
    .addHelpText(
      'after',
      '\nExit codes: 0 done, 1 failed, 2 wrong usage or configuration, 3 done but squares ' +
        'are missing, 130 stopped by SIGINT.',
    );
  const configFolder = (): string => program.opts<{ config: string }>().config;
  const context: CliContext = {
    output,
    signal,
    info,
    configFolder,
    sources: async () =>
      (await import('../sources/source.js')).loadSources(join(configFolder(), 'sources'), signal),
    exit: (code) => {
      state.exitCode = code;
    },
  };
  for (const load of commandsFor(args)) (await load())(program, context);
  return program;
}

/**
 * Finds the command that is named. Without a name all commands are loaded, for the help text and
 * for error messages.
 */
function commandsFor(args: readonly string[]): (() => Promise<AddCommand>)[] {
  let index = 0;
  while (args[index]?.startsWith('-') === true) index += args[index] === '--config' ? 2 : 1;
  const named = args[index];
  const command =
    named !== undefined && Object.hasOwn(kCommands, named) ? kCommands[named] : undefined;
  return command === undefined ? Object.values(kCommands) : [command];
}
