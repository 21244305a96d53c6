import type { RecordKey } from '../model/square.js';
import type { Verified } from '../model/store.js';

/** Only the key's own fields, whatever else the object has. */
export function toKey(key: RecordKey): { source: string; grid: string; name: string } {
  return { source: key.source, grid: key.grid, name: key.name };
}

/** What was found in a file, as columns. */
export function toFacts({
  points,
  image,
  crs,
  warnings,
}: Verified): Record<string, string | number | null> {
  return {
    point_count: points?.pointCount ?? null,
    las_version: points?.lasVersion ?? null,
    point_format: points?.pointFormat ?? null,
    min_x: points?.min[0] ?? null,
    min_y: points?.min[1] ?? null,
    min_z: points?.min[2] ?? null,
    max_x: points?.max[0] ?? null,
    max_y: points?.max[1] ?? null,
    max_z: points?.max[2] ?? null,
    image_width_px: image?.width_px ?? null,
    image_height_px: image?.height_px ?? null,
    image_resolution_m: image?.resolution_m ?? null,
    image_margin_m: image?.margin_m ?? null,
    crs,
    warnings: JSON.stringify(warnings),
  };
}
