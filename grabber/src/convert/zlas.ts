import { lstat, stat } from 'node:fs/promises';
import { basename, join } from 'node:path';
import type { LasHeader } from '../las/header.js';
import { verifyLasFile, type LasFile } from '../las/verify.js';
import type { StoreRecord } from '../model/square.js';
import { GrabberError, systemCode } from '../util/errors.js';
import { runCommand } from './run-command.js';
import type { Converters } from './converters.js';
import { readZlasFacts } from './zlas-header.js';

export type Unpacked = {
  readonly path: string;
  readonly header: LasFile;
  readonly warnings: readonly string[];
};

/** zLAS takes about as much as LAZ; LAS takes ten times that, and a converter may keep a copy. */
const kMaxGrowth = 60;
const kSlack_bytes = 64 << 20;
/** Points beyond their square: strips are cut by pulses, and squares may overlap a little. */
const kBoundsSlack_m = 50;

/**
 * Runs the configured converter and checks its output: a whole LAS or LAZ file with as many points
 * as the zLAS file declares. Only the output in `folder` is used.
 * @throws GrabberError COMMAND or CONVERTER
 */
export async function unpackZlas(
  input: string,
  record: StoreRecord,
  converter: NonNullable<Converters['zlas']>,
  folder: string,
  signal: AbortSignal,
): Promise<Unpacked> {
  const shown = basename(input);
  const output = join(folder, 'converted.laz');
  const before = await stat(input);
  const limits = {
    time_limit_s: converter.time_limit_s,
    disk_bytes: before.size * kMaxGrowth + kSlack_bytes,
  };
  const values = { input, output, folder };
  await runCommand(
    { what: `convert ${shown}`, argv: converter.command, values, folder, limits },
    signal,
  );
  const after = await stat(input).catch(() => undefined);
  if (after?.size !== before.size || after.mtimeMs !== before.mtimeMs) {
    throw new GrabberError(
      'CONVERTER',
      `convert ${shown}: the converter changed its input ${input}; allowed: reading it; ` +
        'fetch it again',
    );
  }
  await requireFile(output, shown);
  const header = await verifyLasFile(output, `what the converter made of ${shown}`, signal);
  return { path: output, header, warnings: await countWarnings(input, shown, record, header) };
}

/** Refuses a link, which could lead to any file. */
async function requireFile(path: string, shown: string): Promise<void> {
  try {
    if ((await lstat(path)).isFile()) return;
  } catch (error) {
    if (systemCode(error) !== 'ENOENT') throw error;
    throw new GrabberError(
      'CONVERTER',
      `convert ${shown}: the converter ended well but wrote nothing to {output}; allowed: ` +
        'a LAS or LAZ file',
    );
  }
  throw new GrabberError(
    'CONVERTER',
    `convert ${shown}: the converter left a link or a folder at {output}; allowed: a LAS ` +
      'or LAZ file',
  );
}

async function countWarnings(
  input: string,
  shown: string,
  record: StoreRecord,
  header: LasHeader,
): Promise<string[]> {
  const wanted = (await readZlasFacts(input)).pointCount ?? record.points?.pointCount;
  if (wanted !== undefined) {
    if (header.pointCount === wanted) return [];
    throw new GrabberError(
      'CONVERTER',
      `convert ${shown}: the converter made ${header.pointCount} points; allowed: ` +
        `${wanted}, as the zLAS file says`,
    );
  }
  if (record.bounds !== null && liesElsewhere(header, record.bounds)) {
    throw new GrabberError(
      'CONVERTER',
      `convert ${shown}: the converted points lie at x ${header.min[0]} to ` +
        `${header.max[0]}, y ${header.min[1]} to ${header.max[1]}; allowed: within ` +
        `${kBoundsSlack_m} m of ${record.bounds.join(', ')}`,
    );
  }
  return [
    `${shown} does not state its number of points: the ${header.pointCount} converted ones ` +
      'could only be checked for lying in the square',
  ];
}

function liesElsewhere(
  header: LasHeader,
  [west, south, east, north]: readonly number[] & { length: 4 },
): boolean {
  const slack = kBoundsSlack_m;
  return (
    header.min[0] < (west ?? 0) - slack ||
    header.min[1] < (south ?? 0) - slack ||
    header.max[0] > (east ?? 0) + slack ||
    header.max[1] > (north ?? 0) + slack
  );
}
