import { join } from 'node:path';
import { runAll } from './run-all.js';
import type { Gdal } from './gdal.js';
import { kGeoTiff } from './image-kind.js';
import type { Channels, Gathered, Piece } from './piece.js';
import type { Target } from './target.js';

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
  await warp(
    pieces,
    target,
    mosaic,
    ratio >= kMinAveragingRatio ? 'average' : 'bilinear',
    nearInfrared && grid === undefined,
    gdal,
    signal,
  );
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
    ...[
      '-dstalpha',
      '-t_srs',
      target.crs,
      '-te',
      ...target.bounds.map(String),
      '-ts',
      String(target.width_px),
      String(target.height_px),
    ],
    ...['-of', 'GTiff', '-co', 'TILED=YES', '-co', 'BIGTIFF=IF_SAFER', '-co', 'COMPRESS=NONE'],
  ];
  for (const [index, run] of runsOfOneCrs(pieces).entries()) {
    const words = [
      ...[
        'gdalwarp',
        '-q',
        '-wm',
        '256',
        '-et',
        '0.01',
        '-r',
        method,
        ...(nearInfrared ? ['-nosrcalpha'] : []),
      ],
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
      await gdal.run(
        'expand a picture',
        [
          'gdal_translate',
          '-q',
          '-if',
          piece.kind.driver,
          ...expansion(piece.channels),
          piece.path,
          path,
        ],
        signal,
      );
      return { ...piece, path, kind: kGeoTiff, channels: 'rgba' };
    }),
    kMaxPrograms,
    signal,
  );
}

function expansion(channels: Channels): string[] {
  if (channels === 'palette') return ['-expand', 'rgba'];
  const bands = channels === 'grey' || channels === 'greya' ? ['1', '1', '1'] : ['1', '2', '3'];
  const names = ['red', 'green', 'blue', 'alpha'].flatMap((name, index) => [
    `-colorinterp_${index + 1}`,
    name,
  ]);
  return [...bands, 'mask'].flatMap((band) => ['-b', band]).concat(names);
}
