import { findProjection, type Projection } from '../geo/crs.js';
import type { BoundsM } from '../model/square.js';
import { GrabberError } from '../util/errors.js';
import { encodePolygon, type Position } from './geopackage-geometry.js';

/** Encodes squares in metres as polygons in degrees; keeps the projection of each CRS. */
export class FootprintEncoder {
  readonly #projections = new Map<string, Projection | undefined>();

  /**
   * @return GeoPackageBinary, null where the ground is not known: a picture for maps, on which
   * nothing else depends
   */
  polygon(bounds: BoundsM | null, crs: string | null): Buffer | null {
    if (bounds === null || crs === null) return null;
    const projection = this.#projection(crs);
    if (projection === undefined) return null;
    const [west, south, east, north] = bounds;
    const corners = [
      [west, south],
      [east, south],
      [east, north],
      [west, north],
    ] as const;
    let ring: Position[];
    try {
      ring = corners.map((corner) => projection.toDegrees(corner));
    } catch (error) {
      if (error instanceof GrabberError) return null;
      throw error;
    }
    const first = ring[0];
    if (first === undefined || !ring.every(onEarth)) return null;
    return encodePolygon([[...ring, first]]);
  }

  /** Undefined for a CRS without a known projection. */
  #projection(crs: string): Projection | undefined {
    if (this.#projections.has(crs)) return this.#projections.get(crs);
    let found: Projection | undefined;
    try {
      found = findProjection(crs);
    } catch (error) {
      if (!(error instanceof GrabberError)) throw error;
    }
    this.#projections.set(crs, found);
    return found;
  }
}

function onEarth([longitude, latitude]: Position): boolean {
  return Math.abs(longitude) <= 180 && Math.abs(latitude) <= 90;
}
