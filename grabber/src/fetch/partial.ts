import { readFile } from 'node:fs/promises';
import { z } from 'zod';
import { fileSize, removeIfThere, writeFileAtomically } from '../util/files.js';
import type { HttpResponse } from './http-client.js';

/** What must be known to continue an unfinished file; lies beside it as JSON. */
const stateSchema = z.strictObject({
  url: z.string(),
  /** A strong ETag or a Last-Modified date: the server sends the rest only if the file is still this one. */
  if_range: z.string().min(1),
  total_bytes: z.int().min(1).nullable(),
});

export type PartialState = z.infer<typeof stateSchema>;
export type Resumable = PartialState & { readonly offset_bytes: number };

function statePath(partial: string): string {
  return `${partial}.json`;
}

/** @return undefined when there is nothing that can be continued safely, and the file must be fetched from its start */
export async function findResumable(partial: string, url: string, signal: AbortSignal): Promise<Resumable | undefined> {
  const offset_bytes = await fileSize(partial);
  if (offset_bytes === undefined || offset_bytes === 0) return undefined;
  if ((await fileSize(statePath(partial))) === undefined) return undefined;
  const state = parseState(await readFile(statePath(partial), { encoding: 'utf8', signal }));
  if (state === undefined || state.url !== url) return undefined;
  if (state.total_bytes !== null && offset_bytes >= state.total_bytes) return undefined;
  return { ...state, offset_bytes };
}

/** Remembers what the server said of the file, or forgets it when the server said nothing that identifies it. */
export async function rememberState(
  partial: string,
  url: string,
  response: HttpResponse,
  total_bytes: number | undefined,
  signal: AbortSignal,
): Promise<void> {
  const if_range = validatorOf(response);
  if (if_range === undefined) return removeIfThere(statePath(partial));
  const state: PartialState = { url, if_range, total_bytes: total_bytes ?? null };
  await writeFileAtomically(statePath(partial), JSON.stringify(state), signal);
}

export async function removePartial(partial: string): Promise<void> {
  await removeIfThere(statePath(partial));
  await removeIfThere(partial);
}

/** Ref: RFC 9110 section 13.1.5: a weak ETag may not be used in If-Range. */
function validatorOf(response: HttpResponse): string | undefined {
  const etag = response.header('etag');
  if (etag !== undefined && etag.startsWith('"')) return etag;
  return response.header('last-modified');
}

/** A state file cut by a crash only costs a fetch from the start. */
function parseState(text: string): PartialState | undefined {
  try {
    return stateSchema.safeParse(JSON.parse(text)).data;
  } catch {
    return undefined;
  }
}
