/**
 * The table by which walk.glsl finds the boxes of a place: a hash table of the columns of the
 * effective cut, and behind it the list of boxes of each leaf. Built anew when the cut changes,
 * which is a few thousand entries.
 */

/** A column as its table entry: the boxes of a leaf from the bottom up, or a split column. */
export type CutColumn = {
  readonly level: number;
  readonly bx: number;
  readonly bz: number;
  /** undefined: split into its four halves. */
  readonly boxes: { readonly byBegin: number; readonly slots: readonly BoxSlot[] } | undefined;
};

/** Where a box lies in the pools: indices of its first cell and attribute. */
export type BoxSlot =
  | { readonly kind: 'air' }
  | { readonly kind: 'hole' }
  | { readonly kind: 'box'; readonly cells: number; readonly attributes: number };

export type ColumnTable = {
  /** RGBA32UI, 256 texels wide; a power of two of entries. */
  readonly columns: Uint32Array;
  readonly mask: number;
  /** RGBA32UI, 1024 texels wide, whole rows. */
  readonly boxes: Uint32Array;
};

const kLeaf = 1;
const kSplit = 2;
const kStates = { air: 0, box: 1, hole: 2 } as const;
const kColumnsRow = 256;
const kBoxesRow = 1024;
const kMaxProbes = 64; // as in walk.glsl

/** As hashColumn() of walk.glsl. */
export function hashColumn(bx: number, bz: number, level: number): number {
  let h = Math.imul(bx, 0x9e3779b1) ^ Math.imul(bz, 0x85ebca77) ^ Math.imul(level, 0xc2b2ae3d);
  h ^= h >>> 15;
  h = Math.imul(h, 0x2c1b3c6d);
  return (h ^ (h >>> 12)) >>> 0;
}

export function makeColumnTable(cut: readonly CutColumn[]): ColumnTable {
  let size = kColumnsRow;
  while (size < cut.length * 2) size *= 2;
  for (; ; size *= 2) {
    const table = tryTable(cut, size);
    if (table !== undefined) return table;
  }
}

// Fails where a search would take more probes than the shader makes.
function tryTable(cut: readonly CutColumn[], size: number): ColumnTable | undefined {
  const mask = size - 1;
  const columns = new Uint32Array(size * 4);
  const boxes: number[] = [];
  for (const column of cut) {
    let at = hashColumn(column.bx, column.bz, column.level) & mask;
    let probes = 1;
    while (columns[at * 4 + 2] !== 0) {
      at = (at + 1) & mask;
      probes += 1;
      if (probes > kMaxProbes) return undefined;
    }
    const kind = column.boxes === undefined ? kSplit : kLeaf;
    columns.set([column.bx, column.bz, column.level | (kind << 8), boxes.length / 4], at * 4);
    if (column.boxes === undefined) continue;
    boxes.push(column.boxes.byBegin, column.boxes.slots.length, 0, 0);
    for (const slot of column.boxes.slots) {
      const [cells, attributes] = slot.kind === 'box' ? [slot.cells, slot.attributes] : [0, 0];
      boxes.push(kStates[slot.kind], cells, attributes, 0);
    }
  }
  const rows = Math.max(1, Math.ceil(boxes.length / (kBoxesRow * 4)));
  const padded = new Uint32Array(rows * kBoxesRow * 4);
  padded.set(boxes);
  return { columns, mask, boxes: padded };
}
