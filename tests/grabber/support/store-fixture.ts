import { mkdtemp, readdir, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { TestContext } from 'node:test';
import type { FetchContext } from '../../../grabber/src/fetch/fetch-square.js';
import { HostGate } from '../../../grabber/src/fetch/host-gate.js';
import { createHttpClient, type HttpClient } from '../../../grabber/src/fetch/http-client.js';
import { remoteOrigin } from '../../../grabber/src/fetch/remote-origin.js';
import type { SourceProfile } from '../../../grabber/src/sources/profile.js';
import { squareAt } from '../../../grabber/src/sources/square.js';
import { expandTemplate } from '../../../grabber/src/sources/url-template.js';
import { storeLayout } from '../../../grabber/src/store/layout.js';
import { Manifest } from '../../../grabber/src/store/manifest.js';
import { fakeClock, type FakeClock } from './fake-clock.js';

export const kNever = new AbortController().signal;
export const kSquare = squareAt(462_000, 101_000);

export async function temporaryFolder(t: TestContext): Promise<string> {
  const folder = await mkdtemp(join(tmpdir(), 'terravox-grabber-'));
  t.after(() => rm(folder, { recursive: true, force: true }));
  return folder;
}

export const kProfile: SourceProfile = {
  id: 'test',
  configured: true,
  crs: 'EPSG:3794',
  class_table: 'asprs',
  licence: 'CC BY 4.0',
  attribution: 'Somebody',
  square_m: 1000,
  missing_status: [404],
  max_concurrent: 4,
};

export type Fixture = FetchContext & { readonly clock: FakeClock; readonly retries: string[] };

export type FixtureOptions = {
  retries?: number;
  profile?: Partial<SourceProfile>;
  root?: string;
  refetch?: boolean;
  maxWaitMs?: number;
  template?: string;
  onStored?: (bytes: number) => void;
};

/** Tells how many bytes of a body the reader has taken and dealt with. */
function watched(http: HttpClient, onStored: (bytes: number) => void): HttpClient {
  async function* watch(body: AsyncIterable<Uint8Array>): AsyncGenerator<Uint8Array> {
    let bytes = 0;
    for await (const chunk of body) {
      yield chunk;
      bytes += chunk.length;
      onStored(bytes);
    }
  }
  return {
    get: async (url, headers, signal) => {
      const response = await http.get(url, headers, signal);
      return { ...response, body: watch(response.body) };
    },
    close: () => http.close(),
  };
}

/** All that a fetch from `base` needs, in a store of its own, with a clock that does not wait. */
export async function fetchFixture(t: TestContext, base: string, options: FixtureOptions = {}): Promise<Fixture> {
  const store = storeLayout(options.root ?? (await temporaryFolder(t)));
  const profile = { ...kProfile, ...options.profile };
  const clock = fakeClock();
  const http = watched(
    createHttpClient({ userAgent: 'terravox-grabber/test', timeout_ms: 20_000 }),
    options.onStored ?? (() => undefined),
  );
  t.after(() => http.close());
  const template = options.template ?? `${base}/TM_{E}_{N}.laz`;
  const retries: string[] = [];
  return {
    profile,
    store,
    clock,
    retries,
    manifest: await Manifest.open(store.manifest, kNever),
    origin: remoteOrigin({
      urlOf: (square) => expandTemplate(template, square, {}),
      missingStatus: profile.missing_status,
      http,
      gate: new HostGate(clock, options.maxWaitMs ?? 600_000),
      clock,
    }),
    policy: { retries: options.retries ?? 3, base_ms: 1000, cap_ms: 60_000 },
    refetch: options.refetch ?? false,
    onRetry: (_square, notice) => retries.push(notice.error.code),
  };
}

/** Names of all files in a store, relative and sorted, without the manifest. */
export async function storedFiles(root: string): Promise<string[]> {
  const names = await readdir(root, { recursive: true, withFileTypes: true });
  return names
    .filter((entry) => entry.isFile() && entry.name !== 'manifest.json')
    .map((entry) =>
      join(entry.parentPath, entry.name)
        .slice(root.length + 1)
        .replaceAll('\\', '/'),
    )
    .sort();
}
