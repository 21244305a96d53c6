import type { HttpResponse } from '../../../../grabber/src/fetch/http-client.js';

export function makeResponse(
  status: number,
  values: Readonly<Record<string, string>>,
  body: Uint8Array = Buffer.alloc(0),
): HttpResponse {
  async function* once(): AsyncGenerator<Uint8Array> {
    yield await Promise.resolve(body);
  }
  return { status, header: (name) => values[name], body: once(), discard: () => Promise.resolve() };
}
