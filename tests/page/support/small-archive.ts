import { ArchiveSource } from '../../../voxelserver/serve/page/src/viewer/data/archive-source.js';
import type {
  ColumnKey,
  BoxSource,
  Column,
} from '../../../voxelserver/serve/page/src/viewer/data/columns.js';
import type { DataError } from '../../../voxelserver/serve/page/src/http/errors.js';
import { toName } from './columns.js';
import { kOpen, FakeHost } from './fake-host.js';
import { makeArchive, type ArchiveOptions, type TestBox } from './make-archive.js';
import type { Voxel } from './make-box.js';

/** A small archive of all that an archive may hold, on a fake host, and its columns. */

export const kVoxels: Voxel[] = [
  { x: 0, y: 0, z: 0, material: 4 },
  { x: 63, y: 255, z: 63, material: 32, rgb: [1, 2, 3] },
  { x: 5, y: 70, z: 6, material: 13, rgb: [255, 0, 128] },
  { x: 6, y: 70, z: 6, material: 0 },
  { x: 5, y: 130, z: 40, material: 200, rgb: [9, 9, 9] },
  { x: 5, y: 131, z: 40, material: 33 },
];

export const kBoxes: TestBox[] = [
  { key: [0, 0, 0, 0], voxels: kVoxels },
  { key: [0, 0, -1, 0], voxels: [{ x: 1, y: 2, z: 3, material: 4 }] },
  { key: [0, 1, 0, 1], hole: 'the disk\nwas wet' },
  { key: [0, -1, 0, -2], voxels: [{ x: 9, y: 9, z: 9, material: 5, rgb: [1, 1, 1] }] },
  { key: [1, 0, 0, 0], voxels: [{ x: 7, y: 7, z: 7, material: 6 }] },
  { key: [2, 0, 0, 0], voxels: [{ x: 3, y: 200, z: 3, material: 7 }] },
];

export const kColumns: ColumnKey[] = [2, 1, 0].flatMap((level) => {
  const side = 4 >> level;
  const places = Array.from({ length: side }, (_, i) => i - side / 2 || 0).map(Math.floor);
  return places.flatMap((bx) => places.map((bz) => ({ level, bx, bz })));
});
kColumns.push({ level: 2, bx: 0, bz: 0 });

export const makeHost = (bytes: Uint8Array): FakeHost => new FakeHost({ 'http://host/a': bytes });

export const archiveHost = (options?: ArchiveOptions, boxes = kBoxes): FakeHost =>
  makeHost(makeArchive(boxes, options));

/** Boxes side by side to the east, and facts of their world. */
export function makeRow(
  count: number,
  levels: number,
): { facts: Record<string, unknown>; boxes: TestBox[] } {
  const boxes = Array.from({ length: count }, (_, bx): TestBox => {
    return { key: [0, bx, 0, 0], voxels: [{ x: bx, y: 0, z: 0, material: 4 }] };
  });
  return { facts: { bounds: { min: [0, 0, 0], max: [64 * count, 256, 64] }, levels }, boxes };
}

export async function collect(
  host: FakeHost,
  source: BoxSource,
  columns: readonly ColumnKey[],
): Promise<Map<string, Column | DataError>> {
  const found = new Map<string, Column | DataError>();
  const work = async (): Promise<void> => {
    for await (const result of source.columns(columns, kOpen)) {
      if ('column' in result) found.set(toName(result.column), result.column);
      else found.set(toName(result.failed), result.error);
    }
  };
  await host.clock.finish(work());
  return found;
}

export const readColumns = async (host: FakeHost, columns = kColumns): ReturnType<typeof collect> =>
  collect(host, new ArchiveSource(await host.open(), host.clock), columns);
