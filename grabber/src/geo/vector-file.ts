import { execFile } from 'node:child_process';
import { stat } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { resolve } from 'node:path';
import { z } from 'zod';
import { programEnvironment } from '../convert/run-command.js';
import {
  GrabberError,
  describeError,
  oneLine,
  systemCode,
  type ErrorCode,
} from '../util/errors.js';

const featureSchema = z.looseObject({
  properties: z.record(z.string(), z.unknown()).nullish(),
  geometry: z.looseObject({ type: z.string(), coordinates: z.unknown() }).nullish(),
});
const collectionSchema = z.looseObject({ features: z.array(featureSchema) });
export type VectorFeature = z.infer<typeof featureSchema>;

/**
 * GDAL guesses formats by content, and some (VRT, web services) refer to other files or addresses:
 * all drivers but these are switched off.
 */
const kDrivers = ['ESRI Shapefile', 'GeoJSON', 'GPKG', 'FlatGeobuf', 'LIBKML', 'KML'];
/** A line of `ogr2ogr --formats`: "  ESRI Shapefile -vector- (rw+v): ..." */
const kFormatLine = /^ {2}(.+?) -[a-z, ]+- \(/;
export const kVectorFormats = 'ESRI Shapefile, GeoJSON, GeoPackage, FlatGeobuf or KML';
const kTimeout_ms = 120_000;
const kMaxInput_bytes = 1024 * 1024 * 1024;
const kMaxOutput_bytes = 256 * 1024 * 1024;

export type ReadVectorOptions = {
  /**
   * `EPSG:n` to bring coordinates to; left out, they stay as they are, and files without a CRS can
   * be read.
   */
  readonly crs?: string;
  /** Code of the errors that are thrown. */
  readonly code: ErrorCode;
  /** In messages, such as "read polygon". */
  readonly what: string;
};

/**
 * The features of a vector file with one layer, read by GDAL's ogr2ogr in a process of its own.
 * @throws GrabberError of the given code
 */
export async function readVectorFile(
  file: string,
  options: ReadVectorOptions,
  signal: AbortSignal,
): Promise<VectorFeature[]> {
  const path = await checkedPath(file, options);
  const project = options.crs === undefined ? [] : ['-t_srs', options.crs];
  const args = [
    '-f',
    'GeoJSON',
    '-dim',
    'XY',
    '-lco',
    'COORDINATE_PRECISION=9',
    ...project,
    '/vsistdout/',
    path,
  ];
  const run = { what: `${options.what} ${file}`, code: options.code };
  const text = await runOgr2ogr(args, { OGR_SKIP: await otherDrivers(run, signal) }, run, signal);
  try {
    return collectionSchema.parse(JSON.parse(text)).features;
  } catch (error) {
    const found = `ogr2ogr gave no GeoJSON: ${describeError(error)}`;
    throw new GrabberError(options.code, `${run.what}: ${found}; allowed: ${kVectorFormats}`, {
      cause: error,
    });
  }
}

/**
 * GDAL takes addresses, archives and connection strings for file names; only a file that is there
 * is let through.
 */
async function checkedPath(file: string, { what, code }: ReadVectorOptions): Promise<string> {
  const path = resolve(file);
  const refused = (why: string, cause?: unknown): GrabberError =>
    new GrabberError(
      code,
      `${what} ${file}: ${why}; allowed: a file, ${kVectorFormats}, at most ` +
        `${kMaxInput_bytes} bytes`,
      { cause },
    );
  if (/^\/vsi/i.test(file) || /^\/vsi/i.test(path)) throw refused('a virtual file of GDAL');
  try {
    const found = await stat(path);
    if (!found.isFile()) throw refused('not a file');
    if (found.size > kMaxInput_bytes) throw refused(`${found.size} bytes`);
  } catch (error) {
    if (error instanceof GrabberError) throw error;
    throw refused(systemCode(error) === 'ENOENT' ? 'no such file' : describeError(error), error);
  }
  return path;
}

type Run = { readonly what: string; readonly code: ErrorCode };

/** All drivers but the allowed ones, so that those of future GDAL versions are off as well. */
async function otherDrivers(run: Run, signal: AbortSignal): Promise<string> {
  const lines = (await runOgr2ogr(['--formats'], {}, run, signal)).split('\n');
  const names = lines
    .map((line) => kFormatLine.exec(line)?.[1])
    .filter((name) => name !== undefined);
  return names.filter((name) => !kDrivers.includes(name)).join(',');
}

function runOgr2ogr(
  args: readonly string[],
  env: Readonly<Record<string, string>>,
  { what, code }: Run,
  signal: AbortSignal,
): Promise<string> {
  return new Promise((done, fail) => {
    const limits = {
      env: { ...programEnvironment(tmpdir()), ...env },
      signal,
      timeout: kTimeout_ms,
      maxBuffer: kMaxOutput_bytes,
      killSignal: 'SIGKILL' as const,
    };
    execFile('ogr2ogr', args, { ...limits, encoding: 'utf8' }, (error, stdout, stderr) => {
      if (error === null) return done(stdout);
      if (signal.aborted) return fail(signal.reason as Error);
      // Without its cause, whose message is the whole command line.
      fail(
        new GrabberError(
          code,
          `${what}: ${toReason(error, stderr)}; allowed: ${kVectorFormats}, with one layer`,
        ),
      );
    });
  });
}

function toReason(error: Error & { killed?: boolean }, stderr: string): string {
  if (systemCode(error) === 'ENOENT') return 'the program ogr2ogr (GDAL) is missing';
  if (systemCode(error) === 'ERR_CHILD_PROCESS_STDIO_MAXBUFFER') {
    return `it holds more than ${kMaxOutput_bytes} bytes as GeoJSON`;
  }
  if (error.killed === true) return `ogr2ogr took longer than ${kTimeout_ms / 1000} s`;
  // The list of all drivers follows.
  const message = oneLine(stderr.split(/with the following drivers/i)[0] ?? '').slice(0, 300);
  return message === '' ? describeError(error) : message;
}
