import { join } from 'node:path';
import { GrabberError } from '../util/errors.js';
import { boundsOfRaster, type Gdal, type RasterFacts } from './gdal.js';
import { kGeoTiff, type Gathered, type Channels, type Piece } from './piece.js';
import type { Target } from './target.js';
import { runAll } from './download.js';

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
  const words = translateWords(mosaic, path, colours.length, holes, facts, gathered.date, options);
  await gdal.run('write the orthophoto', words, signal);
  const levels = overviewLevels(target);
  if (levels.length > 0) {
    await gdal.run('add overviews', ['gdaladdo', '-q', '-r', 'average', path, ...levels], signal);
  }
  await checkResult(path, target, levels.length, gdal, signal);
  if (colours.some((band) => band.min !== band.max)) return { path, warnings: [] };
  const value = colours.map((band) => band.min).join(' ');
  return { path, warnings: [`the orthophoto is empty: every pixel has the value ${value}`] };
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
    ? ['COMPRESS=JPEG', `JPEG_QUALITY=${kJpegQuality}`]
    : ['COMPRESS=DEFLATE', 'PREDICTOR=2'];
  if (colours >= 3) packing.push(`PHOTOMETRIC=${jpeg ? 'YCBCR' : 'RGB'}`);
  const made = ['TILED=YES', 'BIGTIFF=IF_SAFER', 'ALPHA=NO', ...packing];
  const bands = Array.from({ length: colours }, (_unused, band) => ['-b', String(band + 1)]).flat();
  const year = /^(\d{4})(?:-(\d{2})-(\d{2}))?/.exec(date ?? '');
  const day = year === null ? '' : `${year[1]}:${year[2] ?? '01'}:${year[3] ?? '01'}`;
  return [
    ...['gdal_translate', '-q', '-if', 'GTiff', ...bands],
    ...['-mask', holes ? String(colours + 1) : 'none'],
    ...made.flatMap((option) => ['-co', option]),
    ...(year === null ? [] : ['-mo', `TIFFTAG_DATETIME=${day} 00:00:00`]),
    ...[from, to],
  ];
}

