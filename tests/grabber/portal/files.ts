import { createReadStream } from 'node:fs';
import { readFile, stat } from 'node:fs/promises';
import type { IncomingMessage, ServerResponse } from 'node:http';
import { join, normalize } from 'node:path';
import { Readable } from 'node:stream';
import { setTimeout as delay } from 'node:timers/promises';
import { gzipSync } from 'node:zlib';
import { drawFault, type Fault } from './faults.js';
import { toUrl, type PortalContext, type PortalHandler } from './portal.js';

const kTrickle_bytes_per_s = 20_000;
const kPiece_bytes = 64 * 1024;

/** Files below the root. */
export const fileHandler: PortalHandler = async (request, response, context) => {
  const { pathname, searchParams } = toUrl(request);
  const inside = normalize(decodeURIComponent(pathname));
  if (inside.includes('..')) return false;
  return sendPortalFile(
    inside.slice(1),
    pathname,
    searchParams.has('direct'),
    request,
    response,
    context,
  );
};

/**
 * Sends one file of the root, with the portal's faults.
 * @return false when it is not there
 */
export async function sendPortalFile(
  relative: string,
  shownPath: string,
  direct: boolean,
  request: IncomingMessage,
  response: ServerResponse,
  context: PortalContext,
): Promise<boolean> {
  const path = join(context.root, relative);
  const found = await stat(path).catch(() => undefined);
  if (found === undefined || !found.isFile()) return false;
  const stats = context.stats.of(shownPath);
  ++stats.requests;
  const head = request.method === 'HEAD';
  const fault = direct || head ? undefined : drawFault(context.faults, context.random);
  if (fault !== undefined) ++stats.faults;
  if (answerWithoutFile(fault, shownPath, response, context)) return true;

  const version = `${found.size.toString(16)}-${Math.round(found.mtimeMs).toString(16)}`;
  const etag = fault === 'etag' ? `"${version}-other"` : `"${version}"`;
  const start = fault === 'norange' ? 0 : rangeStart(request, etag, found.mtime, found.size);
  const headers: Record<string, string> = {
    etag,
    'last-modified': found.mtime.toUTCString(),
    'accept-ranges': 'bytes',
  };
  if (start === undefined) {
    response.writeHead(416, { 'content-range': `bytes */${found.size}` }).end();
    return true;
  }
  if (fault === 'gzip') {
    const body = gzipSync(await readFile(path), { level: 1 });
    response
      .writeHead(200, {
        ...headers,
        'content-encoding': 'gzip',
        'content-length': String(body.length),
      })
      .end(body);
    stats.bytes += body.length;
    ++stats.whole;
    return true;
  }
  let end = found.size;
  if (fault === 'short' || fault === 'reset' || fault === 'stall') {
    end = start + Math.floor((end - start) * context.random());
  }
  if (fault !== 'nolength') {
    const announced =
      fault === 'short' ? end - start : found.size - start + (fault === 'long' ? 100 : 0);
    headers['content-length'] = String(announced);
  }
  if (start > 0) headers['content-range'] = `bytes ${start}-${found.size - 1}/${found.size}`;
  response.writeHead(start > 0 ? 206 : 200, headers);
  if (head) response.end();
  else await sendBody(path, start, end, found.size, fault, response, context, shownPath);
  return true;
}

function answerWithoutFile(
  fault: Fault | undefined,
  path: string,
  response: ServerResponse,
  context: PortalContext,
): boolean {
  const retry = { 'retry-after': String(context.retry_after_s) };
  if (fault === '500') response.writeHead(500).end();
  else if (fault === '503' || fault === '429') response.writeHead(Number(fault), retry).end();
  else if (fault === 'html') {
    response
      .writeHead(200, { 'content-type': 'text/html' })
      .end('<html><title>Under repair</title></html>');
  } else if (fault === 'redirect') response.writeHead(302, { location: `${path}?direct=1` }).end();
  else if (fault === 'foreign') {
    response.writeHead(302, { location: `http://elsewhere.example${path}` }).end();
  } else return false;
  return true;
}

/** @return where to begin; 0 = the whole file, undefined = the range cannot be satisfied */
function rangeStart(
  request: IncomingMessage,
  etag: string,
  date: Date,
  size: number,
): number | undefined {
  const match = /^bytes=(\d+)-\d*$/.exec(request.headers.range ?? '');
  if (match === null) return 0;
  const condition = request.headers['if-range'];
  if (condition !== undefined && condition !== etag && condition !== date.toUTCString()) return 0;
  return Number(match[1]) < size ? Number(match[1]) : undefined;
}

async function sendBody(
  path: string,
  start: number,
  end: number,
  size: number,
  fault: Fault | undefined,
  response: ServerResponse,
  context: PortalContext,
  shownPath: string,
): Promise<void> {
  const stats = context.stats.of(shownPath);
  const rate = fault === 'slow' ? kTrickle_bytes_per_s : context.rate_bytes_per_s;
  if (end > start) {
    const chunks = createReadStream(path, {
      start,
      end: end - 1,
      highWaterMark: rate === undefined ? 1024 * 1024 : kPiece_bytes,
    });
    const paced =
      rate === undefined ? chunks : Readable.from(pace(chunks, rate), { objectMode: false });
    for await (const chunk of paced as AsyncIterable<Buffer>) {
      if (response.destroyed) return;
      stats.bytes += chunk.length;
      if (!response.write(chunk)) await drained(response);
    }
  }
  if (fault === 'stall') return;
  if (fault === 'reset' || fault === 'long') {
    // What was written should arrive before the connection breaks.
    setTimeout(() => response.destroy(), 20);
    return;
  }
  response.end();
  if (start === 0 && end === size) ++stats.whole;
}

async function* pace(
  chunks: AsyncIterable<Buffer>,
  rate_bytes_per_s: number,
): AsyncGenerator<Buffer> {
  for await (const chunk of chunks) {
    await delay((chunk.length * 1000) / rate_bytes_per_s);
    yield chunk;
  }
}

/** Resolves when there is room again, or the connection is closed. */
function drained(response: ServerResponse): Promise<void> {
  return new Promise((resolve) => {
    const done = (): void => {
      response.off('drain', done).off('close', done);
      resolve();
    };
    response.on('drain', done).on('close', done);
  });
}
