/** West, south, east, north in metres of a CRS; half-open towards east and north. */
export type BoundsM = readonly [west: number, south: number, east: number, north: number];

/**
 * Names one file of the store, whatever is in it. Of a LiDAR square `grid` is its source. An
 * orthophoto is cut to a square of the LiDAR source `grid`, and `source` is where the picture comes
 * from.
 */
export type RecordKey = { readonly source: string; readonly grid: string; readonly name: string };

/**
 * The states of a record:
 * known      a fishnet lists it; it was not requested
 * wanted     it was requested and waits for its turn
 * fetching   a transfer has begun; an unfinished file may lie next to the place of the finished one
 * fetched    all bytes are stored and hashed, but not checked
 * verified   the file is whole, and is what it claims to be
 * converted  verified, and converted to the form that is kept (zLAS and LAS to LAZ, images to
 *            GeoTIFF)
 * missing    its source has no such square
 * failed     the last attempt ended with `lastError`; another attempt may succeed
 */
export const kStates = [
  'known',
  'wanted',
  'fetching',
  'fetched',
  'verified',
  'converted',
  'missing',
  'failed',
] as const;
export type State = (typeof kStates)[number];

/**
 * States in which the file of a record can be used. It still can while another is fetched: then
 * only `verifiedAt` shows that.
 */
export const kUsable: readonly State[] = ['verified', 'converted'];

/** What a catalogue says of a square, before anything is fetched. */
export type CatalogueSquare = {
  /**
   * `E_N`, the south-west corner in kilometres of the source's CRS; of files without a grid, their
   * name.
   */
  readonly name: string;
  /** Part of the survey (si-lss: b_35), null where the source has none or it is not known yet. */
  readonly block: string | null;
  /** In the source's CRS; null for files known by their name only. */
  readonly bounds: BoundsM | null;
  /**
   * The same file, best first; empty when the address is not known yet (Catalogue.locate finds it).
   */
  readonly urls: readonly string[];
  /** Length of the file or of the archive, as the catalogue has it. */
  readonly bytes: number | null;
  /** Hexadecimal, of the file at the address (of the archive where `member` is set). */
  readonly sha256: string | null;
  /** The file is this member of the ZIP archive at the address; "*" = its only point cloud. */
  readonly member: string | null;
  /** ISO 8601 date or year of the survey. */
  readonly published: string | null;
};

/** What is recorded with every file of a source. Null = the user gave none. */
export type Terms = {
  readonly crs: string | null;
  readonly classTable: string | null;
  readonly licence: string | null;
  readonly attribution: string | null;
};

/** A file of the store that can be used, or waits for its conversion. */
export type StoredFile = {
  /** Relative to the store, with forward slashes. */
  readonly path: string;
  readonly bytes: number;
  readonly sha256: string;
};

/** What the header of a point cloud says. */
export type PointFacts = {
  readonly pointCount: number;
  /** "1.0" to "1.5" */
  readonly lasVersion: string;
  /** 0 to 10 */
  readonly pointFormat: number;
  /** In the file's CRS and units. */
  readonly min: readonly [number, number, number];
  readonly max: readonly [number, number, number];
};

/** What an orthophoto holds. */
export type ImageFacts = {
  readonly width_px: number;
  readonly height_px: number;
  readonly resolution_m: number;
  /** Ground around the square that is in the picture too. */
  readonly margin_m: number;
};

export type LastError = { readonly code: string; readonly message: string; readonly at: string };

/** One row of the store. Times are ISO 8601, null = has not happened. */
export type StoreRecord = Terms & {
  readonly key: RecordKey;
  readonly state: State;
  readonly block: string | null;
  /** Of the square, in `gridCrs`. */
  readonly bounds: BoundsM | null;
  readonly gridCrs: string | null;
  readonly urls: readonly string[];
  readonly expectedBytes: number | null;
  readonly expectedSha256: string | null;
  readonly member: string | null;
  readonly published: string | null;
  /**
   * Where the file came from, after redirects were followed by name only: the address that was
   * requested.
   */
  readonly url: string | null;
  /** The last whole file; it stays when a later attempt fails. */
  readonly file: StoredFile | null;
  /** As it was sent, where a conversion has replaced it. */
  readonly original: Pick<StoredFile, 'bytes' | 'sha256'> | null;
  readonly points: PointFacts | null;
  readonly image: ImageFacts | null;
  readonly warnings: readonly string[];
  readonly lastError: LastError | null;
  /** Attempts since it was last wanted. */
  readonly attempts: number;
  readonly knownAt: string;
  readonly wantedAt: string | null;
  readonly fetchedAt: string | null;
  /** Of `file`, which can be used whenever this is set. */
  readonly verifiedAt: string | null;
  readonly convertedAt: string | null;
};

/** Ground and the CRS that its bounds are in. */
export type Ground = { readonly bounds: BoundsM; readonly crs: string };

/**
 * Where a square lies: where its catalogue puts it, else where the points of its file are, out to
 * whole metres, so that pictures of squares next to each other share their pixels.
 * @return undefined where neither is known
 */
