import { z } from 'zod';
import type { Point } from '../geo/crs.js';
import type { Polygon } from '../geo/polygon.js';
import { readVectorFile, type VectorFeature } from '../geo/vector-file.js';
import { GrabberError } from '../util/errors.js';

const kMaxPoints = 1_000_000;

const ringSchema = z
  .array(z.tuple([z.number().min(-180).max(180), z.number().min(-90).max(90)]).rest(z.unknown()))
  .min(4);
const polygonSchema = z.array(ringSchema).min(1);

/**
 * All polygons of a vector file, in degrees.
 * @throws GrabberError POLYGON_FILE, also for features that are no polygons
 */
export async function readPolygonFile(file: string, signal: AbortSignal): Promise<Polygon[]> {
  const features = await readVectorFile(
    file,
    { crs: 'EPSG:4326', code: 'POLYGON_FILE', what: 'read polygon' },
    signal,
  );
  const polygons = features.flatMap((feature, index) => toPolygons(feature, file, index));
  const points = polygons.flat().reduce((sum, ring) => sum + ring.length, 0);
  if (polygons.length === 0) throw refused(file, 'it holds no features', 'at least one polygon');
  if (points > kMaxPoints) throw refused(file, `${points} points`, `at most ${kMaxPoints}`);
  return polygons;
}

/** @return the coordinates of each polygon; undefined for any other geometry */
function listParts({ geometry }: VectorFeature): unknown[] | undefined {
  if (geometry?.type === 'Polygon') return [geometry.coordinates];
  if (geometry?.type !== 'MultiPolygon' || !Array.isArray(geometry.coordinates)) return undefined;
  return geometry.coordinates as unknown[];
}

function toPolygons(feature: VectorFeature, file: string, index: number): Polygon[] {
  const raw = listParts(feature);
  if (raw === undefined) {
    throw refused(
      file,
      `feature ${index + 1} is ${feature.geometry?.type ?? 'without a geometry'}`,
      'Polygon or MultiPolygon',
    );
  }
  return raw.map((one) => {
    const parsed = polygonSchema.safeParse(one);
    if (!parsed.success) {
      throw refused(
        file,
        `feature ${index + 1} has rings that are none`,
        'rings of at least 4 points in degrees',
      );
    }
    return parsed.data.map((ring) => ring.map(([x, y]): Point => [x, y]));
  });
}

function refused(file: string, found: string, allowed: string): GrabberError {
  return new GrabberError('POLYGON_FILE', `read polygon ${file}: ${found}; allowed: ${allowed}`);
}
