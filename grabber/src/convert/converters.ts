import { readFile, access, constants } from 'node:fs/promises';
import { join, delimiter, isAbsolute, resolve } from 'node:path';
import { z } from 'zod';
import { parseConfig, type ConfigKind } from '../config/toml-file.js';
import { GrabberError, systemCode } from '../util/errors.js';
import { runCommand, type CommandLimits, type CommandOutput } from './run-command.js';

const kAllowed = {
  id: '"converters"',
  zlas: 'a table with command and time_limit_s',
  'zlas.command': 'a list of words, the first a program, that hold {input} and {output}',
  'zlas.time_limit_s': 'an integer from 1 to 86400, seconds',
  laz: 'a table with program and time_limit_s',
  'laz.program': 'the path of terravox-laz',
  'laz.time_limit_s': 'an integer from 1 to 86400, seconds',
} as const;

const seconds = z.int().min(1).max(86_400).default(3600);
const command = z
  .array(z.string().min(1))
  .min(1)
  .refine((words) =>
    ['{input}', '{output}'].every((name) => words.some((word) => word.includes(name))),
  );

const schema = z.strictObject({
  id: z.literal('converters'),
  zlas: z.strictObject({ command, time_limit_s: seconds }).optional(),
  laz: z.strictObject({ program: z.string().min(1).optional(), time_limit_s: seconds }).optional(),
});

/** The programs that convert point clouds. */
export type Converters = z.infer<typeof schema>;

const kKind: ConfigKind<Converters> = { what: 'converters file', schema, allowed: kAllowed };
export const kConvertersFile = 'converters.toml';

export function parseConverters(toml: string, path: string): Converters {
  return parseConfig(toml, path, kKind);
}

/** @param folder of the configuration; one without converters.toml configures none */
export async function loadConverters(folder: string, signal: AbortSignal): Promise<Converters> {
  const path = join(folder, kConvertersFile);
  try {
    return parseConverters(await readFile(path, { encoding: 'utf8', signal }), path);
  } catch (error) {
    if (systemCode(error) === 'ENOENT') return { id: 'converters' };
    throw error;
  }
}

export function noZlasConverter(shown: string, configFolder: string): GrabberError {
  return new GrabberError(
    'NO_CONVERTER',
    `convert ${shown}: zLAS is Esri's own compression and no converter is configured; ` +
      'allowed: [zlas] command = ["/path/to/converter", "{input}", "{output}"] in ' +
      `${join(configFolder, kConvertersFile)}`,
  );
}

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
