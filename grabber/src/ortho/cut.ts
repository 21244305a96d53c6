import { join } from 'node:path';
import { GrabberError } from '../util/errors.js';
import { boundsOfRaster, type Gdal, type RasterFacts } from './gdal.js';
import { kGeoTiff } from './image-kind.js';
import { makeMosaic } from './mosaic.js';
import type { Gathered } from './piece.js';
import type { Target } from './target.js';

export type CutOptions = {
  /** DEFLATE instead of JPEG. */
  readonly lossless: boolean;
  /** The fourth band is near infrared, not how opaque a pixel is. */
  readonly nearInfrared: boolean;
};

export type Cut = { readonly path: string; readonly warnings: readonly string[] };

const kJpegQuality = 90;
/** The coarsest overview has about this many pixels a side. */
const kMinOverview_px = 256;
const kPlaceTolerance_px = 1e-3;

/**
 * Makes a tiled GeoTIFF with overviews of exactly the target's pixels. Ground that no piece covers
 * is left out by an internal mask. The result has been opened again and compared with the target.
 * @throws GrabberError ORTHO when no piece has a pixel there
 */
export async function cutOrthophoto(
  gathered: Gathered,
  target: Target,
  options: CutOptions,
  gdal: Gdal,
  folder: string,
  signal: AbortSignal,
): Promise<Cut> {
  const mosaic = await makeMosaic(gathered, target, options.nearInfrared, gdal, folder, signal);
  const facts = await gdal.info(mosaic, kGeoTiff, { statistics: true }, signal);
  const colours = facts.bands.slice(0, -1);
  const alpha = facts.bands.at(-1);
  if (colours.length === 0 || alpha?.interpretation !== 'Alpha') {
    throw new GrabberError(
      'ORTHO',
      `cut an orthophoto from ${gathered.url}: ${facts.bands.length} bands; allowed: ` +
        'colours and what covers them',
    );
  }
  // Statistics skip pixels that nothing covers: without a single one there are none.
  if (alpha.max === undefined || alpha.max === 0) {
    throw new GrabberError(
      'ORTHO',
      `cut an orthophoto from ${gathered.url}: no pixel of it lies in the square; allowed: ` +
        'pictures of that ground',
    );
  }
  const path = join(folder, 'orthophoto.tif');
  const holes = alpha.min !== alpha.max;
  await gdal.run(
    'write the orthophoto',
    translateWords(mosaic, path, colours.length, holes, facts, gathered.date, options),
    signal,
  );
  const levels = overviewLevels(target);
  if (levels.length > 0) {
    await gdal.run('add overviews', ['gdaladdo', '-q', '-r', 'average', path, ...levels], signal);
  }
  await checkResult(path, target, levels.length, gdal, signal);
  const empty = colours.every((band) => band.min === band.max);
  return {
    path,
    warnings: empty
      ? [
          'the orthophoto is empty: every pixel has the value ' +
            `${colours.map((band) => band.min).join(' ')}`,
        ]
      : [],
  };
}

function translateWords(
  from: string,
  to: string,
  colours: number,
  holes: boolean,
  facts: RasterFacts,
  date: string | undefined,
  options: CutOptions,
): string[] {
  const bytes = facts.bands.every((band) => band.type === 'Byte');
  const jpeg = !options.lossless && bytes && (colours === 3 || colours === 1);
  const packing = jpeg
    ? [
        'COMPRESS=JPEG',
        `JPEG_QUALITY=${kJpegQuality}`,
        ...(colours === 3 ? ['PHOTOMETRIC=YCBCR'] : []),
      ]
    : ['COMPRESS=DEFLATE', 'PREDICTOR=2', ...(colours >= 3 ? ['PHOTOMETRIC=RGB'] : [])];
  const bands = Array.from({ length: colours }, (_unused, band) => ['-b', String(band + 1)]).flat();
  const year = /^(\d{4})(?:-(\d{2})-(\d{2}))?/.exec(date ?? '');
  return [
    'gdal_translate',
    '-q',
    '-if',
    'GTiff',
    ...bands,
    '-mask',
    holes ? String(colours + 1) : 'none',
    ...['TILED=YES', 'BIGTIFF=IF_SAFER', 'ALPHA=NO', ...packing].flatMap((option) => [
      '-co',
      option,
    ]),
    ...(year === null
      ? []
      : ['-mo', `TIFFTAG_DATETIME=${year[1]}:${year[2] ?? '01'}:${year[3] ?? '01'} 00:00:00`]),
    from,
    to,
  ];
}

function overviewLevels(target: Target): string[] {
  const levels: string[] = [];
  for (
    let level = 2;
    Math.max(target.width_px, target.height_px) / level >= kMinOverview_px / 2 && level <= 64;
    level *= 2
  ) {
    levels.push(String(level));
  }
  return levels;
}

async function checkResult(
  path: string,
  target: Target,
  overviews: number,
  gdal: Gdal,
  signal: AbortSignal,
): Promise<void> {
  const facts = await gdal.info(path, kGeoTiff, {}, signal);
  const bounds = boundsOfRaster(facts);
  const placed =
    bounds?.every(
      (edge, i) =>
        Math.abs(edge - (target.bounds[i] ?? 0)) < kPlaceTolerance_px * target.resolution_m,
    ) ?? false;
  const whole =
    facts.width_px === target.width_px &&
    facts.height_px === target.height_px &&
    facts.overviews === overviews;
  if (placed && whole && facts.wkt !== undefined) return;
  throw new GrabberError(
    'ORTHO',
    `check the orthophoto: ${facts.width_px} x ${facts.height_px} pixels at ` +
      `${bounds?.join(', ') ?? 'no place'} with ${facts.overviews} overviews; allowed: ` +
      `${target.width_px} x ${target.height_px} at ${target.bounds.join(', ')} in ` +
      `${target.crs}`,
  );
}
