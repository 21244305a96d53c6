import assert from 'node:assert/strict';
import type { TestContext } from 'node:test';
import {
  createHttpClient,
  kNoAccess,
  type Access,
  type HttpClientOptions,
  type SourceClient,
} from '../../../grabber/src/fetch/http-client.js';
import type { CatalogueSquare, Catalogue, Region } from '../../../grabber/src/model/store.js';
import { openCatalogue } from '../../../grabber/src/sources/catalogue/open-catalogue.js';
import type { CatalogueOptions } from '../../../grabber/src/sources/catalogue/listing.js';
import { parseSource, type Source } from '../../../grabber/src/sources/source.js';
import { fakeClock } from './store-fixture.js';
import { kHere } from './http-fixture.js';

const kNever = new AbortController().signal;

/** A source named "here" of D96/TM kilometre squares, with this [access]. */
export function sourceWith(access: string, head = 'square_m = 1000', crs = 'EPSG:3794'): Source {
  return parseSource(
    `
id = "here"
title = "Here"
licence = "CC0"
attribution = "Us"
crs = "${crs}"
${head}
extent_m = [370000, 25000, 630000, 200000]
class_table = "asprs"
max_concurrent = 4
missing_status = [404]
${access}
`,
    'here.toml',
  );
}

/** Requests without waits between the tries. */
export function makeCatalogue(
  t: TestContext,
  source: Source,
  options: CatalogueOptions = {},
): Catalogue {
  return openCatalogue(source, clientFor(t), {
    policy: { retries: 2, base_ms: 1, cap_ms: 1, max_wait_ms: 60_000 },
    clock: fakeClock(),
    ...options,
  });
}

/** A client that may contact servers of this machine, closed when the test ends. */
export function clientFor(
  t: TestContext,
  access: Partial<Access> = kHere,
  more: Partial<HttpClientOptions> = {},
): SourceClient {
  const http = createHttpClient({
    userAgent: 'terravox-grabber/test',
    timeout_ms: 20_000,
    access: { ...kNoAccess, ...access },
    ...more,
  });
  t.after(() => http.close());
  return http;
}

export async function found(
  catalogue: Catalogue,
  region: Region,
  signal: AbortSignal = kNever,
): Promise<CatalogueSquare[]> {
  const squares: CatalogueSquare[] = [];
  for await (const square of catalogue.find(region, signal)) squares.push(square);
  return squares;
}

/** Lists squares, which must end in an error of the catalogue. */
export async function refused(
  catalogue: Catalogue,
  region: Region,
  message: RegExp,
  code = 'CATALOGUE',
): Promise<void> {
  await assert.rejects(found(catalogue, region), { code, message });
}

export async function foundNames(catalogue: Catalogue, region: Region): Promise<string[]> {
  return (await found(catalogue, region)).map(({ name }) => name);
}
