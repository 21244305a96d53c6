import { createRequire } from 'node:module';
import type { BoundsM } from '../model/square.js';
import { encodePolygon, type Position } from './geopackage-geometry.js';

const kLoad = createRequire(import.meta.url);
type ToDegrees = (position: [number, number]) => Position;

/** Loaded when the first polygon is made: commands that only read the store start faster without. */
function loadTransform(crs: string): ToDegrees | undefined {
  const code = /^EPSG:(\d{4,6})$/.exec(crs)?.[1];
  if (code === undefined) return undefined;
  let definition: { proj4?: unknown };
  try {
    definition = kLoad(`epsg-index/s/${code}.json`) as typeof definition;
  } catch {
    return undefined; // the index does not have it
  }
  if (typeof definition.proj4 !== 'string') return undefined;
  const proj4 = kLoad('proj4') as (from: string) => { inverse(position: [number, number]): [number, number] };
  const converter = proj4(definition.proj4);
  return (position) => converter.inverse(position);
}

/** Makes polygons in degrees of squares in metres; keeps what it has learnt of each CRS. */
export class Ground {
  readonly #transforms = new Map<string, ToDegrees | undefined>();

  /** @return GeoPackageBinary, null where the ground is not known: a picture for maps, on which nothing else depends */
  polygon(bounds: BoundsM | null, crs: string | null): Buffer | null {
    if (bounds === null || crs === null) return null;
    if (!this.#transforms.has(crs)) this.#transforms.set(crs, loadTransform(crs));
    const toDegrees = this.#transforms.get(crs);
    if (toDegrees === undefined) return null;
    const [west, south, east, north] = bounds;
    const ring: Position[] = [
      toDegrees([west, south]),
      toDegrees([east, south]),
      toDegrees([east, north]),
      toDegrees([west, north]),
    ];
    const first = ring[0];
    if (first === undefined || !ring.every(onEarth)) return null;
    return encodePolygon([[...ring, first]]);
  }
}

function onEarth([longitude, latitude]: Position): boolean {
  return Math.abs(longitude) <= 180 && Math.abs(latitude) <= 90;
}
