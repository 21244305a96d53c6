import { constants, lstatSync, openSync, unlinkSync, writeFileSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { z } from 'zod';
import { systemCode } from '../util/errors.js';
import { storeError, withStoreErrorsSync } from './disk-space.js';
import type { HttpResponse } from './http-client.js';

/** What is needed to continue an unfinished file; stored next to it as JSON. */
const stateSchema = z.strictObject({
  url: z.string(),
  /**
   * A strong ETag or a Last-Modified date: the server sends the rest only if the file is still this
   * one.
   */
  if_range: z.string().min(1).nullable(),
  total_bytes: z.int().min(1).nullable(),
});

export type PartialState = z.infer<typeof stateSchema>;
export type Resumable = PartialState & { readonly if_range: string; readonly offset_bytes: number };

export type PartialFile =
  /** Nothing that can be used; the file must be fetched from its start. */
  | { readonly kind: 'nothing' }
  | { readonly kind: 'part'; readonly part: Resumable }
  /** All bytes are here; a run ended between the last byte and the check. */
  | { readonly kind: 'whole'; readonly bytes: number };

export async function findPartial(
  partial: string,
  url: string,
  signal: AbortSignal,
): Promise<PartialFile> {
  const offset_bytes = measureSize(partial) ?? 0;
  const state = offset_bytes === 0 ? undefined : await readPartialState(partial, signal);
  if (state === undefined || state.url !== url) return { kind: 'nothing' };
  if (state.total_bytes === offset_bytes) return { kind: 'whole', bytes: offset_bytes };
  if (state.if_range === null || (state.total_bytes !== null && offset_bytes > state.total_bytes)) {
    return { kind: 'nothing' };
  }
  return { kind: 'part', part: { ...state, if_range: state.if_range, offset_bytes } };
}

/**
 * @return undefined when there is none, or one that a crash has cut: that only costs a fetch from
 * the start
 */
export async function readPartialState(
  partial: string,
  signal: AbortSignal,
): Promise<PartialState | undefined> {
  if (measureSize(statePath(partial)) === undefined) return undefined;
  const text = await readFile(statePath(partial), { encoding: 'utf8', signal });
  try {
    return stateSchema.safeParse(JSON.parse(text)).data;
  } catch {
    return undefined;
  }
}

/**
 * Opens an unfinished file for writing at its end; with `offset_bytes` 0 a new file replaces it. A
 * link in its place is not followed.
 * @return file descriptor
 * @throws GrabberError STORE_IO or DISK_FULL
 */
export function openPartial(partial: string, offset_bytes: number): number {
  return withStoreErrorsSync(partial, () => {
    if (offset_bytes > 0) {
      return openSync(partial, constants.O_WRONLY | constants.O_APPEND | constants.O_NOFOLLOW);
    }
    unlinkIfThere(partial);
    return openSync(partial, 'wx');
  });
}

/**
 * Stores the server's description of the file before its first byte is written, so that whatever
 * part of it is on the disk when the process dies can be continued, and a whole file is recognised.
 * Written synchronously and without a sync: it is one small write per file, and losing it in a
 * power cut only costs a new fetch.
 */
export function rememberState(
  partial: string,
  url: string,
  response: HttpResponse,
  total_bytes: number | undefined,
): void {
  writeState(partial, {
    url,
    if_range: readValidator(response) ?? null,
    total_bytes: total_bytes ?? null,
  });
}

/** Stores that a file of unknown length is whole. */
export function rememberWhole(partial: string, url: string, bytes: number): void {
  writeState(partial, { url, if_range: null, total_bytes: bytes });
}

function writeState(partial: string, state: PartialState): void {
  const path = statePath(partial);
  withStoreErrorsSync(path, () => {
    unlinkIfThere(path);
    writeFileSync(path, JSON.stringify(state), { flag: 'wx' });
  });
}

export function removePartial(partial: string): void {
  unlinkIfThere(statePath(partial));
  unlinkIfThere(partial);
}

export function forgetState(partial: string): void {
  unlinkIfThere(statePath(partial));
}

function unlinkIfThere(path: string): void {
  // In most cases there is no file, and an exception costs more than a query.
  if (lstatSync(path, { throwIfNoEntry: false }) === undefined) return;
  try {
    unlinkSync(path);
  } catch (error) {
    if (systemCode(error) !== 'ENOENT') throw storeError(path, error);
  }
}

/**
 * Size of a plain file; a link has none. Synchronous, since a worker thread would cost more than
 * the query.
 */
function measureSize(path: string): number | undefined {
  const found = lstatSync(path, { throwIfNoEntry: false });
  return found?.isFile() === true ? found.size : undefined;
}

function statePath(partial: string): string {
  return `${partial}.json`;
}

/** Ref: RFC 9110 section 13.1.5: a weak ETag may not be used in If-Range. */
function readValidator(response: HttpResponse): string | undefined {
  const etag = response.header('etag');
  if (etag !== undefined && /^"[\x21\x23-\x7e\x80-\xff]*"$/.test(etag)) return etag;
  const date = response.header('last-modified');
  return date !== undefined && !Number.isNaN(Date.parse(date)) ? date : undefined;
}
