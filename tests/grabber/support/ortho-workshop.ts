import { execFile } from 'node:child_process';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import type { TestContext } from 'node:test';
import { promisify } from 'node:util';
import type { StoreRecord, Store } from '../../../grabber/src/model/store.js';
import { DiskSpace } from '../../../grabber/src/fetch/disk-space.js';
import { HostRateLimiter } from '../../../grabber/src/fetch/host-queues.js';
import { downloader } from '../../../grabber/src/ortho/download.js';
import {
  gatherFor,
  learnOrthophotos,
  makeOrthophoto,
  orthoKey,
  type Made,
  type OrthoSettings,
} from '../../../grabber/src/ortho/make-orthophoto.js';
import type { Gather } from '../../../grabber/src/ortho/piece.js';
import { orthoSchema, type OrthoSource } from '../../../grabber/src/ortho/schema.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { patternAt } from '../portal/pattern.js';
import { fakeClock, kNever, makeSquare, temporaryFolder } from './store-fixture.js';
import { clientFor } from './catalogue-fixture.js';

const run = promisify(execFile);

export const kBounds = [462_000, 101_000, 462_100, 101_100] as const;
export const kCrs = 'EPSG:3794';

export function orthoSource(
  access: Record<string, unknown>,
  more: Record<string, unknown> = {},
): OrthoSource {
  const words = {
    id: 'here',
    title: 'Here',
    licence: 'CC BY 4.0',
    attribution: 'Us',
    crs: kCrs,
    resolution_m: 0.5,
    missing_status: [404],
    ...more,
  };
  return orthoSchema.parse({ ...words, access });
}

export type Bench = {
  readonly store: Store;
  readonly square: StoreRecord;
  make(change?: Partial<OrthoSettings>): Promise<Made>;
  row(): StoreRecord;
};

/** A store with one square, and all that is needed to make its orthophoto. */
export async function bench(
  t: TestContext,
  source: OrthoSource,
  bounds: readonly [number, number, number, number] = kBounds,
  crs = kCrs,
  gather?: Gather,
): Promise<Bench> {
  const store = openStore(await temporaryFolder(t), {}, kNever);
  const terms = { crs, classTable: null, licence: null, attribution: null };
  store.squares.learn('lidar', 'lidar', crs, terms, [makeSquare('462_101', [], { bounds })]);
  const square = store.squares.list({})[0];
  if (square === undefined) throw new Error('no square');
  const http = clientFor(t);
  const cache = await temporaryFolder(t);
  const settings: OrthoSettings = {
    source: source.id,
    terms: { licence: source.licence, attribution: source.attribution },
    gather: gather ?? gatherFor(source, cache).gather,
    download: downloader({
      http,
      policy: { retries: 2, base_ms: 1, cap_ms: 1, max_wait_ms: 60_000 },
      clock: fakeClock(),
      limiter: new HostRateLimiter(fakeClock(), 60_000),
      disk: new DiskSpace(cache),
      missingStatus: source.missing_status,
      onRetry: () => undefined,
    }),
    concurrency: 2,
    time: undefined,
    resolution_m: source.resolution_m,
    margin_m: 20,
    cut: { lossless: true, nearInfrared: false },
    cache,
  };
  return {
    store,
    square,
    make(change = {}) {
      const changed = { ...settings, ...change };
      learnOrthophotos(store, changed, [square]);
      return makeOrthophoto(square, store, changed, kNever);
    },
    row() {
      const row = store.orthophotos.get(orthoKey(source.id, square));
      if (row === undefined) throw new Error('no row');
      return row;
    },
  };
}

export type Picture = {
  readonly width: number;
  readonly height: number;
  readonly bounds: readonly number[];
  readonly info: GdalInfo;
  at(x: number, y: number): number[];
};
type GdalInfo = {
  size: [number, number];
  geoTransform: [number, number, number, number, number, number];
  coordinateSystem: { wkt: string };
  metadata: Record<string, Record<string, string>>;
  bands: {
    block: [number, number];
    overviews?: { size: [number, number] }[];
    mask?: { flags: string[] };
    colorInterpretation: string;
  }[];
};

/** Reads a GeoTIFF with GDAL as others have it, without any of our settings. */
export async function readPicture(path: string, folder: string): Promise<Picture> {
  const raw = join(folder, 'read.ppm');
  const { stdout } = await run('gdalinfo', ['-json', path]);
  const info = JSON.parse(stdout) as GdalInfo;
  await run('gdal_translate', ['-q', '-of', 'PNM', '-b', '1', '-b', '2', '-b', '3', path, raw]);
  const bytes = await readFile(raw);
  const [width, height] = info.size;
  const pixels = bytes.subarray(bytes.length - width * height * 3);
  const [left, step_x, , top, , step_y] = info.geoTransform;
  return {
    width,
    height,
    bounds: [left, top + height * step_y, left + width * step_x, top],
    info,
    at: (x, y) => [...pixels.subarray((y * width + x) * 3, (y * width + x) * 3 + 3)],
  };
}

export const readOrthophoto = (at: Bench): Promise<Picture> =>
  readPicture(join(at.store.root, 'ortho/here/lidar/462_101.tif'), at.store.root);

/** Pixels that are not what the synthetic picture has there; the first of them as text. */
export function wrongPixels(
  picture: Picture,
  skip: (easting: number, northing: number) => boolean = () => false,
): { count: number; first: string } {
  const [west = 0, , , north = 0] = picture.bounds;
  const step = ((picture.bounds[2] ?? 0) - west) / picture.width;
  let count = 0;
  let first = '';
  for (let y = 0; y < picture.height; ++y) {
    for (let x = 0; x < picture.width; ++x) {
      const [easting, northing] = [west + (x + 0.5) * step, north - (y + 0.5) * step];
      if (skip(easting, northing)) continue;
      const [wanted, found] = [patternAt(easting, northing).join(), picture.at(x, y).join()];
      if (wanted === found) continue;
      count += 1;
      if (count === 1) first = `pixel ${x}, ${y}: ${found}; wanted ${wanted}`;
    }
  }
  return { count, first };
}
