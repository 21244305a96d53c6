import type { Vec2 } from './vec3.js';
import proj4 from 'proj4';
import type { World } from './replies.js';

export type LatLon = { readonly latDeg: number; readonly lonDeg: number };

/** Worlds wider than two such squares of the map have another sun in each square. */
const kSquareM = 10_000;
const kDegreesPerHour = 15;

/**
 * The world's space: CRS coordinates (easting, northing in CRS units), voxels (x east, z south)
 * and, where the CRS is supported, latitude and longitude. All functions are pure.
 */
export class WorldProjection {
  readonly world: World;
  /**
   * Horizontal metres in a unit of the CRS, true at this place (also where the CRS stretches, as
   * EPSG:3857 does).
   */
  readonly metresPerUnit: number;
  /** west, south, east, north in CRS units */
  readonly extent: [number, number, number, number];
  /** The same of what to show first. */
  readonly framedExtent: [number, number, number, number];
  readonly #geographic: proj4.Converter | undefined;

  constructor(world: World) {
    this.world = world;
    const u = world.unitsPerVoxel;
    this.metresPerUnit = world.voxelM / u;
    this.extent = [world.min[0] * u, -world.max[2] * u, world.max[0] * u, -world.min[2] * u];
    const { min, max } = world.framed;
    this.framedExtent = [min[0] * u, -max[2] * u, max[0] * u, -min[2] * u];
    this.#geographic = chooseGeographic(world, this.centre());
  }

  centre(): [number, number] {
    const [west, south, east, north] = this.extent;
    return [(west + east) / 2, (south + north) / 2];
  }

  /** @return voxel x and z */
  toVoxel(easting: number, northing: number): [number, number] {
    const u = this.world.unitsPerVoxel;
    return [Math.floor(easting / u), Math.floor(-northing / u)];
  }

  /** CRS units in a pixel of the top view at a zoom; one pixel is 2^(finest - zoom) voxels. */
  resolution(zoom: number): number {
    return this.world.unitsPerVoxel * 2 ** (this.world.finestZoom - zoom);
  }

  /** West, south, east, north of the footprint of box (bx, bz) of a level, CRS units. */
  boxExtent(level: number, bx: number, bz: number): [number, number, number, number] {
    const side = 64 * 2 ** level * this.world.unitsPerVoxel;
    return [bx * side, 0 - (bz + 1) * side, (bx + 1) * side, 0 - bz * side];
  }

  toLatLon(easting: number, northing: number): LatLon | undefined {
    const [lonDeg, latDeg] = this.#geographic?.inverse([easting, northing]) ?? [];
    return lonDeg !== undefined &&
      latDeg !== undefined &&
      Number.isFinite(lonDeg) &&
      Number.isFinite(latDeg)
      ? { latDeg, lonDeg }
      : undefined;
  }

  /**
   * Hours that the clocks of an analysis are ahead of UTC: those of the longitude, without summer
   * time. As for the sun (raytracer/analyse/raster/cell_grid.cpp), it is the middle of the world
   * that counts, or in a wide world that of the square that holds the middle of the part.
   */
  clockOffsetH([west, south, east, north]: readonly [number, number, number, number]):
    number | undefined {
    const { centre, crsWkt } = this.world;
    if (centre === undefined) return undefined;
    const [w, s, e, n] = this.extent;
    const square = kSquareM / this.metresPerUnit;
    if (crsWkt === '' || Math.max(e - w, n - s) <= 2 * square) return hoursAhead(centre.lonDeg);
    const middle = (at: number): number => (Math.floor(at / square) + 0.5) * square;
    // Voxels go south, so that a middle on the border of two squares belongs to the southern one.
    const place = this.toLatLon(middle((west + east) / 2), -middle(-(south + north) / 2));
    return place && hoursAhead(place.lonDeg);
  }

  fromLatLon({ latDeg, lonDeg }: LatLon): [number, number] | undefined {
    const [e, n] = this.#geographic?.forward([lonDeg, latDeg]) ?? [];
    return e !== undefined && n !== undefined && Number.isFinite(e) && Number.isFinite(n)
      ? [e, n]
      : undefined;
  }
}

/** Rounds halves away from zero, as the server does, and has no negative zero. */
function hoursAhead(lonDeg: number): number {
  const hours = Math.floor(Math.abs(lonDeg) / kDegreesPerHour + 0.5);
  return lonDeg < 0 ? 0 - hours : hours;
}

/** Of a compound CRS the horizontal part, which is all that proj4 reads; anything else as it is. */
export function horizontalWkt(wkt: string): string {
  if (!/^\s*(COMPOUNDCRS|COMPD_CS)\s*\[/.test(wkt)) return wkt;
  const start = wkt.search(/\b(PROJCRS|PROJECTEDCRS|PROJCS|BOUNDCRS|DERIVEDPROJCRS)\s*\[/);
  if (start < 0) return wkt;
  let depth = 0;
  let quoted = false;
  for (let i = start; i < wkt.length; ++i) {
    const c = wkt[i];
    if (c === '"') quoted = !quoted;
    else if (!quoted && c === '[') ++depth;
    else if (!quoted && c === ']') --depth;
    if (depth === 0 && c === ']') return wkt.slice(start, i + 1);
  }
  return wkt;
}

/**
 * A converter between WGS 84 and the world's CRS. WKT 2 names the datum, while a PROJ string of
 * current GDAL versions lacks its shift (Amersfoort by 114 m, OSGB36 by 125 m); so both are tried,
 * and the one nearest to the server's own latitude and longitude of the centre is used, or the WKT
 * when the server has none.
 */
function chooseGeographic(world: World, centre: Vec2): proj4.Converter | undefined {
  let best: { readonly converter: proj4.Converter; readonly errorDeg: number } | undefined;
  for (const definition of [horizontalWkt(world.crsWkt), world.crsProj4]) {
    if (definition === '') continue;
    try {
      const converter = proj4('EPSG:4326', definition);
      const [lonDeg, latDeg] = converter.inverse([centre[0], centre[1]]);
      const errorDeg = measureError(world, latDeg, lonDeg);
      if (errorDeg <= kLargestErrorDeg && (best === undefined || errorDeg < best.errorDeg)) {
        best = { converter, errorDeg };
      }
    } catch {
      // Not supported: the next definition is tried, or the map has no latitude and longitude.
    }
  }
  return best?.converter;
}

const kLargestErrorDeg = 0.01; // about a kilometre: more is another CRS, not another datum

function measureError(world: World, latDeg: number, lonDeg: number): number {
  if (!Number.isFinite(latDeg) || !Number.isFinite(lonDeg)) return Infinity;
  if (world.centre === undefined) return 0;
  const east = (lonDeg - world.centre.lonDeg) * Math.cos((latDeg * Math.PI) / 180);
  return Math.hypot(east, latDeg - world.centre.latDeg);
}
