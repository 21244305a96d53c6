import { looksLikeLas, toPointFacts } from '../las/header.js';
import { verifyLasFile, type LasFile } from '../las/verify.js';
import type { StoreRecord } from '../model/store.js';
import { GrabberError, causedError } from '../util/errors.js';
import type { Checked } from './run-jobs.js';
import { shownUrl } from './redact.js';

export const kLidarExtensions = ['laz', 'las', 'zlas'] as const;

/**
 * What begins so is no point cloud, whatever its name. Esri's zLAS is not public, so its start is
 * not judged.
 */
export function checkLidarStart(shown: string, start: Uint8Array): void {
  if (start.length < 4 || looksLikeLas(start) || /\.zlas$/i.test(toPath(shown))) return;
  const found = JSON.stringify(Buffer.from(start.subarray(0, 12)).toString('latin1'));
  throw new GrabberError(
    'NOT_LAS',
    `fetch ${shown}: the body starts with ${found}; allowed: "LASF", a LAS or LAZ file`,
  );
}

/**
 * Whole, a LAS or LAZ file, and where it belongs: points elsewhere are kept, since the file is
 * trusted over the catalogue.
 */
export async function checkLidar(
  path: string,
  record: StoreRecord,
  url: string,
  signal: AbortSignal,
): Promise<Checked> {
  if (record.member === null && /\.zlas$/i.test(toPath(url))) {
    return { extension: 'zlas', facts: null };
  }
  let header: LasFile;
  try {
    header = await verifyLasFile(path, shownUrl(url), signal);
  } catch (error) {
    signal.throwIfAborted();
    if (error instanceof GrabberError) throw error;
    throw causedError('STORE_IO', `read ${path}`, error);
  }
  return {
    extension: header.compressed ? 'laz' : 'las',
    facts: {
      points: toPointFacts(header),
      image: null,
      crs: header.crs ?? null,
      warnings: [...placeWarnings(record, header), ...crsWarnings(record, header)],
    },
  };
}

function crsWarnings(record: StoreRecord, { crs }: LasFile): string[] {
  if (crs === undefined || record.crs === null || crs === record.crs) return [];
  return [
    `square ${record.key.name} is in ${crs}, as its header says; expected ${record.crs}, which ` +
      'is not used',
  ];
}

function placeWarnings({ key, bounds }: StoreRecord, { min, max }: LasFile): string[] {
  if (bounds === null) return [];
  const [west, south, east, north] = bounds;
  if (max[0] >= west && min[0] <= east && max[1] >= south && min[1] <= north) return [];
  const points = `x ${min[0]} to ${max[0]}, y ${min[1]} to ${max[1]}`;
  return [
    `points of square ${key.name} lie elsewhere: ${points}; expected within ${bounds.join(', ')}`,
  ];
}

function toPath(url: string): string {
  return URL.canParse(url) ? new URL(url).pathname : url;
}
