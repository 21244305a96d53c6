import { rename } from 'node:fs/promises';
import { join } from 'node:path';
import { XMLParser } from 'fast-xml-parser';
import { z } from 'zod';
import { GrabberError } from '../util/errors.js';
import { runAll } from './download.js';
import { writeWorldFile } from './gdal.js';
import { probeImage, requireSize, type Gather, type GatherContext, type Piece } from './piece.js';
import { boundsIn, boundsOfBlock, type Target } from './target.js';
import type { OrthoSource, WmtsAccess } from './schema.js';
import type { BoundsM } from '../model/store.js';

const kMaxCapabilities_bytes = 32 << 20;
const kMaxTile_bytes = 8 << 20;

/**
 * Joins the tiles of the matrix that is as fine as wanted. The capabilities of the service are
 * requested once.
 */
export function wmtsGather(source: OrthoSource, access: WmtsAccess): Gather {
  let service: Promise<TileService> | undefined;
  return async (target, context, signal) => {
    service ??= readService(source, access, context, signal);
    const found = await service.catch((error: unknown) => {
      service = undefined;
      throw error;
    });
    const { bounds, stretch } = await boundsIn(target, found.crs, context.gdal, signal);
    const matrix = chooseMatrix(found.matrices, target.resolution_m * stretch);
    const range = matrix && tilesIn(matrix, bounds);
    if (matrix === undefined || range === undefined) return undefined;
    const grid = gridOfTiles(matrix, range, found.crs);
    const pieces = await fetchTiles(access, found, matrix, grid, range, context, signal);
    if (pieces.found.length === 0) return undefined;
    return {
      pieces: pieces.found,
      url: access.url,
      grid,
      resolution_m: matrix.resolution_m / stretch,
      date: context.time,
      warnings:
        pieces.holes === 0
          ? []
          : [`${pieces.holes} of ${range.columns * range.rows} tiles of ${source.id} are missing`],
    };
  };
}

async function readService(
  source: OrthoSource,
  access: WmtsAccess,
  context: GatherContext,
  signal: AbortSignal,
): Promise<TileService> {
  if (access.matrices !== undefined) {
    return { crs: source.crs, matrices: access.matrices, template: access.url, kvp: access.url };
  }
  const xml = await context.download.text(access.url, kMaxCapabilities_bytes, signal);
  if (xml === undefined || access.layer === undefined) {
    throw new GrabberError(
      'MAP_SERVICE',
      `read the tile service ${access.url}: ` +
        `${xml === undefined ? 'it is not there' : 'no layer is configured'}; allowed: ` +
        'capabilities, and access.layer',
    );
  }
  return parseCapabilities(xml, access.url, {
    layer: access.layer,
    matrixSet: access.matrix_set,
    format: access.format,
    axis: access.axis,
  });
}

async function fetchTiles(
  access: WmtsAccess,
  service: TileService,
  matrix: TileMatrix,
  grid: Target,
  range: { column: number; row: number; columns: number; rows: number },
  context: GatherContext,
  signal: AbortSignal,
): Promise<{ found: Piece[]; holes: number }> {
  const [width_px, height_px] = tileSize(matrix);
  const places = Array.from({ length: range.columns * range.rows }, (_unused, index) => index);
  const pieces = await runAll(
    places.map((index) => async (signal: AbortSignal): Promise<Piece | undefined> => {
      const x = index % range.columns;
      const y = Math.floor(index / range.columns);
      const url = tileUrl(
        access,
        service,
        matrix.id,
        range.column + x,
        range.row + y,
        context.time,
      );
      const raw = join(context.folder, `tile-${y}-${x}.raw`);
      if (!(await context.download.toFile(url, raw, kMaxTile_bytes, signal))) return undefined;
      const probe = await probeImage(raw, url, context.gdal, signal);
      requireSize(probe, width_px, height_px, url);
      const path = join(context.folder, `tile-${y}-${x}.${probe.kind.extension}`);
      await rename(raw, path);
      const block = { x_px: x * width_px, y_px: y * height_px, width_px, height_px };
      await writeWorldFile(path, probe.kind, boundsOfBlock(grid, block), width_px, height_px);
      return { path, kind: probe.kind, channels: probe.channels, crs: service.crs };
    }),
    context.concurrency,
    signal,
  );
  const found = pieces.filter((piece) => piece !== undefined);
  return { found, holes: pieces.length - found.length };
}

