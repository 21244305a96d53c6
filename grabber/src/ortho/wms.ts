import { rename } from 'node:fs/promises';
import { join } from 'node:path';
import type { BoundsM } from '../model/store.js';
import { runAll } from './download.js';
import { writeWorldFile } from './gdal.js';
import { probeImage, requireSize, type Gather, type Piece } from './piece.js';
import { requestGrid, makeBlocks, boundsOfBlock, type Block } from './target.js';
import type { OrthoSource, WmsAccess } from './schema.js';

/** Four bytes a pixel and as many again for what surrounds them. */
const kBytesPerPixel = 8;
const kSlack_bytes = 1 << 20;

/** @param bounds  in `crs` */
export function getMapUrl(
  access: WmsAccess,
  crs: string,
  bounds: BoundsM,
  size: Pick<Block, 'width_px' | 'height_px'>,
  time: string | undefined,
): string {
  const url = new URL(access.url);
  const [west, south, east, north] = bounds.map(rounded);
  const swapped = access.version === '1.3.0' && access.northing_first.includes(crs);
  const words: Record<string, string> = {
    SERVICE: 'WMS',
    VERSION: access.version,
    REQUEST: 'GetMap',
    LAYERS: access.layer,
    STYLES: access.style,
    [access.version === '1.3.0' ? 'CRS' : 'SRS']: crs,
    BBOX: (swapped ? [south, west, north, east] : [west, south, east, north]).join(','),
    WIDTH: String(size.width_px),
    HEIGHT: String(size.height_px),
    FORMAT: access.format,
    TRANSPARENT: access.transparent ? 'TRUE' : 'FALSE',
    ...(time === undefined ? {} : { TIME: time }),
  };
  for (const [name, value] of Object.entries(words)) url.searchParams.set(name, value);
  return url.href;
}

/**
 * Requests a target in pictures no larger than the server draws; together they cover it without a
 * seam.
 */
export function wmsGather(source: OrthoSource, access: WmsAccess): Gather {
  return async (target, context, signal) => {
    const crs = [source.crs, ...source.more_crs].includes(target.crs) ? target.crs : source.crs;
    const grid = await requestGrid(target, crs, context.gdal, signal);
    const pieces = await runAll(
      makeBlocks(grid, access.max_pixels).map(
        (block, index) =>
          async (signal: AbortSignal): Promise<Piece | undefined> => {
            const bounds = boundsOfBlock(grid, block);
            const url = getMapUrl(access, crs, bounds, block, context.time);
            const raw = join(context.folder, `block-${index}.raw`);
            const max_bytes = block.width_px * block.height_px * kBytesPerPixel + kSlack_bytes;
            if (!(await context.download.toFile(url, raw, max_bytes, signal))) return undefined;
            const probe = await probeImage(raw, url, context.gdal, signal);
            requireSize(probe, block.width_px, block.height_px, url);
            const path = join(context.folder, `block-${index}.${probe.kind.extension}`);
            await rename(raw, path);
            await writeWorldFile(path, probe.kind, bounds, block.width_px, block.height_px);
            return { path, kind: probe.kind, channels: probe.channels, crs };
          },
      ),
      context.concurrency,
      signal,
    );
    const found = pieces.filter((piece) => piece !== undefined);
    if (found.length === 0) return undefined;
    const holes = pieces.length - found.length;
    return {
      pieces: found,
      url: access.url,
      grid,
      resolution_m: target.resolution_m,
      date: context.time,
      warnings:
        holes === 0 ? [] : [`${holes} of ${pieces.length} pictures of ${source.id} are missing`],
    };
  };
}

/** Removes digits that are rounding errors. */
function rounded(value: number): number {
  return Number(value.toFixed(6));
}
