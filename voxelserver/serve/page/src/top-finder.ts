import type { Api } from './http/api.js';
import { kServerTimeoutMs } from './http/http.js';
import {
  findTop as findTopOfBox,
  kBoxSize,
  readBoxArrays,
  type VoxelLook,
} from './viewer/data/box-arrays.js';
import { isFields } from './json.js';
import { isInside } from './coordinates.js';
import type { WorldProjection } from './world-projection.js';

/** What is on top of a column of voxels. */
export type Top = { readonly heightM: number; readonly look: VoxelLook | undefined };

const [kBoxSide, kBoxHeight] = kBoxSize;
const kMostBoxes = 64;

/**
 * Looks into the boxes above a place, highest first, until something is solid.
 * @return undefined where there is only air
 * @throws DataError of the requests, and of a box that cannot be read
 */
export async function findTop(
  api: Api,
  projection: WorldProjection,
  easting: number,
  northing: number,
): Promise<Top | undefined> {
  if (!isInside(easting, northing, projection)) return undefined;
  const [x, z] = projection.toVoxel(easting, northing);
  const [bx, bz] = [Math.floor(x / kBoxSide), Math.floor(z / kBoxSide)];
  const extent = await api.getJson(`v2/columns/0/${bx}/${bz}`);
  const [begin, end] = isFields(extent)
    ? [Number(extent['by_begin']), Number(extent['by_end'])]
    : [0, 0];
  for (let by = end - 1; by >= begin && end - by <= kMostBoxes; --by) {
    const reply = await api.get(`v2/boxes/0/${bx}/${by}/${bz}`, kServerTimeoutMs);
    if (reply.status === 204) continue;
    const box = readBoxArrays(await reply.bytes(), { level: 0, bx, by, bz });
    const top = findTopOfBox(box, x - bx * kBoxSide, z - bz * kBoxSide);
    if (top === undefined) continue;
    return {
      heightM: (by * kBoxHeight + top.y + 1) * projection.world.voxelM,
      look: top.look,
    };
  }
  return undefined;
}