export function tileUrl(
  access: WmtsAccess,
  service: TileService,
  matrix: string,
  column: number,
  row: number,
  time: string | undefined,
): string {
  const words: Record<string, string> = {
    tilematrixset: access.matrix_set,
    tilematrix: matrix,
    tilerow: String(row),
    tilecol: String(column),
    layer: access.layer ?? '',
    style: access.style,
    time: time ?? 'default',
    // Short names, for addresses that stand in a configuration.
    matrix_set: access.matrix_set,
    matrix,
    row: String(row),
    column: String(column),
  };
  if (service.template !== undefined) {
    return service.template.replace(/\{([A-Za-z_]+)\}/g, (whole, name: string) => {
      const value = words[name.toLowerCase()];
      if (value !== undefined) return encodeURIComponent(value);
      throw new GrabberError(
        'MAP_SERVICE',
        `fill the tile address ${service.template ?? ''}: ${whole}; allowed: ` +
          `${Object.keys(words).join(', ')}`,
      );
    });
  }
  const url = new URL(service.kvp);
  const query: Record<string, string> = {
    SERVICE: 'WMTS',
    VERSION: '1.0.0',
    REQUEST: 'GetTile',
    LAYER: access.layer ?? '',
    STYLE: access.style,
    FORMAT: access.format,
    TILEMATRIXSET: access.matrix_set,
    TILEMATRIX: matrix,
    TILEROW: String(row),
    TILECOL: String(column),
    ...(time === undefined ? {} : { TIME: time }),
  };
  for (const [name, value] of Object.entries(query)) url.searchParams.set(name, value);
  return url.href;
}

/** A grid of tiles of one resolution; tile (0, 0) is the north-western one. */
export type TileMatrix = {
  readonly id: string;
  /** Units of the CRS a pixel. */
  readonly resolution_m: number;
  readonly left_m: number;
  readonly top_m: number;
  /** Width, and height too where that is not given. */
  readonly tile_px: number;
  readonly tile_height_px?: number | undefined;
  readonly columns: number;
  readonly rows: number;
};

export type TileRange = {
  readonly column: number;
  readonly row: number;
  readonly columns: number;
  readonly rows: number;
};

const kMaxTiles = 4000;
/** Scale denominators are rounded numbers. */
const kScaleTolerance = 1.01;

/** The coarsest matrix that is as fine as wanted; else the finest there is. */
export function chooseMatrix(
  matrices: readonly TileMatrix[],
  wanted: number,
): TileMatrix | undefined {
  const byStep = [...matrices].sort((a, b) => b.resolution_m - a.resolution_m);
  return byStep.find((matrix) => matrix.resolution_m <= wanted * kScaleTolerance) ?? byStep.at(-1);
}

/** Pixels across and down. */
export function tileSize({ tile_px, tile_height_px = tile_px }: TileMatrix): [number, number] {
  return [tile_px, tile_height_px];
}

/** @return the tiles that touch `bounds`, as far as the matrix goes; undefined when none does */
export function tilesIn(matrix: TileMatrix, bounds: BoundsM): TileRange | undefined {
  const [width, height] = tileSize(matrix).map((side_px) => side_px * matrix.resolution_m) as [
    number,
    number,
  ];
  const [west, south, east, north] = bounds;
  // Room for one pixel around, which resampling reads.
  const pad = matrix.resolution_m;
  const column = Math.max(0, Math.floor((west - pad - matrix.left_m) / width));
  const row = Math.max(0, Math.floor((matrix.top_m - north - pad) / height));
  const columns =
    Math.min(matrix.columns, Math.ceil((east + pad - matrix.left_m) / width)) - column;
  const rows = Math.min(matrix.rows, Math.ceil((matrix.top_m - south + pad) / height)) - row;
  if (columns < 1 || rows < 1) return undefined;
  if (columns * rows > kMaxTiles) {
    throw new GrabberError(
      'ORTHO',
      `gather tiles of matrix ${matrix.id}: ${columns * rows} of them; allowed: at most ` +
        `${kMaxTiles} a square (--resolution-m)`,
    );
  }
  return { column, row, columns, rows };
}

/** The pixels of a range of tiles. */
export function gridOfTiles(matrix: TileMatrix, range: TileRange, crs: string): Target {
  const [width_px, height_px] = tileSize(matrix);
  const width = width_px * matrix.resolution_m;
  const height = height_px * matrix.resolution_m;
  const west = matrix.left_m + range.column * width;
  const north = matrix.top_m - range.row * height;
  return {
    crs,
    bounds: [west, north - range.rows * height, west + range.columns * width, north],
    resolution_m: matrix.resolution_m,
    width_px: range.columns * width_px,
    height_px: range.rows * height_px,
  };
}

/** What is needed of a tile service to request tiles of one layer. */
export type TileService = {
  readonly crs: string;
  readonly matrices: readonly TileMatrix[];
  /** Address with {TileMatrix} {TileRow} {TileCol} and more; undefined = by parameters at `kvp`. */
  readonly template: string | undefined;
  readonly kvp: string;
};

export type Wanted = {
  readonly layer: string;
  readonly matrixSet: string;
  readonly format: string;
  readonly axis: 'en' | 'ne';
};

/**
 * Side of a pixel on the screen that scale denominators are meant for. Ref: OGC 07-057r7 (WMTS
 * 1.0), 6.1.
 */
