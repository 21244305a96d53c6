/**
 * Boxes of version 1 as the server sends them, for tests: made independently of the page's reader.
 */

export type Voxel = {
  readonly x: number;
  readonly y: number;
  readonly z: number;
  readonly material: number;
  readonly rgb?: readonly [number, number, number];
};

type Cell = { mask: bigint; detail: bigint; first: number };
type Path = readonly [number, number, number, number];

const childBit = (x: number, y: number, z: number, shift: number): number =>
  ((x >> shift) & 3) + 4 * ((z >> shift) & 3) + 16 * ((y >> shift) & 3);

/**
 * @param solid voxels with attributes. @param hidden whole bricks (4^3) of rock without, by any
 * voxel in them
 */
export function makeBox(
  solid: readonly Voxel[],
  hidden: readonly (readonly [number, number, number])[] = [],
): Uint8Array {
  const toPath = (x: number, y: number, z: number): Path => [
    y >> 6,
    childBit(x, y, z, 4),
    childBit(x, y, z, 2),
    childBit(x, y, z, 0),
  ];
  const voxels = solid
    .map((voxel) => ({ voxel, path: toPath(voxel.x, voxel.y, voxel.z) }))
    .sort((a, b) => comparePaths(a.path, b.path));
  const rock = hidden.map(([x, y, z]) => toPath(x, y, z));
  const cells: Cell[] = [0, 1, 2, 3].map(() => ({ mask: 0n, detail: 0n, first: 0 }));
  let parents = new Map<string, number>([0, 1, 2, 3].map((root) => [String(root), root]));
  for (const depth of [1, 2, 3]) {
    const next = new Map<string, number>();
    for (const [parent, index] of parents) {
      const cell = cells[index]!;
      const bits = new Set(
        voxels
          .filter(({ path }) => path.slice(0, depth).join() === parent)
          .map(({ path }) => path[depth]!),
      );
      for (const bit of bits) cell.detail |= 1n << BigInt(bit);
      cell.mask = cell.detail;
      const rockHere = rock.filter((path) => path.slice(0, depth).join() === parent);
      for (const path of rockHere) {
        const bit = 1n << BigInt(path[depth]!);
        cell.mask |= bit;
        // Rock is whole bricks: the cells above a brick that holds nothing else need detail to lead
        // there.
        if (depth < 2) cell.detail |= bit;
      }
      if (depth === 3) {
        cell.first = voxels.findIndex(({ path }) => path.slice(0, 3).join() === parent);
        if (cell.first < 0) cell.first = 0;
        continue;
      }
      cell.first = cells.length;
      for (let bit = 0; bit < 64; ++bit) {
        if (((cell.detail >> BigInt(bit)) & 1n) === 1n) {
          next.set(`${parent},${bit}`, cells.length);
          cells.push({ mask: 0n, detail: 0n, first: 0 });
        }
      }
    }
    parents = next;
  }
  return serialize(
    cells,
    voxels.map(({ voxel }) => voxel),
  );
}

function comparePaths(a: Path, b: Path): number {
  for (const i of [0, 1, 2, 3] as const) if (a[i] !== b[i]) return a[i] - b[i];
  return 0;
}

function serialize(cells: readonly Cell[], voxels: readonly Voxel[]): Uint8Array {
  const bytes = Buffer.alloc(64 + 24 * cells.length + 8 * voxels.length);
  bytes.write('TVXBOX\r\n', 'latin1');
  bytes.writeUInt32LE(1, 8);
  bytes.writeUInt32LE(cells.length, 28);
  bytes.writeUInt32LE(voxels.length, 32);
  cells.forEach((cell, i) => {
    bytes.writeBigUInt64LE(cell.mask, 64 + 24 * i);
    bytes.writeBigUInt64LE(cell.detail, 72 + 24 * i);
    bytes.writeUInt32LE(cell.first, 80 + 24 * i);
  });
  voxels.forEach(({ material, rgb }, i) => {
    const at = 64 + 24 * cells.length + 8 * i;
    bytes.set([material, 0, rgb ? 1 : 0, 0, ...(rgb ?? [0, 0, 0]), 0], at);
  });
  return bytes;
}
