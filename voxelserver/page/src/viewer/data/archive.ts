import {
  LeafIndex,
  readHeader,
  RootIndex,
  type ArchiveHeader,
  type Entry,
  type IndexLimits,
} from './archive-format.js';
import type { BoxKey } from './box-arrays.js';
import { ByteCache } from './byte-cache.js';
import { keysOf, type ColumnKey } from './column-key.js';
import { DataError, within } from './errors.js';
import { boxRange, checkArchiveBounds, isEmpty, readFacts, type Facts } from './facts.js';
import type { RangeFile } from './range-file.js';
import { SharedLoads } from './shared-loads.js';

/**
 * A box archive (docs/formats/box-archive.md) behind range requests: its facts, and where the boxes
 * of a column lie. Memory: the root of the index, up to 32 MiB, and 16 MiB of leaves.
 */

/** A box of a column, or a hole in it. Boxes without an entry are air. */
export type ColumnEntry = Entry & { readonly by: number };

/** Opening reads so much first: of small archives all but the boxes. */
const kHeadBytes = 16 * 1024;
const kLeafCacheBytes = 16 * 1024 * 1024;
const kMaxRememberedFailures = 1024;

export class Archive {
  readonly facts: Facts;
  readonly file: RangeFile;
  readonly #root: RootIndex;
  readonly #limits: IndexLimits;
  readonly #leaves = new ByteCache<number, LeafIndex>(kLeafCacheBytes);
  readonly #loads = new SharedLoads<number, LeafIndex>();
  // Damaged leaves stay damaged: they are not fetched for every one of their columns.
  readonly #damagedLeaves = new Map<number, DataError>();

  private constructor(file: RangeFile, facts: Facts, root: RootIndex, limits: IndexLimits) {
    this.file = file;
    this.facts = facts;
    this.#root = root;
    this.#limits = limits;
  }

  /** @throws DataError; the reason of `signal` */
  static async open(file: RangeFile, signal: AbortSignal): Promise<Archive> {
    const head = await file.head(kHeadBytes, signal);
    const header = readHeader(head, file.name);
    checkSize(header, file);
    const read = async (offset: number, bytes: number): Promise<Uint8Array> =>
      offset + bytes <= head.length
        ? head.subarray(offset, offset + bytes)
        : file.read(offset, bytes, signal);
    const world = readFacts(await read(header.infoOffset, header.infoBytes), file.name);
    checkArchiveBounds(world, file.name);
    const limits: IndexLimits = {
      fileBytes: header.fileBytes,
      hasRoomFor: (key) => key.level < world.levels && !isEmpty(world) && lies(key, world),
    };
    const root = new RootIndex(await read(header.rootOffset, header.rootBytes), limits, file.name);
    return new Archive(file, { world, damage: header.damage }, root, limits);
  }

  /**
   * The boxes of a column, from the bottom up; none where all of it is air.
   * @throws DataError `missing` for a level that the world does not have; others as the index is
   * read; the reason of `signal`
   */
  async column(column: ColumnKey, signal: AbortSignal): Promise<readonly ColumnEntry[]> {
    const leaves = new Map<number, LeafIndex>();
    for (const index of this.#leavesOf(column)) leaves.set(index, await this.#leaf(index, signal));
    return this.#entries(column, leaves);
  }

  /** As column(), where that takes no request; else undefined. */
  knownColumn(column: ColumnKey): readonly ColumnEntry[] | undefined {
    const leaves = new Map<number, LeafIndex>();
    for (const index of this.#leavesOf(column)) {
      const leaf = this.#leaves.get(index);
      if (leaf === undefined) return undefined;
      leaves.set(index, leaf);
    }
    return this.#entries(column, leaves);
  }

  #entries(column: ColumnKey, leaves: ReadonlyMap<number, LeafIndex>): ColumnEntry[] {
    const entries: ColumnEntry[] = [];
    for (const key of keysOf(column, this.facts)) {
      const index = this.#root.leafOf(key);
      const entry = index === undefined ? undefined : leaves.get(index)?.find(key);
      if (entry !== undefined) entries.push({ ...entry, by: key.by });
    }
    return entries;
  }

  #leavesOf(column: ColumnKey): Set<number> {
    const leaves = new Set<number>();
    for (const key of keysOf(column, this.facts)) {
      const index = this.#root.leafOf(key);
      if (index !== undefined) leaves.add(index);
    }
    return leaves;
  }

  async #leaf(index: number, signal: AbortSignal): Promise<LeafIndex> {
    const known = this.#leaves.get(index);
    if (known !== undefined) return known;
    const failure = this.#damagedLeaves.get(index);
    if (failure !== undefined) throw failure;
    return this.#loads.get(index, signal, (shared) => this.#loadLeaf(index, shared));
  }

  async #loadLeaf(index: number, signal: AbortSignal): Promise<LeafIndex> {
    const { offset, bytes } = this.#root.leaf(index);
    const frame = await this.file.read(offset, bytes, signal);
    try {
      const leaf = new LeafIndex(frame, this.#root, index, this.#limits);
      this.#leaves.set(index, leaf, leaf.bytes);
      return leaf;
    } catch (error) {
      const failure = within(`open the box archive ${this.file.name}: leaf ${index}`, error);
      if (this.#damagedLeaves.size < kMaxRememberedFailures)
        this.#damagedLeaves.set(index, failure);
      throw failure;
    }
  }
}

function checkSize({ fileBytes }: ArchiveHeader, file: RangeFile): void {
  if (file.size === fileBytes) return;
  const isShort = file.size !== undefined && file.size < fileBytes;
  throw new DataError(
    isShort ? 'cut' : 'damaged',
    `open the box archive ${file.name}: it has ${file.size} bytes; its header states ` +
      `${fileBytes}: upload it again`,
  );
}

function lies(key: BoxKey, world: Facts['world']): boolean {
  const { min, max } = boxRange(world, key.level);
  return [key.bx, key.by, key.bz].every((place, axis) => place >= min[axis]! && place < max[axis]!);
}
