import { mkdir, rename } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import type { LasHeader } from '../las/header.js';
import { verifyLasFile } from '../las/verify.js';
import type { SourceProfile } from '../sources/profile.js';
import type { Square } from '../sources/square.js';
import { lidarFile, partialFile, type StoreLayout } from '../store/layout.js';
import type { Manifest, SquareRecord, StoredFile } from '../store/manifest.js';
import type { Clock } from '../util/clock.js';
import { GrabberError, describeError, systemCode } from '../util/errors.js';
import { fileSize, removeIfThere } from '../util/files.js';
import type { Origin, TransferResult } from './origin.js';
import { removePartial } from './partial.js';
import { withRetries, type RetryNotice, type RetryPolicy } from './retry.js';

export type FetchContext = {
  readonly profile: SourceProfile;
  readonly origin: Origin;
  readonly store: StoreLayout;
  readonly manifest: Manifest;
  readonly policy: RetryPolicy;
  readonly clock: Clock;
  /** Fetch again what is verified already. */
  readonly refetch: boolean;
  readonly onRetry: (square: Square, notice: RetryNotice) => void;
};

export type Outcome =
  | {
      readonly state: 'verified' | 'kept';
      readonly square: string;
      readonly url: string;
      readonly file: StoredFile;
      readonly warnings: readonly string[];
    }
  | { readonly state: 'missing'; readonly square: string; readonly url: string; readonly reason: string }
  | {
      readonly state: 'failed';
      readonly square: string;
      readonly url: string;
      readonly code: string;
      readonly message: string;
    };

/**
 * Brings one square into the store: transfer, verify, rename, record, in this order, so that at every moment a file
 * under its final name is whole and verified. Failures of the square are an outcome; only a stop or a store that
 * cannot be written is thrown.
 */
export async function fetchSquare(square: Square, context: FetchContext, signal: AbortSignal): Promise<Outcome> {
  const { profile, manifest, origin } = context;
  const url = origin.urlOf(square);
  const old = await intactRecord(square, context);
  try {
    if (old?.file && !context.refetch) {
      if (!profile.configured && old.url !== url) throw conflict(square, old, url);
      return { state: 'kept', square: square.name, url: old.url, file: old.file, warnings: old.warnings };
    }
    const done = await withRetries(
      () => transferAndVerify(square, url, context, signal),
      context.policy,
      context.clock,
      (notice) => context.onRetry(square, notice),
      signal,
    );
    if (done.kind === 'missing') {
      const reason = `${profile.id} has no square ${square.name} (${done.reason})`;
      if (old === undefined) await manifest.put({ ...blankRecord(square, url, profile), state: 'missing' });
      else await manifest.put({ ...old, last_error: lastError('MISSING', reason, context.clock) });
      return { state: 'missing', square: square.name, url, reason };
    }
    await manifest.put({
      ...blankRecord(square, url, profile),
      state: 'verified',
      file: done.file,
      warnings: done.warnings,
    });
    // A square that was LAS and is LAZ now, or the other way round, leaves a file that no record names.
    if (old?.file && old.file.path !== done.file.path) await removeIfThere(join(context.store.root, old.file.path));
    return { state: 'verified', square: square.name, url, file: done.file, warnings: done.warnings };
  } catch (error) {
    signal.throwIfAborted();
    // Neither ours nor the system's: a fault in this program, which must not pass for a bad square.
    if (!(error instanceof GrabberError) && systemCode(error) === undefined) throw error;
    const code = error instanceof GrabberError ? error.code : 'STORE_IO';
    const message = describeError(error);
    const record: SquareRecord = old ?? { ...blankRecord(square, url, profile), state: 'failed' };
    await manifest.put({ ...record, last_error: lastError(code, message, context.clock) });
    return { state: 'failed', square: square.name, url, code, message };
  }
}

type Done =
  | Extract<TransferResult, { kind: 'missing' }>
  | { readonly kind: 'stored'; readonly file: StoredFile; readonly warnings: string[] };

async function transferAndVerify(
  square: Square,
  url: string,
  context: FetchContext,
  signal: AbortSignal,
): Promise<Done> {
  const { profile, store } = context;
  if (/\.zlas$/i.test(new URL(url).pathname)) {
    throw new GrabberError(
      'ZLAS_UNSUPPORTED',
      `read square ${square.name} from ${url}: Esri zLAS needs a converter, and none is built in; allowed: LAZ or LAS`,
    );
  }
  const partial = join(store.root, partialFile(profile.id, square.name));
  await mkdir(dirname(partial), { recursive: true });
  const transfer = await context.origin.transfer(square, partial, signal);
  if (transfer.kind === 'missing') return transfer;

  let header: LasHeader;
  try {
    header = await verifyLasFile(partial, url, signal);
  } catch (error) {
    // A complete file that does not verify cannot be continued; the next try must start anew.
    if (!signal.aborted) await removePartial(partial);
    throw error;
  }
  const path = lidarFile(profile.id, square.name, header.compressed);
  await rename(partial, join(store.root, path));
  await removePartial(partial);
  return {
    kind: 'stored',
    warnings: placeWarnings(square, header, profile),
    file: {
      path,
      bytes: transfer.bytes,
      sha256: transfer.sha256,
      point_count: header.pointCount,
      las_version: header.version,
      point_format: header.pointFormat,
      bounds: { min: [...header.min], max: [...header.max] },
      fetched_at: context.clock.now().toISOString(),
    },
  };
}

/** The record of a verified file that is still there with its length; a lost or cut file is fetched again. */
async function intactRecord(square: Square, context: FetchContext): Promise<SquareRecord | undefined> {
  const record = context.manifest.get(context.profile.id, square.name);
  if (record === undefined || record.state !== 'verified' || record.file === null) return undefined;
  const bytes = await fileSize(join(context.store.root, record.file.path));
  return bytes === record.file.bytes ? record : undefined;
}

/** The file's header is trusted over the catalogue, so a square in the wrong place is kept, but said. */
function placeWarnings(square: Square, header: LasHeader, profile: SourceProfile): string[] {
  if (!profile.configured || square.corner === undefined) return [];
  const { east_m, north_m } = square.corner;
  const apart =
    header.max[0] < east_m ||
    header.min[0] > east_m + profile.square_m ||
    header.max[1] < north_m ||
    header.min[1] > north_m + profile.square_m;
  if (!apart) return [];
  const points = `x ${header.min[0]} to ${header.max[0]}, y ${header.min[1]} to ${header.max[1]}`;
  return [
    `points of square ${square.name} lie elsewhere: ${points}; expected within ${profile.square_m} m of ${east_m}, ${north_m}`,
  ];
}

function blankRecord(square: Square, url: string, profile: SourceProfile): Omit<SquareRecord, 'state'> {
  const { crs, class_table, licence, attribution } = profile;
  return {
    source: profile.id,
    square: square.name,
    url,
    crs,
    class_table,
    licence,
    attribution,
    file: null,
    warnings: [],
    last_error: null,
  };
}

function lastError(code: string, message: string, clock: Clock): SquareRecord['last_error'] {
  return { code, message, at: clock.now().toISOString() };
}

function conflict(square: Square, old: SquareRecord, url: string): GrabberError {
  return new GrabberError(
    'STORE_CONFLICT',
    `fetch square ${old.source}/${square.name} from ${url}: the store has it from ${old.url}; allowed: the same address, another --as, or --refetch`,
  );
}
