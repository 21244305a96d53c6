import type {
  BoundsM,
  CatalogueSquare,
  ImageFacts,
  PointFacts,
  RecordKey,
  State,
  StoreRecord,
  StoredFile,
  Terms,
} from './square.js';

/** Which records; what is left out does not narrow. Results come by source, grid, name. */
export type RecordFilter = {
  readonly source?: string;
  readonly grid?: string;
  readonly states?: readonly State[];
  readonly names?: readonly string[];
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

/** A named range of ground, WGS 84 degrees. */
export type Area = {
  readonly name: string;
  readonly title: string;
  /** Rings of [longitude, latitude], the first the outer one. */
  readonly polygon: readonly (readonly (readonly [number, number])[])[];
};

export type AreaTable = {
  put(area: Area): void;
  get(name: string): Area | undefined;
  list(): Area[];
};

/** An open store. One process at a time writes to it (a lock file); others read. */
export type Store = {
  readonly root: string;
  readonly squares: RecordTable;
  readonly orthophotos: RecordTable;
  readonly areas: AreaTable;
  close(): void;
};

/**
 * Relative to the store. The dot keeps an unfinished file out of listings that look for LAZ files
 * and images.
 */
export type FilePlaces = {
  /** @param extension without its dot: "laz", "las", "zlas", "tif" */
  finished(kind: 'lidar' | 'ortho', key: RecordKey, extension: string): string;
  unfinished(kind: 'lidar' | 'ortho', key: RecordKey): string;
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
  readonly locate?: (
    square: CatalogueSquare,
    near: readonly string[],
    exists: (url: string, signal: AbortSignal) => Promise<boolean>,
    signal: AbortSignal,
  ) => Promise<CatalogueSquare | undefined>;
};
