import crsCases from './crs.json';
import { boxBytes } from './make-archive.js';
import type { Voxel } from './make-box.js';
import { makePng } from './make-png.js';

/** A synthetic world of 1024 x 1024 m in EPSG:3794, as a voxel server describes it. */

export const kCrs = crsCases[0]!;
export const kMin = [462000, 200, -102024] as const;
export const kMax = [463024, 640, -101000] as const;
export const kLevels = 6;
const kTilePx = 256;

export const heightAt = (x: number, z: number): number =>
  300 + Math.floor(40 * Math.sin(x / 90) * Math.cos(z / 120));

export function worldJson(title: string): unknown {
  return {
    version: 1,
    software: 'terravox 0.1.0',
    title,
    bounds: { min: kMin, max: kMax },
    voxel_m: 1,
    box: [64, 256, 64],
    levels: kLevels,
    crs: 'EPSG:3794',
    crs_wkt: kCrs.wkt,
    crs_proj4: kCrs.proj4,
    crs_units_per_voxel: 1,
    materials: ['air', 'rock', 'soil', 'ground', 'grass', 'low_vegetation'],
    licence: 'CC BY 4.0',
    attribution: 'Synthetic Survey Office <b>2026</b>',
    centre: { lat_deg: 46.0478, lon_deg: 14.5155, convergence_deg: -0.3488 },
    map: { tile_px: kTilePx, zooms: [0, kLevels - 1] },
  };
}

/**
 * @return a tile of the top view; outside the world transparent. @param whole false: only its upper
 * half is made
 */
export function tilePng(zoom: number, tx: number, ty: number, whole: boolean): Buffer {
  const voxels = 2 ** (kLevels - 1 - zoom);
  return makePng(kTilePx, (px, py) => {
    const [x, z] = [(tx * kTilePx + px) * voxels, (ty * kTilePx + py) * voxels];
    const inside = x >= kMin[0] && x < kMax[0] && z >= kMin[2] && z < kMax[2];
    if (!inside || (!whole && py >= kTilePx / 2)) return [0, 0, 0, 0];
    const light = 0.75 + (heightAt(x, z) - heightAt(x - 4, z - 4)) / 12;
    const [r, g, b] = heightAt(x, z) < 275 ? [60, 110, 160] : [110, 150, 80];
    return [Math.min(255, r * light), Math.min(255, g * light), Math.min(255, b * light), 255];
  });
}

/** @return a box, undefined for air */
export function boxFrame(bx: number, by: number, bz: number): Uint8Array | undefined {
  const voxels: Voxel[] = [];
  for (let z = 0; z < 64; ++z) {
    for (let x = 0; x < 64; ++x) {
      const y = heightAt(bx * 64 + x, bz * 64 + z) - by * 256;
      if (y >= 0 && y < 256) voxels.push({ x, y, z, material: 4, rgb: [80, 120, 60] });
    }
  }
  return voxels.length === 0 ? undefined : boxBytes([0, bx, by, bz], voxels);
}

export type SquareRow = {
  readonly name: string;
  readonly state: string;
  readonly licence?: string;
  readonly error?: string;
};

/** Squares of 512 m, row by row from the north-west. */
export function squaresJson(rows: readonly SquareRow[]): unknown {
  return {
    type: 'FeatureCollection',
    crs: 'EPSG:3794',
    features: rows.map((row, i) => {
      const [west, north] = [kMin[0] + 512 * (i % 2), -kMin[2] - 512 * Math.floor(i / 2)];
      const ring = [
        [west, north],
        [west + 512, north],
        [west + 512, north - 512],
        [west, north - 512],
        [west, north],
      ];
      return {
        type: 'Feature',
        geometry: { type: 'Polygon', coordinates: [ring] },
        properties: {
          name: row.name,
          state: row.state,
          file: row.state === 'wanted' ? null : `${row.name}.laz`,
          points: row.state === 'prepared' ? 2_345_678 : null,
          density_per_m2: row.state === 'prepared' ? 8.95 : null,
          bytes: 12_345_678,
          source: 'Synthetic Survey Office',
          licence: row.licence ?? 'CC BY 4.0',
          attribution: 'Synthetic Survey Office',
          error: row.error ?? null,
        },
      };
    }),
  };
}
