import { readdir, stat } from 'node:fs/promises';
import { join, relative } from 'node:path';

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
