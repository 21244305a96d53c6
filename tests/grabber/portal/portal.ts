import { createServer, type IncomingMessage, type ServerResponse } from 'node:http';
import type { AddressInfo } from 'node:net';
import { setTimeout as delay } from 'node:timers/promises';
import { promisify } from 'node:util';
import { arsoHandler, scanSquares, type PortalSquare } from './squares.js';
import { type FaultChances, PortalStats } from './faults.js';
import { fileHandler } from './files.js';
import { seededRandom } from './pattern.js';
import { stacHandler } from './stac.js';
import { wfsHandler } from './wfs.js';

export type PortalOptions = {
  /** Folder of files; point clouds with E_N in their name become squares of the catalogues. */
  readonly root: string;
  /** 0 = any free one. */
  readonly port?: number;
  readonly faults?: FaultChances;
  readonly seed?: number;
  /** Of one body, undefined = as fast as it goes. */
  readonly rate_bytes_per_s?: number;
  /** Seconds in Retry-After of 429 and 503. */
  readonly retry_after_s?: number;
  /** Of the squares, for the catalogues. */
  readonly crs?: string;
  readonly handlers?: readonly PortalHandler[];
};

/** What a handler may use. */
export type PortalContext = {
  readonly root: string;
  /** Without a slash at its end. */
  readonly base: string;
  readonly crs: string;
  readonly squares: readonly PortalSquare[];
  readonly faults: FaultChances;
  readonly random: () => number;
  readonly rate_bytes_per_s: number | undefined;
  readonly retry_after_s: number;
  readonly stats: PortalStats;
};

/** @return whether it answered the request; else the next handler is tried */
export type PortalHandler = (
  request: IncomingMessage,
  response: ServerResponse,
  context: PortalContext,
) => boolean | Promise<boolean>;

export type Portal = {
  readonly base: string;
  readonly context: PortalContext;
  close(): Promise<void>;
  idle(): Promise<void>;
};

/**
 * A small open-data portal on this machine: files, folder listings, STAC and WFS over the same
 * squares.
 */
export async function startPortal(options: PortalOptions): Promise<Portal> {
  const handlers = [
    statsHandler,
    ...(options.handlers ?? []),
    stacHandler,
    wfsHandler,
    arsoHandler,
    fileHandler,
  ];
  const squares = await scanSquares(options.root);
  const server = createServer();
  await new Promise<void>((resolve, reject) => {
    server.once('error', reject);
    server.listen(options.port ?? 0, '127.0.0.1', resolve);
  });
  const context: PortalContext = {
    root: options.root,
    base: `http://127.0.0.1:${(server.address() as AddressInfo).port}`,
    crs: options.crs ?? 'EPSG:3794',
    squares,
    faults: options.faults ?? new Map(),
    random: seededRandom(options.seed ?? 1),
    rate_bytes_per_s: options.rate_bytes_per_s,
    retry_after_s: options.retry_after_s ?? 1,
    stats: new PortalStats(),
  };
  server.on('request', (request, response) => {
    answer(handlers, request, response, context).catch((error: unknown) => {
      if (!response.headersSent) response.writeHead(500).end(String(error));
      else response.destroy();
    });
  });
  const close = async (): Promise<void> => {
    server.closeAllConnections();
    await new Promise((resolve) => server.close(resolve));
  };
  // Where a client has died, what it left is seen and counted by then.
  const idle = async (): Promise<void> => {
    const connections = promisify(server.getConnections.bind(server));
    while ((await connections()) > 0) await delay(10);
  };
  return { base: context.base, context, close, idle };
}

async function answer(
  handlers: readonly PortalHandler[],
  request: IncomingMessage,
  response: ServerResponse,
  context: PortalContext,
): Promise<void> {
  for (const handler of handlers) {
    if (await handler(request, response, context)) return;
  }
  response
    .writeHead(404, { 'content-type': 'text/html' })
    .end('<html><title>Not found</title></html>');
}

export function toUrl(request: IncomingMessage): URL {
  return new URL(request.url ?? '/', 'http://portal');
}

export function sendJson(
  response: ServerResponse,
  value: unknown,
  type = 'application/json',
): void {
  const body = Buffer.from(JSON.stringify(value));
  response
    .writeHead(200, { 'content-type': type, 'content-length': String(body.length) })
    .end(body);
}

const statsHandler: PortalHandler = (request, response, context) => {
  const { pathname } = toUrl(request);
  if (pathname !== '/stats' && pathname !== '/stats/reset') return false;
  if (pathname === '/stats/reset') context.stats.reset();
  sendJson(response, context.stats);
  return true;
};
