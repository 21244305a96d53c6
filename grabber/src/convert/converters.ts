import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { z } from 'zod';
import { parseConfig, type ConfigKind } from '../config/toml-file.js';
import { GrabberError, systemCode } from '../util/errors.js';

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
