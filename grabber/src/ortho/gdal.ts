import { writeFile } from 'node:fs/promises';
import { runCommand, type CommandLimits } from '../convert/run-command.js';
import type { BoundsM } from '../model/store.js';
import { GrabberError } from '../util/errors.js';
import type { ImageKind } from './piece.js';

/**
 * Drivers that read a picture and nothing else: none follows a reference to another file or an
 * address.
 */
const kDrivers = ['GTiff', 'JPEG', 'PNG', 'JP2OpenJPEG', 'MEM'] as const;
const kTimeLimit_s = 1800;
const kDisk_bytes = 32 * 2 ** 30;
const kCache_mb = 256;

export type BandFacts = {
  readonly min: number | undefined;
  readonly max: number | undefined;
  readonly interpretation: string;
  readonly type: string;
};

/** The facts that gdalinfo prints of a picture. */
export type RasterFacts = {
  readonly width_px: number;
  readonly height_px: number;
  /** Undefined where the file has no georeference. */
  readonly geo: readonly number[] | undefined;
  readonly wkt: string | undefined;
  readonly bands: readonly BandFacts[];
  readonly overviews: number;
  readonly blockWidth_px: number;
};

/**
 * GDAL's programs, each run in a folder of its own work with drivers that cannot be made to open
 * anything else, no network, and no files next to the picture but those that we wrote or the user
 * named.
 */
export type Gdal = {
  info(
    path: string,
    kind: ImageKind,
    options: { statistics?: boolean },
    signal: AbortSignal,
  ): Promise<RasterFacts>;
  run(what: string, argv: readonly string[], signal: AbortSignal): Promise<void>;
  /** Coordinates of one CRS in another, easting first; in order. */
  transform(
    points: readonly (readonly [number, number])[],
    from: string,
    to: string,
    signal: AbortSignal,
  ): Promise<[number, number][]>;
};

/** @param folder  of the work; programs start there */
export async function openGdal(folder: string, signal: AbortSignal): Promise<Gdal> {
  const limits = { time_limit_s: kTimeLimit_s, disk_bytes: kDisk_bytes };
  const formats = await listFormats(folder, limits, signal);
  const environment = environmentFor(formats);
  const run = (
    what: string,
    argv: readonly string[],
    signal: AbortSignal,
    input?: string,
  ): Promise<{ out: string }> =>
    runCommand({ what, argv, folder, limits, environment, input }, signal);
  return {
    async info(path, kind, options, signal) {
      const statistics = options.statistics === true ? ['-stats'] : [];
      const words = ['gdalinfo', '-json', '-if', kind.driver, ...statistics, path];
      return toFacts(JSON.parse((await run(`look into ${path}`, words, signal)).out) as GdalInfo);
    },
    async run(what, argv, signal) {
      await run(what, argv, signal);
    },
    async transform(points, from, to, signal) {
      const text = points.map(([x, y]) => `${x} ${y}\n`).join('');
      const words = ['gdaltransform', '-output_xy', '-s_srs', from, '-t_srs', to];
      const { out } = await run(`transform ${from} to ${to}`, words, signal, text);
      const found = parsePoints(out);
      const good = found.every(([x, y]) => Number.isFinite(x) && Number.isFinite(y));
      if (good && found.length === points.length) return found;
      throw new GrabberError(
        'ORTHO',
        `transform ${from} to ${to}: a point has no place there; allowed: ground that ` +
          'both systems cover',
      );
    },
  };
}

/** @throws GrabberError ORTHO when GDAL's programs are missing */
async function listFormats(
  folder: string,
  limits: CommandLimits,
  signal: AbortSignal,
): Promise<string> {
  const argv = ['gdalinfo', '--formats'];
  try {
    return (await runCommand({ what: 'look for GDAL', argv, folder, limits }, signal)).out;
  } catch (error) {
    signal.throwIfAborted();
    throw new GrabberError(
      'ORTHO',
      'look for GDAL: gdalinfo cannot be run; allowed: GDAL 3 programs in PATH (Debian: gdal-bin)',
      { cause: error },
    );
  }
}

/** Reads the output of gdaltransform, a point a line; what is no number becomes NaN. */
function parsePoints(text: string): [number, number][] {
  const lines = text.trim().split('\n');
  return lines.map((line) => line.trim().split(/\s+/).map(Number) as [number, number]);
}

function environmentFor(formats: string): Record<string, string> {
  const all = [...formats.matchAll(/^ {2}(\S.*?) -[^-]*-/gm)].map((match) => match[1] ?? '');
  const skipped = all.filter((name) => !(kDrivers as readonly string[]).includes(name));
  return {
    // Names with blanks are separated by commas.
    GDAL_SKIP: skipped.join(','),
    OGR_SKIP: skipped.join(','),
    GDAL_PAM_ENABLED: 'NO',
    GDAL_CACHEMAX: String(kCache_mb),
    GDAL_NUM_THREADS: '1',
    CPL_VSIL_CURL_ALLOWED_EXTENSIONS: '.none',
    GDAL_HTTP_TIMEOUT: '1',
    PROJ_NETWORK: 'OFF',
    GDAL_TIFF_INTERNAL_MASK: 'YES',
    // A picture of a map service lies where it was requested, whatever tags it carries: our world
    // file has precedence.
    GDAL_GEOREF_SOURCES: 'WORLDFILE,INTERNAL',
  };
}

/** Writes a world file for a picture without tags. */
export async function writeWorldFile(
  image: string,
  kind: ImageKind,
  bounds: BoundsM,
  width_px: number,
  height_px: number,
): Promise<void> {
  const [west, south, east, north] = bounds;
  const step = [(east - west) / width_px, (north - south) / height_px] as const;
  // A world file names the centre of the first pixel.
  const lines = [step[0], 0, 0, -step[1], west + step[0] / 2, north - step[1] / 2];
  await writeFile(image.replace(/\.[^.]+$/, `.${kind.world}`), `${lines.join('\n')}\n`);
}

/** @return west, south, east, north; undefined for a picture that is turned or has no place */
export function boundsOfRaster(facts: RasterFacts): BoundsM | undefined {
  const [left, step_x, turn_x, top, turn_y, step_y] = facts.geo ?? [];
  if (left === undefined || step_x === undefined || top === undefined || step_y === undefined) {
    return undefined;
  }
  if (turn_x !== 0 || turn_y !== 0 || !(step_x > 0) || !(step_y < 0)) return undefined;
  return [left, top + facts.height_px * step_y, left + facts.width_px * step_x, top];
}

type GdalInfo = {
  size: [number, number];
  geoTransform?: number[];
  coordinateSystem?: { wkt?: string };
  bands?: {
    min?: number;
    max?: number;
    minimum?: number;
    maximum?: number;
    colorInterpretation?: string;
    type?: string;
    block?: [number, number];
    overviews?: unknown[];
  }[];
};

function toFacts(info: GdalInfo): RasterFacts {
  const bands = info.bands ?? [];
  const wkt = info.coordinateSystem?.wkt;
  return {
    width_px: info.size[0],
    height_px: info.size[1],
    geo: info.geoTransform,
    wkt: wkt === undefined || wkt === '' ? undefined : wkt,
    bands: bands.map((band) => ({
      min: band.minimum ?? band.min,
      max: band.maximum ?? band.max,
      interpretation: band.colorInterpretation ?? 'Undefined',
      type: band.type ?? 'Unknown',
    })),
    overviews: bands[0]?.overviews?.length ?? 0,
    blockWidth_px: bands[0]?.block?.[0] ?? 0,
  };
}
