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
import { listKeys, type ColumnKey } from './columns.js';
import { DataError, within } from '../../http/errors.js';
import {
  boxRange,
  checkArchiveBounds,
  columnHeight,
  hasLevel,
  isEmpty,
  readFacts,
  type Facts,
} from './facts.js';
import type { RangeFile } from './range-file.js';
import { planRanges, type ByteRange } from './range-plan.js';
import { SharedLoads } from './shared-loads.js';

/**
 * A box archive (docs/formats/box-archive.md) behind range requests: its facts, and where the boxes
 * of a column lie. Memory: the root of the index, up to 32 MiB, 16 MiB of leaves, and the beginning
 * and the end of the file.
 */

/** A box of a column, or a hole in it. Boxes without an entry are air. */
export type ColumnEntry = Entry & { readonly by: number };

/** Opening reads so much first. */
const kHeadBytes = 16 * 1024;
/**
 * And so much before the root of the index together with it: writers put the last leaves there, and
 * before them, in small archives, the coarsest boxes, which every picture begins with.
 */
const kTailBytes = 64 * 1024;
const kLeafCacheBytes = 16 * 1024 * 1024;
const kMaxRememberedFailures = 1024;
/** The index is searched for so many boxes of others when a column is prepared. */
const kMaxLookUps = 8192;

export class Archive {
  readonly facts: Facts;
  readonly file: RangeFile;
  readonly #root: RootIndex;
  readonly #limits: IndexLimits;
  readonly #leaves = new ByteCache<number, LeafIndex>(kLeafCacheBytes);
  readonly #loads = new SharedLoads<number, LeafIndex>();
  /** Requests for leaves, by their ranges. */
  readonly #reads = new SharedLoads<string, Uint8Array>();
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
    file.keep(0, head);
    const header = readHeader(head, file.name);
    checkSize(header, file);
    const { infoOffset, infoBytes, rootOffset, rootBytes } = header;
    const world = readFacts(await file.read(infoOffset, infoBytes, signal), file.name);
    checkArchiveBounds(world, file.name);
    const limits: IndexLimits = {
      fileBytes: header.fileBytes,
      hasRoomFor: (key) => key.level < world.levels && !isEmpty(world) && lies(key, world),
    };
    if (!file.has(rootOffset, rootBytes)) {
      const from = Math.min(rootOffset, Math.max(head.length, rootOffset - kTailBytes));
      file.keep(from, await file.read(from, rootOffset + rootBytes - from, signal));
    }
    const rootIndex = await file.read(rootOffset, rootBytes, signal);
    const root = new RootIndex(rootIndex, limits, file.name);
    return new Archive(file, { world, damage: header.damage }, root, limits);
  }

  /**
   * Loads what knownColumn() needs for a column.
   * @param others columns whose leaves are loaded as well where they lie close to its own in the
   * file, or are kept; where one cannot be read, column() of that column throws
   * @throws as column()
   */
  async prepare(
    column: ColumnKey,
    others: readonly ColumnKey[],
    signal: AbortSignal,
  ): Promise<void> {
    const leaves = this.#findLeaves(column);
    const wanted = new Set([...leaves, ...this.#leavesOfAll(others)]);
    const missing = [...wanted]
      .filter((index) => this.#isMissing(index))
      .map((index) => ({ ...this.#root.leaf(index), index }));
    const isKept = ({ offset, bytes }: ByteRange): boolean => this.file.has(offset, bytes);
    const kept = missing.filter(isKept).map((leaf) => ({ ...leaf, ranges: [leaf] }));
    const requests = planRanges(missing.filter((leaf) => !isKept(leaf)));
    const own = requests.filter(({ ranges }) => ranges.some(({ index }) => leaves.has(index)));
    for (const request of [...kept, ...own]) {
      for (const { index } of request.ranges) {
        this.#startLeaf(index, request, signal).catch(() => undefined);
      }
    }
    for (const index of leaves) await this.#leaf(index, signal);
  }

  /**
   * The boxes of a column, from the bottom up; none where all of it is air.
   * @throws DataError `missing` for a level that the world does not have; others as the index is
   * read; the reason of `signal`
   */
  async column(column: ColumnKey, signal: AbortSignal): Promise<readonly ColumnEntry[]> {
    const leaves = new Map<number, LeafIndex>();
    for (const index of this.#findLeaves(column)) {
      leaves.set(index, await this.#leaf(index, signal));
    }
    return this.#entries(column, leaves);
  }

  /** As column(), where that takes no request; else undefined. */
  knownColumn(column: ColumnKey): readonly ColumnEntry[] | undefined {
    const leaves = new Map<number, LeafIndex>();
    for (const index of this.#findLeaves(column)) {
      const leaf = this.#leaves.get(index);
      if (leaf === undefined) return undefined;
      leaves.set(index, leaf);
    }
    return this.#entries(column, leaves);
  }

  #entries(column: ColumnKey, leaves: ReadonlyMap<number, LeafIndex>): ColumnEntry[] {
    const entries: ColumnEntry[] = [];
    for (const key of listKeys(column, this.facts)) {
      const index = this.#root.findLeaf(key);
      const entry = index === undefined ? undefined : leaves.get(index)?.find(key);
      if (entry !== undefined) entries.push({ ...entry, by: key.by });
    }
    return entries;
  }

  #leavesOfAll(columns: readonly ColumnKey[]): number[] {
    const leaves: number[] = [];
    let lookUps = 0;
    for (const column of columns) {
      if (!hasLevel(this.facts, column.level)) continue;
      lookUps += columnHeight(this.facts, column.level);
      if (lookUps > kMaxLookUps) break;
      leaves.push(...this.#findLeaves(column));
    }
    return leaves;
  }

  #isMissing(index: number): boolean {
    return !this.#leaves.has(index) && !this.#damagedLeaves.has(index) && !this.#loads.has(index);
  }

  #findLeaves(column: ColumnKey): Set<number> {
    const leaves = new Set<number>();
    for (const key of listKeys(column, this.facts)) {
      const index = this.#root.findLeaf(key);
      if (index !== undefined) leaves.add(index);
    }
    return leaves;
  }

  async #leaf(index: number, signal: AbortSignal): Promise<LeafIndex> {
    const known = this.#leaves.get(index);
    if (known !== undefined) return known;
    const failure = this.#damagedLeaves.get(index);
    if (failure !== undefined) throw failure;
    return this.#startLeaf(index, this.#root.leaf(index), signal);
  }

  /** @param range that is read for it, and for others */
  #startLeaf(index: number, range: ByteRange, signal: AbortSignal): Promise<LeafIndex> {
    return this.#loads.get(index, signal, (shared) => this.#loadLeaf(index, range, shared));
  }

  async #loadLeaf(index: number, range: ByteRange, signal: AbortSignal): Promise<LeafIndex> {
    const { offset, bytes } = this.#root.leaf(index);
    const read = await this.#reads.get(`${range.offset}+${range.bytes}`, signal, (shared) =>
      this.file.read(range.offset, range.bytes, shared),
    );
    const frame = read.subarray(offset - range.offset, offset - range.offset + bytes);
    try {
      const leaf = new LeafIndex(frame, this.#root, index, this.#limits);
      this.#leaves.set(index, leaf, leaf.bytes);
      return leaf;
    } catch (error) {
      const failure = within(`open the box archive ${this.file.name}: leaf ${index}`, error);
      if (this.#damagedLeaves.size < kMaxRememberedFailures) {
        this.#damagedLeaves.set(index, failure);
      }
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
