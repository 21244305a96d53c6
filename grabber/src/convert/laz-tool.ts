import { access, constants } from 'node:fs/promises';
import { delimiter, isAbsolute, join, resolve } from 'node:path';
import { GrabberError } from '../util/errors.js';
import { runCommand, type CommandLimits, type CommandOutput } from './run-command.js';
import type { Converters } from './converters.js';

const kName = 'terravox-laz';

/** The project's own tool for point cloud files. Each call runs it once. */
export type LazTool = {
  /** Writes `to`, a LAZ file with the points of the LAS file `from`; compared by the tool. */
  compress(from: string, to: string, folder: string, signal: AbortSignal): Promise<void>;
  /**
   * Decodes all points.
   * @throws GrabberError COMMAND with the tool's reason
   */
  check(file: string, folder: string, signal: AbortSignal): Promise<void>;
  /** Writes the .lax index next to a file. */
  index(file: string, folder: string, signal: AbortSignal): Promise<void>;
  /** Whether the header says that the file is a COPC file. */
  isCopc(file: string, folder: string, signal: AbortSignal): Promise<boolean>;
};

/**
 * Finds the tool in the configuration, the project's build folder, the folder of installed
 * programs, or PATH, in this order.
 * @param packageRoot folder of the grabber's package.json
 * @return undefined when it is not found
 * @throws GrabberError NO_CONVERTER when the configured path is no program
 */
export async function findLazTool(
  converters: Converters,
  packageRoot: string,
): Promise<string | undefined> {
  const configured = converters.laz?.program;
  if (configured !== undefined) {
    const path = resolve(configured);
    if (await isProgram(path)) return path;
    throw new GrabberError(
      'NO_CONVERTER',
      `find ${kName}: ${path} of [laz] program is no program; allowed: the path of ${kName}`,
    );
  }
  const folders = [
    join(packageRoot, '..', 'build', 'release', 'bin'),
    join(packageRoot, '..'),
    ...(process.env['PATH'] ?? '').split(delimiter),
  ];
  for (const folder of folders.filter(isAbsolute)) {
    const path = join(folder, kName);
    if (await isProgram(path)) return path;
  }
  return undefined;
}

export function missingLazTool(what: string): GrabberError {
  return new GrabberError(
    'NO_CONVERTER',
    `${what}: ${kName} was not found; allowed: built (cmake --build build/release), in ` +
      'PATH, or [laz] program in converters.toml',
  );
}

/** @param program absolute path of the tool */
export function lazTool(program: string, time_limit_s: number): LazTool {
  const run = (
    what: string,
    words: string[],
    folder: string,
    disk_bytes: number,
    signal: AbortSignal,
  ): Promise<CommandOutput> => {
    const limits: CommandLimits = { time_limit_s, disk_bytes };
    return runCommand({ what, argv: [program, ...words], folder, limits }, signal);
  };
  const kMaxIndex_bytes = 1 << 30;
  return {
    compress: async (from, to, folder, signal) => {
      await run(`compress ${from}`, ['compress', from, to], folder, 2 ** 40, signal);
    },
    check: async (file, folder, signal) => {
      await run(`check ${file}`, ['check', file], folder, 2 ** 40, signal);
    },
    index: async (file, folder, signal) => {
      await run(`index ${file}`, ['index', file], folder, kMaxIndex_bytes, signal);
    },
    isCopc: async (file, folder, signal) => {
      const { out } = await run(`look into ${file}`, ['info', file], folder, 2 ** 40, signal);
      return (JSON.parse(out) as { copc?: unknown }).copc === true;
    },
  };
}

async function isProgram(path: string): Promise<boolean> {
  return access(path, constants.X_OK).then(
    () => true,
    () => false,
  );
}
