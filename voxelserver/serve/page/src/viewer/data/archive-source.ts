import { extractFrame, kRecordBytes } from './archive-format.js';
import type { Archive, ColumnEntry } from './archive.js';
import { nameOfBox } from './box-arrays.js';
import { readBoxFrame } from './box-frame.js';
import {
  ColumnBuilder,
  type ColumnKey,
  type BoxSource,
  type ColumnBox,
  type ColumnResult,
} from './columns.js';
import type { Clock } from '../../http/environment.js';
import { asDataError, within, type DataError } from '../../http/errors.js';
import { columnHeight, hasLevel, type Facts } from './facts.js';
import {
  findGaps,
  planRanges,
  Stretches,
  type ByteRange,
  type RangeRequest,
} from './range-plan.js';
import { Turns } from './turns.js';

/** Columns of a box archive. */

/** A box that is to be read: its record and frame in the file. */
type WantedBox = ByteRange & { readonly entry: ColumnEntry; readonly column: LoadingColumn };

type LoadingColumn = { readonly builder: ColumnBuilder; missing: number; isOver: boolean };

/** The index is searched for so many boxes when companions are chosen. */
const kMaxLookUps = 8192;

export class ArchiveSource implements BoxSource {
  readonly facts: Facts;
  readonly #archive: Archive;
  readonly #turns: Turns;

  constructor(archive: Archive, clock: Clock) {
    this.facts = archive.facts;
    this.#archive = archive;
    this.#turns = new Turns(clock);
  }

  prepare(column: ColumnKey, others: readonly ColumnKey[], signal: AbortSignal): Promise<void> {
    return this.#archive.prepare(column, others, signal);
  }

  companions(column: ColumnKey, candidates: readonly ColumnKey[]): readonly ColumnKey[] {
    const own = this.#knownRanges(column) ?? [];
    const stretches = new Stretches(own);
    const taken: ColumnKey[] = [];
    const near: { readonly column: ColumnKey; readonly ranges: readonly ByteRange[] }[] = [];
    let lookUps = 0;
    for (const candidate of candidates) {
      if (!hasLevel(this.facts, candidate.level)) continue;
      lookUps += columnHeight(this.facts, candidate.level);
      if (lookUps > kMaxLookUps) break;
      const ranges = this.#knownRanges(candidate);
      if (ranges === undefined) continue;
      // Air takes no request at all, nor does what is kept.
      if (ranges.length === 0) taken.push(candidate);
      else near.push({ column: candidate, ranges });
    }
    if (own.length === 0) return taken;
    // Upwards, then downwards: each column that is added brings the next one near.
    near.sort((a, b) => a.ranges[0]!.offset - b.ranges[0]!.offset);
    const left = near.filter(({ ranges, column: key }) => {
      const isAdded = stretches.extend(ranges);
      if (isAdded) taken.push(key);
      return !isAdded;
    });
    for (const { ranges, column: key } of left.reverse()) {
      if (stretches.extend(ranges)) taken.push(key);
    }
    return taken;
  }

  async *columns(
    columns: readonly ColumnKey[],
    signal: AbortSignal,
  ): AsyncGenerator<ColumnResult, void, undefined> {
    const wanted: WantedBox[] = [];
    for (const key of columns) {
      const found = await this.#find(key, signal);
      if ('failed' in found) {
        yield found;
        continue;
      }
      const column = { builder: new ColumnBuilder(key), missing: found.length, isOver: false };
      for (const entry of found) wanted.push({ ...toRange(entry), entry, column });
      if (found.length === 0) yield { column: column.builder.finish() };
    }
    const isKept = (box: WantedBox): boolean => this.#archive.file.has(box.offset, box.bytes);
    for (const box of wanted.filter(isKept)) {
      yield* this.#read({ offset: box.offset, bytes: box.bytes, ranges: [box] }, signal);
    }
    for (const { ranges } of planRanges(wanted.filter((box) => !isKept(box))))
    // What a column that has failed meanwhile still lacks is not fetched.
    {
      for (const request of planRanges(ranges.filter(({ column }) => !column.isOver))) {
        yield* this.#read(request, signal);
      }
    }
  }

  async #find(
    column: ColumnKey,
    signal: AbortSignal,
  ): Promise<readonly ColumnEntry[] | { readonly failed: ColumnKey; readonly error: DataError }> {
    try {
      return await this.#archive.column(column, signal);
    } catch (error) {
      return toFailure(column, error, signal);
    }
  }

  async *#read(
    request: RangeRequest<WantedBox>,
    signal: AbortSignal,
  ): AsyncGenerator<ColumnResult, void, undefined> {
    let bytes: Uint8Array;
    try {
      bytes = await this.#archive.file.read(request.offset, request.bytes, signal);
    } catch (error) {
      for (const { column } of request.ranges) {
        if (column.isOver) continue;
        column.isOver = true;
        yield toFailure(column.builder.key, error, signal);
      }
      return;
    }
    // Boxes that lie in between are likely to be wanted next.
    for (const { offset, bytes: count } of findGaps(request)) {
      const from = offset - request.offset;
      this.#archive.file.remember(offset, bytes.subarray(from, from + count));
    }
    for (const box of request.ranges) {
      const { column } = box;
      if (column.isOver) continue;
      const from = box.offset - request.offset;
      const failure = this.#addBox(bytes.subarray(from, from + box.bytes), box, signal);
      await this.#turns.give(signal);
      column.missing -= 1;
      if (failure === undefined && column.missing > 0) continue;
      column.isOver = true;
      yield failure ?? { column: column.builder.finish() };
    }
  }

  /** @return why the column fails */
  #addBox(bytes: Uint8Array, box: WantedBox, signal: AbortSignal): ColumnResult | undefined {
    const { builder } = box.column;
    try {
      builder.add(box.entry.by, this.#unpackBox(bytes, builder.key, box.entry));
      return undefined;
    } catch (error) {
      return toFailure(builder.key, error, signal);
    }
  }

  #unpackBox(bytes: Uint8Array, column: ColumnKey, entry: ColumnEntry): ColumnBox {
    const key = { ...column, by: entry.by };
    try {
      const frame = extractFrame(bytes, key, entry);
      if (entry.kind === 'hole') return 'hole';
      return readBoxFrame(frame, key, this.#turns);
    } catch (error) {
      throw within(`read ${this.#archive.file.name}, box ${nameOfBox(key)}`, error);
    }
  }

  /** What has to be fetched for a column, by offset; undefined where the index is not loaded. */
  #knownRanges(column: ColumnKey): readonly ByteRange[] | undefined {
    const ranges = this.#archive.knownColumn(column)?.map(toRange);
    return ranges
      ?.filter(({ offset, bytes }) => !this.#archive.file.has(offset, bytes))
      .sort((a, b) => a.offset - b.offset);
  }
}

function toRange(entry: ColumnEntry): ByteRange {
  return { offset: entry.offset - kRecordBytes, bytes: entry.bytes + kRecordBytes };
}

/** @throws what ends everything: a change of the archive, or the reason of `signal` */
function toFailure(
  column: ColumnKey,
  error: unknown,
  signal: AbortSignal,
): { readonly failed: ColumnKey; readonly error: DataError } {
  signal.throwIfAborted();
  const failure = asDataError(error);
  if (failure.kind === 'changed') throw failure;
  return { failed: column, error: failure };
}
