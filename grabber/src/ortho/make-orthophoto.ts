import { mkdir, rename } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { flushFile, withWorkFolder } from '../convert/work-folder.js';
import { findProjection } from '../geo/crs.js';
import {
  findGround,
  type ImageFacts,
  type RecordKey,
  type StoredFile,
  type StoreRecord,
  type Terms,
  type Store,
} from '../model/store.js';
import { GrabberError } from '../util/errors.js';
import { fileSize, sha256OfFile } from '../util/files.js';
import { cutOrthophoto, type CutOptions } from './cut.js';
import { type Downloader, AssetCache } from './download.js';
import { openGdal } from './gdal.js';
import type { Gather } from './piece.js';
import { makeTarget } from './target.js';
import type { OrthoSource } from './schema.js';
import { stacGather } from './stac.js';
import { templateGather } from './template.js';
import { wmsGather } from './wms.js';
import { wmtsGather } from './wmts.js';
import { kPlaces } from '../store/layout.js';

/** What pictures are made of, and how; one for a run. */
export type OrthoSettings = {
  readonly source: string;
  readonly terms: Omit<Terms, 'crs' | 'classTable'>;
  readonly gather: Gather;
  readonly download: Downloader;
  readonly concurrency: number;
  readonly time: string | undefined;
  readonly resolution_m: number;
  readonly margin_m: number;
  readonly cut: CutOptions;
  /** Of files that several squares need; inside the store. */
  readonly cache: string;
};

export type Made =
  | {
      readonly state: 'made';
      readonly file: StoredFile;
      readonly image: ImageFacts;
      readonly warnings: readonly string[];
    }
  | { readonly state: 'missing'; readonly reason: string };

/** The key of the orthophoto of a LiDAR square. */
export function orthoKey(source: string, square: StoreRecord): RecordKey {
  return { source, grid: square.key.source, name: square.key.name };
}

/**
 * Adds the rows of orthophotos to the store, so that they can be worked on. The date of a picture
 * is recorded once it is made: before, it would be wrong for the picture that is there.
 */
export function learnOrthophotos(
  store: Store,
  settings: OrthoSettings,
  squares: readonly StoreRecord[],
): void {
  for (const square of squares) {
    learnOne(
      store,
      settings,
      square,
      store.orthophotos.get(orthoKey(settings.source, square))?.published ?? null,
    );
  }
}

function learnOne(
  store: Store,
  { source, terms }: OrthoSettings,
  square: StoreRecord,
  published: string | null,
): void {
  const { key } = square;
  const ground = findGround(square);
  const crs = ground?.crs ?? null;
  const row = {
    name: key.name,
    block: null,
    bounds: ground?.bounds ?? null,
    urls: [],
    bytes: null,
    sha256: null,
    member: null,
    published,
  };
  store.orthophotos.learn(source, key.source, crs, { crs, classTable: null, ...terms }, [row]);
}

/** Whether a picture is there that matches the current request. */
export async function isMade(
  record: StoreRecord,
  store: Store,
  settings: OrthoSettings,
): Promise<boolean> {
  const { file, image } = record;
  if (
    file === null ||
    image === null ||
    (record.state !== 'verified' && record.state !== 'converted')
  ) {
    return false;
  }
  const same =
    image.resolution_m === settings.resolution_m &&
    image.margin_m === settings.margin_m &&
    record.published === (settings.time ?? null);
  return same && (await fileSize(join(store.root, file.path))) === file.bytes;
}

/**
 * Gathers the pictures of one square, cuts them, and puts the result in its place: checked,
 * flushed, renamed, recorded, in this order. A picture that was there before stays until it is
 * replaced.
 */
export async function makeOrthophoto(
  square: StoreRecord,
  store: Store,
  settings: OrthoSettings,
  signal: AbortSignal,
): Promise<Made> {
  const key = orthoKey(settings.source, square);
  const ground = findGround(square);
  if (ground === undefined) {
    throw new GrabberError(
      'ORTHO',
      `cut an orthophoto of ${key.grid}/${key.name}: its place or CRS is not known; allowed: ` +
        'squares of a grid, and fetched ones whose CRS is in their file or was given (fetch --crs)',
    );
  }
  // That of a grid is in metres, as pixels are; a file's own may be in degrees, and is refused.
  if (square.bounds === null) findProjection(ground.crs);
  const target = makeTarget(ground.bounds, ground.crs, settings.resolution_m, settings.margin_m);
  return withWorkFolder(store.root, async (folder) => {
    const gdal = await openGdal(folder, signal);
    const { download, time, concurrency, cache } = settings;
    const gathered = await settings.gather(
      target,
      { folder, cache, gdal, download, time, concurrency },
      signal,
    );
    if (gathered === undefined) {
      const reason = `${settings.source} has no pictures of ${key.grid}/${key.name}`;
      store.orthophotos.missing(key, reason);
      return { state: 'missing', reason };
    }
    store.orthophotos.begin(key, gathered.url);
    const cut = await cutOrthophoto(gathered, target, settings.cut, gdal, folder, signal);
    const path = kPlaces.finished('ortho', key, 'tif');
    const file = {
      path,
      bytes: (await fileSize(cut.path)) ?? 0,
      sha256: await sha256OfFile(cut.path, signal),
    };
    await flushFile(cut.path);
    await mkdir(dirname(join(store.root, path)), { recursive: true });
    await rename(cut.path, join(store.root, path));
    const { width_px, height_px } = target;
    const image = {
      width_px,
      height_px,
      resolution_m: settings.resolution_m,
      margin_m: settings.margin_m,
    };
    const warnings = [...gathered.warnings, ...cut.warnings];
    learnOne(store, settings, square, settings.time ?? null);
    store.orthophotos.fetched(key, file);
    store.orthophotos.verified(key, { points: null, image, crs: ground.crs, warnings });
    return { state: 'made', file, image, warnings };
  });
}

/** How pictures of a source are gathered, and the whole files that it keeps meanwhile. */
export function gatherFor(
  source: OrthoSource,
  cacheFolder: string,
): { readonly gather: Gather; readonly cache: AssetCache } {
  const cache = new AssetCache(cacheFolder);
  const { access } = source;
  switch (access.kind) {
    case 'wms':
      return { gather: wmsGather(source, access), cache };
    case 'wmts':
      return { gather: wmtsGather(source, access), cache };
    case 'stac':
      return { gather: stacGather(source, access, cache), cache };
    case 'template':
      return { gather: templateGather(source, access, cache), cache };
  }
}
