import type { BoundsM } from '../model/square.js';
import type { Gdal } from './gdal.js';
import { makeTarget, type Target } from './target.js';

const kPointsPerEdge = 8;
const kPad_px = 4;

/**
 * The pixels to request from a server that draws in another CRS than the target's: they enclose it,
 * and are as fine. In the target's own CRS it is the target itself, pixel by pixel.
 */
export async function requestGrid(
  target: Target,
  crs: string,
  gdal: Gdal,
  signal: AbortSignal,
): Promise<Target> {
  if (crs === target.crs) return target;
  const { bounds, stretch } = await boundsIn(target, crs, gdal, signal);
  const step = target.resolution_m * stretch;
  const [west, south, east, north] = bounds;
  const pad = kPad_px * step;
  return makeTarget([west - pad, south - pad, east + pad, north + pad], crs, step, 0);
}

/**
 * @return the box of the target in another CRS, and how many of its units a metre of the target has
 */
export async function boundsIn(
  target: Target,
  crs: string,
  gdal: Gdal,
  signal: AbortSignal,
): Promise<{ bounds: BoundsM; stretch: number }> {
  if (crs === target.crs) return { bounds: target.bounds, stretch: 1 };
  const [west, south, east, north] = target.bounds;
  const ring: [number, number][] = [];
  for (let i = 0; i < kPointsPerEdge; ++i) {
    const t = i / kPointsPerEdge;
    const x = west + (east - west) * t;
    const y = south + (north - south) * t;
    ring.push([x, south], [east, y], [east - (x - west), north], [west, north - (y - south)]);
  }
  const projected = await gdal.transform(ring, target.crs, crs, signal);
  const xs = projected.map(([x]) => x);
  const ys = projected.map(([, y]) => y);
  // Along the southern edge, so that a turned grid is not taken for a coarse one.
  const first = projected[0] ?? [0, 0];
  const corner = projected[1] ?? [0, 0];
  const stretch = Math.hypot(corner[0] - first[0], corner[1] - first[1]) / (east - west);
  return { bounds: [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)], stretch };
}
