import { readFile } from 'node:fs/promises';
import { z } from 'zod';
import { GrabberError, describeError, systemCode } from '../util/errors.js';
import { writeFileAtomically } from '../util/files.js';

export const kManifestVersion = 1;

const triple = z.tuple([z.number(), z.number(), z.number()]);

/** What a verified file holds. */
const fileSchema = z.strictObject({
  /** Checked, because a file is removed by this path when another takes its place. */
  path: z.string().regex(/^lidar\/[a-z0-9-]+\/[^/\\]+\.(laz|las)$/),
  bytes: z.int().min(1),
  sha256: z.string().regex(/^[0-9a-f]{64}$/),
  point_count: z.int().min(1),
  las_version: z.string(),
  point_format: z.int().min(0).max(10),
  bounds: z.strictObject({ min: triple, max: triple }),
  fetched_at: z.iso.datetime(),
});

const recordSchema = z.strictObject({
  source: z.string(),
  square: z.string(),
  url: z.string(),
  /** verified: the file is in the store; missing: the source has no such square; failed: see last_error. */
  state: z.enum(['verified', 'missing', 'failed']),
  crs: z.string().nullable(),
  class_table: z.string().nullable(),
  licence: z.string().nullable(),
  attribution: z.string().nullable(),
  file: fileSchema.nullable(),
  warnings: z.array(z.string()),
  last_error: z.strictObject({ code: z.string(), message: z.string(), at: z.iso.datetime() }).nullable(),
});

const manifestSchema = z.strictObject({
  version: z.literal(kManifestVersion),
  squares: z.array(recordSchema),
});

export type StoredFile = z.infer<typeof fileSchema>;
export type SquareRecord = z.infer<typeof recordSchema>;

/**
 * The list of a store's squares.
 *
 * `put` may be called by many downloads at once. One write runs at a time; calls that come while it runs share the next
 * one, so that a store of many squares is not rewritten once per waiting square. A `put` resolves when its record is on
 * disk, so a square that was reported done is never forgotten by a crash.
 */
export class Manifest {
  readonly #path: string;
  readonly #records: Map<string, SquareRecord>;
  /** Settles when no write runs. */
  #last: Promise<void> = Promise.resolve();
  /** The write that has not begun yet, and which takes every record put until then. */
  #next: Promise<void> | undefined;

  private constructor(path: string, records: Map<string, SquareRecord>) {
    this.#path = path;
    this.#records = records;
  }

  /** A store without a manifest is an empty store; a manifest that cannot be read is an error. */
  static async open(path: string, signal: AbortSignal): Promise<Manifest> {
    let text: string;
    try {
      text = await readFile(path, { encoding: 'utf8', signal });
    } catch (error) {
      if (systemCode(error) === 'ENOENT') return new Manifest(path, new Map());
      throw error;
    }
    const records = parseManifest(text, path);
    return new Manifest(path, new Map(records.map((record) => [keyOf(record.source, record.square), record])));
  }

  get(source: string, square: string): SquareRecord | undefined {
    return this.#records.get(keyOf(source, square));
  }

  /** Sorted by source and square, so that two runs with the same result write the same order. */
  records(): SquareRecord[] {
    return [...this.#records.keys()].sort().flatMap((key) => this.#records.get(key) ?? []);
  }

  /** Not abortable on purpose: a record of a finished file is written even while the run is being stopped. */
  put(record: SquareRecord): Promise<void> {
    this.#records.set(keyOf(record.source, record.square), record);
    this.#next ??= this.#last.then(() => {
      this.#next = undefined;
      return this.#write();
    });
    // A failed write is reported to those who waited for it; the next write still gets its turn.
    this.#last = this.#next.catch(() => undefined);
    return this.#next;
  }

  async #write(): Promise<void> {
    const text = JSON.stringify({ version: kManifestVersion, squares: this.records() }, undefined, 1);
    try {
      await writeFileAtomically(this.#path, `${text}\n`, new AbortController().signal);
    } catch (error) {
      throw new GrabberError('STORE_IO', `write ${this.#path}: ${describeError(error)}`, { cause: error });
    }
  }
}

function keyOf(source: string, square: string): string {
  return `${source}/${square}`;
}

function parseManifest(text: string, path: string): SquareRecord[] {
  let raw: unknown;
  try {
    raw = JSON.parse(text);
  } catch (error) {
    throw new GrabberError('MANIFEST', `read ${path}: not JSON: ${describeError(error)}`, { cause: error });
  }
  const version = typeof raw === 'object' && raw !== null && 'version' in raw ? raw.version : undefined;
  if (version !== kManifestVersion) {
    throw new GrabberError(
      'MANIFEST',
      `read ${path}: version is ${JSON.stringify(version) ?? 'missing'}; allowed: ${kManifestVersion}`,
    );
  }
  const result = manifestSchema.safeParse(raw);
  if (result.success) return result.data.squares;
  const issue = result.error.issues[0];
  throw new GrabberError(
    'MANIFEST',
    `read ${path}: field ${issue?.path.join('.') ?? ''}: ${issue?.message ?? 'not valid'}`,
    { cause: result.error },
  );
}
