import { lstatSync } from 'node:fs';
import { stat } from 'node:fs/promises';
import { basename, join } from 'node:path';
import type { LasHeader } from '../las/header.js';
import { verifyLasFile, type LasFile } from '../las/verify.js';
import type { StoreRecord, BoundsM } from '../model/store.js';
import { GrabberError } from '../util/errors.js';
import { runCommand } from './run-command.js';
import type { Converters } from './converters.js';
import { readStart } from '../util/files.js';

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
  const { command: argv, time_limit_s } = converter;
  const limits = { time_limit_s, disk_bytes: before.size * kMaxGrowth + kSlack_bytes };
  const values = { input, output, folder };
  await runCommand({ what: `convert ${shown}`, argv, values, folder, limits }, signal);
  const after = await stat(input).catch(() => undefined);
  if (after?.size !== before.size || after.mtimeMs !== before.mtimeMs) {
    throw new GrabberError(
      'CONVERTER',
      `convert ${shown}: the converter changed its input ${input}; allowed: reading it; ` +
        'fetch it again',
    );
  }
  requireFile(output, shown);
  const header = await verifyLasFile(output, `what the converter made of ${shown}`, signal);
  return { path: output, header, warnings: await countWarnings(input, shown, record, header) };
}

/** Refuses a link, which could lead to any file. */
function requireFile(path: string, shown: string): void {
  const found = lstatSync(path, { throwIfNoEntry: false });
  if (found?.isFile() === true) return;
  const what =
    found === undefined
      ? 'ended well but wrote nothing to {output}'
      : 'left a link or a folder at {output}';
  throw new GrabberError(
    'CONVERTER',
    `convert ${shown}: the converter ${what}; allowed: a LAS or LAZ file`,
  );
}

async function countWarnings(
  input: string,
  shown: string,
  record: StoreRecord,
  header: LasHeader,
): Promise<string[]> {
  const wanted = parsePointCount(await readStart(input, kHeaderBytes)) ?? record.points?.pointCount;
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

function liesElsewhere({ min, max }: LasHeader, [west, south, east, north]: BoundsM): boolean {
  const slack = kBoundsSlack_m;
  const isBelow = min[0] < west - slack || min[1] < south - slack;
  return isBelow || max[0] > east + slack || max[1] > north + slack;
}

const kHeaderBytes = 375;
const kMinHeaderBytes = 227;

/**
 * What can be read of a zLAS file without its decoder: the format is not published. Some files
 * begin with a plain LAS header, which then states the number of points. Nothing is concluded from
 * a file that begins with anything else, or whose header makes no sense as one of LAS. Ref: ASPRS,
 * "LAS Specification 1.4 - R15", 2019, section 2.4.
 */
export function parsePointCount(start: Buffer): number | undefined {
  if (start.length < kMinHeaderBytes || start.toString('latin1', 0, 4) !== 'LASF') {
    return undefined;
  }
  const minor = start.readUInt8(25);
  if (start.readUInt8(24) !== 1 || minor > 4 || start.readUInt16LE(94) < kMinHeaderBytes) {
    return undefined;
  }
  const legacy = start.readUInt32LE(107);
  const wide = minor === 4 && start.length >= kHeaderBytes ? Number(start.readBigUInt64LE(247)) : 0;
  const count = wide === 0 ? legacy : wide;
  return Number.isSafeInteger(count) && count > 0 ? count : undefined;
}
