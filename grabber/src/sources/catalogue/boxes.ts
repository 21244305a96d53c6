import { intersectBounds } from '../../geo/bounds.js';
import type { BoundsM } from '../../model/square.js';
import type { Region } from '../../model/store.js';
import type { Source } from '../source.js';
import { parseSquare } from '../square.js';
import { boundsOfSquare } from '../naming.js';

/**
 * Up to this number of distant squares are requested one by one, rather than everything between
 * them.
 */
const kMaxSingles = 50;
const kSpread = 8;

/** The boxes to request from a catalogue, within the source's extent. */
export function listBoxes(region: Region, source: Source): BoundsM[] {
  const whole = intersectBounds(region.bounds, source.extent_m);
  if (whole === undefined) return [];
  const size = source.square_m;
  const names = region.names;
  if (size === undefined || names === undefined || names.size > kMaxSingles) return [whole];
  const between = ((whole[2] - whole[0]) / size) * ((whole[3] - whole[1]) / size);
  if (between <= kSpread * names.size) return [whole];
  return [...names].map(
    (name) =>
      boundsOfSquare(parseSquare(name, { square_m: size, extent_m: source.extent_m }), size) ??
      whole,
  );
}
