import { link } from 'node:fs/promises';
import { join } from 'node:path';
import type { BoundsM } from '../model/store.js';
import { GrabberError } from '../util/errors.js';
import { runAll, type AssetCache } from './download.js';
import { writeWorldFile } from './gdal.js';
import { probeImage, type Gather, type Piece } from './piece.js';
import { boundsIn } from './target.js';
import type { OrthoSource, TemplateAccess } from './schema.js';

const kMaxSquares = 400;

/** Pictures that each have an address: those of all squares that the target touches. */
export function templateGather(
  source: OrthoSource,
  access: TemplateAccess,
  cache: AssetCache,
): Gather {
  return async (target, context, signal) => {
    const { bounds } = await boundsIn(target, source.crs, context.gdal, signal);
    const squares = listSquares(bounds, access.square_m);
    const pieces = await runAll(
      squares.map((square) => async (signal: AbortSignal): Promise<Piece | undefined> => {
        const url = squareUrl(access.url, square, access.square_m);
        const whole = await cache.get(url, context.download, signal);
        if (whole === undefined) return undefined;
        const probe = await probeImage(whole, url, context.gdal, signal);
        const { kind, channels } = probe;
        if (access.place === 'file') return { path: whole, kind, channels, crs: source.crs };
        const path = join(context.folder, `square-${square[0]}-${square[1]}.${kind.extension}`);
        await link(whole, path);
        const [west, south] = square;
        await writeWorldFile(
          path,
          kind,
          [west, south, west + access.square_m, south + access.square_m],
          probe.width_px,
          probe.height_px,
        );
        return { path, kind, channels, crs: source.crs };
      }),
      context.concurrency,
      signal,
    );
    const found = pieces.filter((piece) => piece !== undefined);
    if (found.length === 0) return undefined;
    return {
      pieces: found,
      url: access.url,
      grid: undefined,
      resolution_m: source.resolution_m,
      date: context.time,
      warnings: [],
    };
  };
}

/**
 * {E} {N} kilometres, {x} {y} metres of the south-west corner, {name} = E_N; {x:06} pads with
 * zeros.
 */
export function squareUrl(
  template: string,
  [x, y]: readonly [number, number],
  square_m: number,
): string {
  const E = Math.floor(x / 1000);
  const N = Math.floor(y / 1000);
  const values: Record<string, string | number> = {
    E,
    N,
    x,
    y,
    name: `${E}_${N}`,
    x2: x + square_m,
    y2: y + square_m,
  };
  return template.replace(
    /\{([A-Za-z0-9]+)(?::0(\d))?\}/g,
    (whole, name: string, width: string | undefined) => {
      const value = values[name];
      if (value === undefined) {
        throw new GrabberError(
          'TEMPLATE',
          `expand url template "${template}": ${whole}; allowed: ${Object.keys(values)
            .map((one) => `{${one}}`)
            .join(' ')}`,
        );
      }
      return String(value).padStart(Number(width ?? 0), '0');
    },
  );
}

function listSquares([west, south, east, north]: BoundsM, square_m: number): [number, number][] {
  const columns = [Math.floor(west / square_m), Math.ceil(east / square_m)] as const;
  const rows = [Math.floor(south / square_m), Math.ceil(north / square_m)] as const;
  const count = (columns[1] - columns[0]) * (rows[1] - rows[0]);
  if (count > kMaxSquares) {
    throw new GrabberError(
      'ORTHO',
      `gather pictures of ${square_m} m: ${count} of them; allowed: at most ` +
        `${kMaxSquares} a square`,
    );
  }
  const found: [number, number][] = [];
  for (let y = rows[0]; y < rows[1]; ++y) {
    for (let x = columns[0]; x < columns[1]; ++x) found.push([x * square_m, y * square_m]);
  }
  return found;
}
