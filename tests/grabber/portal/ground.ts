import { createRequire } from 'node:module';

// The packages belong to the grabber, and the tests are in another folder: packages are resolved
// from where this file is compiled to.
const load = createRequire(import.meta.url);
const proj4 = load('proj4') as (
  from: string,
  to: string,
) => { forward(point: [number, number]): [number, number] };

export type Box = [west: number, south: number, east: number, north: number];

/** Corners of a box in degrees, counter-clockwise from the south-west, closed. */
export function ringInDegrees(box: Box, crs: string): [number, number][] {
  const definition = load(`epsg-index/s/${crs.replace('EPSG:', '')}.json`) as { proj4: string };
  const transform = proj4(definition.proj4, 'EPSG:4326');
  const [west, south, east, north] = box;
  const corners: [number, number][] = [
    [west, south],
    [east, south],
    [east, north],
    [west, north],
    [west, south],
  ];
  return corners.map((corner) => transform.forward(corner));
}

export function toBox(ring: readonly (readonly [number, number])[]): Box {
  const xs = ring.map(([x]) => x);
  const ys = ring.map(([, y]) => y);
  return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
}

export function overlap(a: Box, b: Box): boolean {
  return a[0] < b[2] && a[2] > b[0] && a[1] < b[3] && a[3] > b[1];
}

export function parseBox(text: string | null): Box | undefined {
  const numbers = (text ?? '').split(',').slice(0, 4).map(Number);
  return numbers.length === 4 && numbers.every(Number.isFinite) ? (numbers as Box) : undefined;
}
