import type { Api } from './http/api.js';
import { DataError } from './http/errors.js';
import { kServerTimeoutMs } from './http/http.js';
import {
  findTop,
  kBoxSize,
  readBoxArrays,
  type BoxKey,
  type TopVoxel,
  type VoxelLook,
} from './viewer/data/box-arrays.js';
import { isFields } from './json.js';
import { isInside } from './coordinates.js';
import type { WorldProjection } from './world-projection.js';

/** What is on top of a column of voxels. */
export type Top = { readonly heightM: number; readonly look: VoxelLook | undefined };

const [kBoxSide, kBoxHeight] = kBoxSize;
const kMostBoxes = 64;

/** Looks into the boxes above a place, highest first, until something is solid. */
export class TopFinder {
  readonly #api: Api;
  readonly #projection: WorldProjection;

  constructor(api: Api, projection: WorldProjection) {
    this.#api = api;
    this.#projection = projection;
  }

  /** @return undefined where there is only air. @throws DataError */
  async find(easting: number, northing: number): Promise<Top | undefined> {
    if (!isInside(easting, northing, this.#projection)) return undefined;
    const [x, z] = this.#projection.toVoxel(easting, northing);
    const [bx, bz] = [Math.floor(x / kBoxSide), Math.floor(z / kBoxSide)];
    const extent = await this.#api.getJson(`v2/columns/0/${bx}/${bz}`);
    const [begin, end] = isFields(extent)
      ? [Number(extent['by_begin']), Number(extent['by_end'])]
      : [0, 0];
    for (let by = end - 1; by >= begin && end - by <= kMostBoxes; --by) {
      const reply = await this.#api.get(`v2/boxes/0/${bx}/${by}/${bz}`, kServerTimeoutMs);
      if (reply.status === 204) continue;
      const top = readTop(
        await reply.bytes(),
        { level: 0, bx, by, bz },
        x - bx * kBoxSide,
        z - bz * kBoxSide,
      );
      if (top !== undefined) {
        return {
          heightM: (by * kBoxHeight + top.y + 1) * this.#projection.world.voxelM,
          look: top.look,
        };
      }
    }
    return undefined;
  }
}

function readTop(bytes: Uint8Array, key: BoxKey, x: number, z: number): TopVoxel | undefined {
  try {
    return findTop(readBoxArrays(bytes, key), x, z);
  } catch (error) {
    const what = 'The box above this place could not be read.';
    throw new DataError('damaged', what, { cause: error });
  }
}