const kScreenPixel_m = 0.00028;

const one = z.union([z.string(), z.number()]).transform(String);
/** An element that may stand once, often or not at all. */
const list = <T extends z.ZodType>(item: T) => z.preprocess(asList, z.array(item));
const count = z.coerce.number().int().min(1);
const matrixSchema = z.object({
  Identifier: one,
  ScaleDenominator: z.coerce.number().positive(),
  TopLeftCorner: one,
  TileWidth: count,
  TileHeight: count,
  MatrixWidth: count,
  MatrixHeight: count,
});
const capabilitiesSchema = z.object({
  Capabilities: z.object({
    Contents: z.object({
      Layer: list(
        z.object({
          Identifier: one,
          ResourceURL: list(z.object({ '@format': one, '@resourceType': one, '@template': one })),
        }),
      ),
      TileMatrixSet: list(
        z.object({ Identifier: one, SupportedCRS: one, TileMatrix: list(matrixSchema) }),
      ),
    }),
  }),
});

function asList(value: unknown): unknown[] {
  if (value === undefined) return [];
  return Array.isArray(value) ? value : [value];
}

/** @throws GrabberError MAP_SERVICE naming what is not there */
export function parseCapabilities(xml: string, url: string, wanted: Wanted): TileService {
  const contents = readXml(xml, url).Capabilities.Contents;
  const fail = (what: string, allowed: string): never => {
    throw new GrabberError(
      'MAP_SERVICE',
      `read the tile service ${url}: ${what}; allowed: ${allowed}`,
    );
  };
  const layer = contents.Layer.find((found) => found.Identifier === wanted.layer);
  if (layer === undefined) {
    return fail(
      `no layer "${wanted.layer}"`,
      contents.Layer.slice(0, 20)
        .map((found) => found.Identifier)
        .join(', ') || 'one with layers',
    );
  }
  const set = contents.TileMatrixSet.find((found) => found.Identifier === wanted.matrixSet);
  if (set === undefined) {
    return fail(
      `no matrix set "${wanted.matrixSet}"`,
      contents.TileMatrixSet.map((found) => found.Identifier).join(', ') || 'one with matrix sets',
    );
  }
  const crs = parseCrsName(set.SupportedCRS);
  if (crs === undefined) {
    return fail(
      `matrix set ${wanted.matrixSet} in ${set.SupportedCRS}`,
      'an EPSG system in metres',
    );
  }
  const matrices = set.TileMatrix.map((matrix): TileMatrix => {
    const corner = matrix.TopLeftCorner.trim().split(/\s+/).map(Number);
    const [left_m, top_m] = wanted.axis === 'ne' ? [corner[1], corner[0]] : corner;
    if (left_m === undefined || top_m === undefined || !Number.isFinite(left_m + top_m)) {
      return fail(`corner "${matrix.TopLeftCorner}" of matrix ${matrix.Identifier}`, 'two numbers');
    }
    return {
      id: matrix.Identifier,
      resolution_m: matrix.ScaleDenominator * kScreenPixel_m,
      left_m,
      top_m,
      tile_px: matrix.TileWidth,
      tile_height_px: matrix.TileHeight,
      columns: matrix.MatrixWidth,
      rows: matrix.MatrixHeight,
    };
  });
  const template = layer.ResourceURL.find(
    (found) => found['@resourceType'] === 'tile' && found['@format'] === wanted.format,
  )?.['@template'];
  const query = new URL(url);
  query.search = '';
  return { crs, matrices, template, kvp: query.href };
}

function readXml(xml: string, url: string): z.infer<typeof capabilitiesSchema> {
  // Definitions of entities are how XML is made to grow without end.
  if (/<!(DOCTYPE|ENTITY)/i.test(xml)) {
    throw new GrabberError(
      'MAP_SERVICE',
      `read the tile service ${url}: its XML defines a document type; allowed: plain capabilities`,
    );
  }
  try {
    const parser = new XMLParser({
      ignoreAttributes: false,
      attributeNamePrefix: '@',
      removeNSPrefix: true,
      parseTagValue: false,
      parseAttributeValue: false,
    });
    return capabilitiesSchema.parse(parser.parse(xml));
  } catch (error) {
    throw new GrabberError(
      'MAP_SERVICE',
      `read the tile service ${url}: no capabilities of WMTS 1.0; allowed: those`,
      { cause: error },
    );
  }
}

/** urn:ogc:def:crs:EPSG::3857 or EPSG:3857; degrees have no pixel size in metres. */
function parseCrsName(text: string): string | undefined {
  const number = /EPSG:(?:[0-9.]*:)?(\d{4,6})$/.exec(text.trim())?.[1];
  return number === undefined || number === '4326' || number === '4258'
    ? undefined
    : `EPSG:${number}`;
}
