import { readdir, stat } from 'node:fs/promises';
import { join, relative } from 'node:path';
import type { ServerResponse } from 'node:http';
import { sendPortalFile } from './files.js';
import { toUrl, type PortalHandler } from './portal.js';

export type PortalSquare = {
  /** `E_N` in kilometres. */
  readonly name: string;
  readonly east_km: number;
  readonly north_km: number;
  /** Relative to the root, with forward slashes. */
  readonly path: string;
  readonly bytes: number;
  /** As the survey of si-lss has them: b_11 to b_37. */
  readonly block: string;
};

const kSquareFile = /(\d{1,4})_(\d{1,4})[^/]*\.(laz|las|zip)$/i;

/**
 * Every point cloud below a folder whose name holds a place, from south to north, then west to
 * east.
 */
export async function scanSquares(root: string): Promise<PortalSquare[]> {
  const squares: PortalSquare[] = [];
  for (const entry of await readdir(root, { recursive: true, withFileTypes: true })) {
    const match = entry.isFile() ? kSquareFile.exec(entry.name) : null;
    if (match === null) continue;
    const path = join(entry.parentPath, entry.name);
    const [east_km, north_km] = [Number(match[1]), Number(match[2])];
    squares.push({
      name: `${east_km}_${north_km}`,
      east_km,
      north_km,
      path: relative(root, path).replaceAll('\\', '/'),
      bytes: (await stat(path)).size,
      block: makeBlockName(east_km, north_km),
    });
  }
  return squares.sort((a, b) => a.north_km - b.north_km || a.east_km - b.east_km);
}

/** Synthetic: strips of 20 km, so that neighbours mostly share a block. */
export function makeBlockName(east_km: number, north_km: number): string {
  return `b_${11 + ((Math.floor(east_km / 20) + Math.floor(north_km / 20) * 5) % 27)}`;
}

/**
 * Files in folders of survey blocks with listings, as ARSO has them:
 * /lidar/gkot/laz/{block}/D96TM/TM_{E}_{N}.laz
 */
export const arsoHandler: PortalHandler = async (request, response, context) => {
  const { pathname, searchParams } = toUrl(request);
  const match = /^\/lidar\/gkot\/laz\/(?:(b_\d\d)\/(?:D96TM\/(?:TM_(\d+)_(\d+)\.laz)?)?)?$/.exec(
    pathname,
  );
  if (match === null) return false;
  const [, block, east, north] = match;
  if (block === undefined) {
    return sendListing(response, pathname, [
      ...new Set(context.squares.map((square) => `${square.block}/`)),
    ]);
  }
  const squares = context.squares.filter((square) => square.block === block);
  if (squares.length === 0) return false;
  if (east === undefined) {
    if (!pathname.endsWith('D96TM/')) return sendListing(response, pathname, ['D96TM/']);
    return sendListing(
      response,
      pathname,
      squares.map((square) => `TM_${square.name}.laz`),
    );
  }
  const square = squares.find((one) => one.name === `${east}_${north ?? ''}`);
  if (square === undefined) return false;
  return sendPortalFile(
    square.path,
    pathname,
    searchParams.has('direct'),
    request,
    response,
    context,
  );
};

function sendListing(response: ServerResponse, path: string, names: readonly string[]): true {
  const rows = names.map((name) => `<A HREF="${path}${name}">${name}</A><br>`).join('\n');
  response
    .writeHead(200, { 'content-type': 'text/html' })
    .end(`<html><head><title>${path}</title></head><body><pre>${rows}</pre></body></html>`);
  return true;
}
