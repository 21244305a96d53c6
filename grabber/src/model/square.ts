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
  /** "1.0" to "1.4" */
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
