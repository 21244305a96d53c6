import { stat } from 'node:fs/promises';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { usage, GrabberError, causedError } from '../util/errors.js';
import type { BoundsM } from '../model/store.js';
import { namesInFolder } from '../util/files.js';
import { boundsOfRaster, type Gdal } from './gdal.js';
import { readImageKind, toChannels, type Gather, type Piece } from './piece.js';
import { overlap } from '../geo/bounds.js';
import { boundsIn } from './target.js';

const kEndings = ['.tif', '.tiff', '.jpg', '.jpeg', '.png', '.jp2'];

type LocalImage = Piece & { readonly bounds: BoundsM; readonly resolution_m: number };

/**
 * Pictures that lie on this machine: one file, or all of a folder; GeoTIFF, or JPEG and PNG with a
 * world file. One without a CRS is taken to be in `crs`. Each is opened once.
 */
export function localGather(from: string, crs: string | null): Gather {
  const path = resolve(from);
  let images: Promise<LocalImage[]> | undefined;
  return async (target, context, signal) => {
    const found = await (images ??= readImages(path, crs ?? target.crs, context.gdal, signal));
    const touching: LocalImage[] = [];
    for (const image of found) {
      const { bounds } = await boundsIn(target, image.crs ?? target.crs, context.gdal, signal);
      if (overlap(bounds, image.bounds)) touching.push(image);
    }
    if (touching.length === 0) return undefined;
    const finest = Math.min(...touching.map((image) => image.resolution_m));
    // Coarse ones first: finer ones are laid over them.
    const pieces = touching.sort(
      (a, b) => b.resolution_m - a.resolution_m || (a.path < b.path ? -1 : 1),
    );
    return {
      pieces,
      url: pathToFileURL(path).href,
      grid: undefined,
      resolution_m: finest,
      date: undefined,
      warnings: [],
    };
  };
}

async function readImages(
  path: string,
  crs: string,
  gdal: Gdal,
  signal: AbortSignal,
): Promise<LocalImage[]> {
  const paths = await listPaths(path);
  const images: LocalImage[] = [];
  for (const one of paths) {
    const kind = await readImageKind(one, one);
    const facts = await gdal.info(one, kind, {}, signal);
    const bounds = boundsOfRaster(facts);
    if (bounds === undefined) {
      throw new GrabberError(
        'ORTHO',
        `read the picture ${one}: it is rotated, or not georeferenced; allowed: GeoTIFF ` +
          'tags or a world file, north up',
      );
    }
    const own = parseEpsg(facts.wkt);
    images.push({
      path: one,
      kind,
      channels: toChannels(facts.bands.map((band) => band.interpretation)),
      // An EPSG code can be compared; the WKT of the file is used where it has no code.
      crs: facts.wkt === undefined ? crs : (own ?? facts.wkt),
      bounds,
      resolution_m: (bounds[2] - bounds[0]) / facts.width_px,
    });
  }
  return images;
}

async function listPaths(path: string): Promise<string[]> {
  try {
    if ((await stat(path)).isFile()) return [path];
    const names = (
      await Promise.all(
        kEndings
          .flatMap((ending) => [ending, ending.toUpperCase()])
          .map((ending) => namesInFolder(path, ending)),
      )
    ).flat();
    if (names.length > 0) {
      return [...new Set(names)]
        .filter((name) => !name.startsWith('.'))
        .sort()
        .map((name) => join(path, name));
    }
  } catch (error) {
    throw causedError('USAGE', `read --from ${path}`, error, 'a picture or a folder of pictures');
  }
  throw usage(`read --from ${path}: no pictures; allowed: a folder of ${kEndings.join(' ')}`);
}

/** The number of a system, when its text ends with one. */
function parseEpsg(wkt: string | undefined): string | undefined {
  const number = /ID\["EPSG",(\d+)\]\]\s*$/.exec(wkt ?? '')?.[1];
  return number === undefined ? undefined : `EPSG:${number}`;
}