function overviewLevels(target: Target): string[] {
  const longest_px = Math.max(target.width_px, target.height_px);
  const levels = [2, 4, 8, 16, 32, 64].filter((level) => longest_px / level >= kMinOverview_px / 2);
  return levels.map(String);
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

/** Two grids have the same pixels when they are this near, in parts of a pixel. */
const kGridTolerance = 1e-6;
/** From this ratio on several pixels become one, and all of them count. */
const kMinAveragingRatio = 1.5;
/** GDAL's programs at a time. */
const kMaxPrograms = 4;

/**
 * Lays pieces over each other and brings them to the target's pixels. Pieces of one grid are joined
 * pixel by pixel first, so that resampling sees across their edges; where that grid is the
 * target's, nothing is resampled at all.
 * @return a GeoTIFF: the colours, and last how opaque each pixel is
 */
export async function makeMosaic(
  gathered: Gathered,
  target: Target,
  nearInfrared: boolean,
  gdal: Gdal,
  folder: string,
  signal: AbortSignal,
): Promise<string> {
  const { grid } = gathered;
  let pieces = await sameChannels(gathered.pieces, nearInfrared, gdal, folder, signal);
  if (grid !== undefined) {
    const joined = join(folder, 'joined.tif');
    await warp(pieces, grid, joined, 'near', nearInfrared, gdal, signal);
    if (samePixels(grid, target)) return joined;
    pieces = [{ path: joined, kind: kGeoTiff, channels: 'other', crs: null }];
  }
  const mosaic = join(folder, 'laid.tif');
  const ratio = target.resolution_m / (gathered.resolution_m ?? target.resolution_m);
  const method = ratio >= kMinAveragingRatio ? 'average' : 'bilinear';
  const noAlpha = nearInfrared && grid === undefined;
  await warp(pieces, target, mosaic, method, noAlpha, gdal, signal);
  return mosaic;
}

function samePixels(a: Target, b: Target): boolean {
  const near = (x: number, y: number): boolean => Math.abs(x - y) < kGridTolerance * b.resolution_m;
  return (
    a.crs === b.crs &&
    a.width_px === b.width_px &&
    a.height_px === b.height_px &&
    a.bounds.every((edge, i) => near(edge, b.bounds[i] ?? 0))
  );
}

/** Pieces of one CRS go in one run; later runs lay theirs over what is there. */
async function warp(
  pieces: readonly Piece[],
  target: Target,
  to: string,
  method: string,
  nearInfrared: boolean,
  gdal: Gdal,
  signal: AbortSignal,
): Promise<void> {
  const made = [
    ...['-dstalpha', '-t_srs', target.crs, '-te', ...target.bounds.map(String)],
    ...['-ts', String(target.width_px), String(target.height_px)],
    ...['-of', 'GTiff', '-co', 'TILED=YES', '-co', 'BIGTIFF=IF_SAFER', '-co', 'COMPRESS=NONE'],
  ];
  for (const [index, run] of runsOfOneCrs(pieces).entries()) {
    const words = [
      ...['gdalwarp', '-q', '-wm', '256', '-et', '0.01', '-r', method],
      ...(nearInfrared ? ['-nosrcalpha'] : []),
      ...(run.crs === null ? [] : ['-s_srs', run.crs]),
      ...(index === 0 ? made : []),
      ...run.drivers.flatMap((driver) => ['-if', driver]),
      ...run.paths,
      to,
    ];
    await gdal.run('lay pictures together', words, signal);
  }
}

type Run = { readonly crs: string | null; readonly drivers: string[]; readonly paths: string[] };

function runsOfOneCrs(pieces: readonly Piece[]): Run[] {
  const runs: Run[] = [];
  for (const piece of pieces) {
    let run = runs.at(-1);
    if (run === undefined || run.crs !== piece.crs) {
      runs.push((run = { crs: piece.crs, drivers: [], paths: [] }));
    }
    if (!run.drivers.includes(piece.kind.driver)) run.drivers.push(piece.kind.driver);
    run.paths.push(piece.path);
  }
  return runs;
}

/**
 * Servers send a tile of one colour as a palette or as grey among coloured ones: all become alike.
 */
async function sameChannels(
  pieces: readonly Piece[],
  nearInfrared: boolean,
  gdal: Gdal,
  folder: string,
  signal: AbortSignal,
): Promise<Piece[]> {
  const kinds = new Set(pieces.map((piece) => piece.channels));
  const plain: readonly Channels[] = ['rgb', 'rgba', 'grey', 'other'];
  if (kinds.size === 1 && plain.includes(pieces[0]?.channels ?? 'palette')) return [...pieces];
  return runAll(
    pieces.map((piece, index) => async (signal: AbortSignal): Promise<Piece> => {
      if (piece.channels === 'rgba' || (nearInfrared && piece.channels === 'other')) return piece;
      const path = join(folder, `piece-${index}.tif`);
      const from = ['gdal_translate', '-q', '-if', piece.kind.driver];
      const words = [...from, ...expansion(piece.channels), piece.path, path];
      await gdal.run('expand a picture', words, signal);
      return { ...piece, path, kind: kGeoTiff, channels: 'rgba' };
    }),
    kMaxPrograms,
    signal,
  );
}

function expansion(channels: Channels): string[] {
  if (channels === 'palette') return ['-expand', 'rgba'];
  const bands = channels === 'grey' || channels === 'greya' ? ['1', '1', '1'] : ['1', '2', '3'];
  const colours = ['red', 'green', 'blue', 'alpha'];
  const names = colours.flatMap((name, index) => [`-colorinterp_${index + 1}`, name]);
  return [...bands, 'mask'].flatMap((band) => ['-b', band]).concat(names);
}