export function findGround(
  square: Pick<StoreRecord, 'bounds' | 'gridCrs' | 'points' | 'crs'>,
): Ground | undefined {
  const { bounds, gridCrs, points, crs } = square;
  if (bounds !== null) return gridCrs === null ? undefined : { bounds, crs: gridCrs };
  if (points === null || crs === null) return undefined;
  const { min, max } = points;
  return {
    bounds: [Math.floor(min[0]), Math.floor(min[1]), Math.ceil(max[0]), Math.ceil(max[1])],
    crs,
  };
}

/** Which records; what is left out does not narrow. Results come by source, grid, name. */
export type RecordFilter = {
  readonly source?: string | undefined;
  readonly grid?: string | undefined;
  readonly states?: readonly State[] | undefined;
  readonly names?: readonly string[] | undefined;
  /** Those whose file can be used, also while it is fetched again. */
  readonly usable?: true;
};

export type Place = {
  readonly source: string;
  readonly grid: string;
  readonly state: State;
  readonly bounds: BoundsM;
};

export type Learned = { readonly added: number; readonly changed: number };

/**
 * The records of one kind of file. Every call is one transaction, done when it returns: a killed
 * process leaves the store as it was after some call. Calls that change a record throw
 * STORE_CONFLICT when there is no such record.
 */
export type RecordTable = {
  /**
   * Adds squares, or updates what the catalogue says of them; never their state or file. One
   * transaction for all.
   */
  learn(
    source: string,
    grid: string,
    gridCrs: string | null,
    terms: Terms,
    squares: Iterable<CatalogueSquare>,
  ): Learned;
  get(key: RecordKey): StoreRecord | undefined;
  list(filter: RecordFilter): StoreRecord[];
  count(filter: RecordFilter): number;
  /**
   * Counts by source and state, for a summary that reads no records. Bytes and points of the files
   * that are there. What can be used while it is fetched again counts as what it is.
   */
  tally(): { source: string; state: State; count: number; bytes: number; points: number }[];
  /**
   * Where the records with bounds lie, by source and grid: what a map needs, without reading
   * records; states as in `tally`.
   */
  places(): Place[];
  /** Those with a `lastError`, the latest first. */
  lastErrors(limit: number): StoreRecord[];
  /**
   * Known, failed, and what has been missing for a month become wanted; with `again` all that is
   * missing and what can be used already, whose file stays in use until another replaces it.
   * @return how many did
   */
  want(keys: Iterable<RecordKey>, again?: boolean): number;
  /** Wanted, fetching, fetched: what a run that was cut off has left to do. */
  unfinished(filter: RecordFilter): StoreRecord[];

  begin(key: RecordKey, url: string): void;
  /** The addresses that were found for a square whose catalogue did not know them. */
  located(key: RecordKey, block: string | null, urls: readonly string[]): void;
  fetched(key: RecordKey, file: StoredFile): void;
  verified(key: RecordKey, facts: Verified): void;
  converted(key: RecordKey, file: StoredFile, facts: Verified): void;
  missing(key: RecordKey, reason: string): void;
  /**
   * A file that could be used before still can, and a whole one that waits for its conversion still
   * waits; `lastError` has the reason.
   */
  failed(key: RecordKey, code: string, message: string): void;
  /** Back to known; the caller has removed the file. */
  forget(key: RecordKey): void;
};

/** What was found in a file. `crs` replaces the source's where the file says otherwise. */
export type Verified = {
  readonly points: PointFacts | null;
  readonly image: ImageFacts | null;
  readonly crs: string | null;
  readonly warnings: readonly string[];
};

/** An open store. One process at a time writes to it (a lock file); others read. */
export type Store = {
  readonly root: string;
  readonly squares: RecordTable;
  readonly orthophotos: RecordTable;
  close(): void;
};

/** Requested ground, in the CRS of one source. */
export type Region = {
  /** Encloses all of it. */
  readonly bounds: BoundsM;
  /** Whether a square has any of that ground. */
  touches(square: BoundsM): boolean;
  /** The squares that were requested by name; undefined = all that touch. */
  readonly names: ReadonlySet<string> | undefined;
};

/** The squares that a source offers. */
export type Catalogue = {
  /**
   * Squares of the region, each once, from south to north, then west to east.
   * @throws GrabberError CATALOGUE: never fewer squares instead, unless each one that is missing is
   *   reported to the caller that opened the store
   */
  readonly find: (region: Region, signal: AbortSignal) => AsyncIterable<CatalogueSquare>;
  /** Whether found addresses expire, so that each run finds them anew. */
  readonly addressesExpire?: boolean;
  /**
   * Finds the address of a square whose `urls` are empty, by trying addresses.
   * @param near  blocks of the squares around it, most likely first
   * @param there checks whether a file exists; counts as a request to its host
   * @return undefined when the source has no such square
   */
  readonly locate?:
    | ((
        square: CatalogueSquare,
        near: readonly string[],
        exists: (url: string, signal: AbortSignal) => Promise<boolean>,
        signal: AbortSignal,
      ) => Promise<CatalogueSquare | undefined>)
    | undefined;
};
