import { rename } from 'node:fs/promises';
import { join } from 'node:path';
import { GrabberError } from '../util/errors.js';
import { runAll } from './run-all.js';
import { writeWorldFile } from './gdal.js';
import { probeImage, requireSize, type Gather, type GatherContext, type Piece } from './piece.js';
import { boundsIn } from './request-grid.js';
import type { OrthoSource, WmtsAccess } from './schema.js';
import { boundsOfBlock, type Target } from './target.js';
import { parseCapabilities, type TileService } from './wmts-capabilities.js';
import { chooseMatrix, gridOfTiles, tileSize, tilesIn, type TileMatrix } from './wmts-matrix.js';

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
