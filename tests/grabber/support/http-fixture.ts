import { createServer, type IncomingMessage, type ServerResponse } from 'node:http';
import type { AddressInfo } from 'node:net';
import type { TestContext } from 'node:test';

/** Port 1 is reserved, and no server listens on it. */
export const kNoListener = 'http://127.0.0.1:1';
const kServed = [kNoListener];

/** What a client needs to talk to kNoListener and to all servers that serve() has started. */
export const kHere = {
  hosts: ['127.0.0.1'],
  privateOrigins: kServed,
  secretHeaders: {},
  secretOrigins: [],
} as const;

export type Seen = { readonly path: string; readonly headers: IncomingMessage['headers'] };
export type Handler = (request: IncomingMessage, response: ServerResponse, index: number) => void;

export type HttpFixture = {
  /** Without a slash at its end. */
  readonly base: string;
  readonly seen: Seen[];
  /** Breaks the connections of all answers that sendPart left open. */
  cut(): void;
};

const kOpenParts = new Set<ServerResponse>();

/**
 * A web server on a free port of this machine, closed when the test ends. `index` counts requests
 * from 0.
 */
export async function serve(t: TestContext, handler: Handler): Promise<HttpFixture> {
  const seen: Seen[] = [];
  const server = createServer((request, response) => {
    seen.push({ path: request.url ?? '', headers: request.headers });
    handler(request, response, seen.length - 1);
  });
  await new Promise<void>((resolve) => server.listen(0, '127.0.0.1', resolve));
  t.after(async () => {
    server.closeAllConnections();
    await new Promise((resolve) => server.close(resolve));
  });
  const cut = (): void => {
    for (const response of kOpenParts) response.destroy();
    kOpenParts.clear();
  };
  const base = `http://127.0.0.1:${(server.address() as AddressInfo).port}`;
  kServed.push(base);
  return { base, seen, cut };
}

export function sendFile(
  response: ServerResponse,
  body: Buffer,
  headers: Record<string, string> = {},
): void {
  response.writeHead(200, { 'content-length': String(body.length), ...headers });
  response.end(body);
}

export function sendStatus(
  response: ServerResponse,
  status: number,
  headers: Record<string, string> = {},
): void {
  response.writeHead(status, headers);
  response.end();
}

/**
 * Announces the whole body and sends its first part only, until the test calls cut(). Cutting by
 * itself would race the client: what it has received but not yet read is lost with the connection.
 */
export function sendPart(
  response: ServerResponse,
  body: Buffer,
  sentBytes: number,
  headers: Record<string, string> = {},
): void {
  kOpenParts.add(response);
  response.writeHead(200, { 'content-length': String(body.length), ...headers });
  response.write(body.subarray(0, sentBytes));
}

/** Answers `Range: bytes=N-` as RFC 9110 requires, for a file with this ETag. */
export function sendRest(
  request: IncomingMessage,
  response: ServerResponse,
  body: Buffer,
  etag: string,
): void {
  const start = Number(/^bytes=(\d+)-$/.exec(request.headers.range ?? '')?.[1] ?? 0);
  if (start === 0 || request.headers['if-range'] !== etag) {
    return sendFile(response, body, { etag });
  }
  response.writeHead(206, {
    etag,
    'content-length': String(body.length - start),
    'content-range': `bytes ${start}-${body.length - 1}/${body.length}`,
  });
  response.end(body.subarray(start));
}
