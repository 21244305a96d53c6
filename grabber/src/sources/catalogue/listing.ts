import type { CatalogueSquare, Region, BoundsM } from '../../model/store.js';
import { GrabberError } from '../../util/errors.js';
import { compareText } from '../../util/text.js';
import { kBackoff, type RetryNotice, type RetryPolicy } from '../../fetch/retry.js';
import { kSystemClock, type Clock } from '../../util/clock.js';
import { kMaxSquares, type Variables, parseSquare } from '../square.js';
import { intersectBounds } from '../../geo/bounds.js';
import type { Source } from '../source.js';
import { boundsOfSquare } from '../naming.js';

/** Whether a square is requested. Squares without bounds are known by their name only. */
export function isInRegion(
  square: Pick<CatalogueSquare, 'name' | 'bounds'>,
  region: Region,
): boolean {
  if (region.names !== undefined) return region.names.has(square.name);
  return square.bounds === null || region.touches(square.bounds);
}

/** From south to north, then west to east; squares without bounds come last, by name. */
export function byPlace(a: CatalogueSquare, b: CatalogueSquare): number {
  if (a.bounds !== null && b.bounds !== null) {
    return a.bounds[1] - b.bounds[1] || a.bounds[0] - b.bounds[0] || byName(a, b);
  }
  if (a.bounds === null && b.bounds === null) return byName(a, b);
  return a.bounds === null ? 1 : -1;
}

function byName(a: CatalogueSquare, b: CatalogueSquare): number {
  return compareText(a.name, b.name);
}

/** @param what such as "list si-clss" */
export function catalogueError(
  what: string,
  found: string,
  allowed: string,
  cause?: unknown,
): GrabberError {
  return new GrabberError('CATALOGUE', `${what}: ${found}; allowed: ${allowed}`, { cause });
}

/** Squares of a catalogue as they come in: the newest of each name, and never more than allowed. */
export class Listing {
  readonly #what: string;
  readonly #maxSquares: number;
  readonly #newest = new Map<string, { readonly square: CatalogueSquare; readonly rank: string }>();

  constructor(what: string, maxSquares: number) {
    this.#what = what;
    this.#maxSquares = maxSquares;
  }

  /** @param rank of two squares with one name the one with the higher rank (by text) is kept */
  add(square: CatalogueSquare, rank: string): void {
    const before = this.#newest.get(square.name);
    if (before !== undefined && before.rank >= rank) return;
    this.#newest.set(square.name, { square, rank });
    if (this.#newest.size > this.#maxSquares) {
      throw catalogueError(
        this.#what,
        `more than ${this.#maxSquares} squares`,
        `at most ${this.#maxSquares} a run; choose less ground`,
      );
    }
  }

  sorted(): CatalogueSquare[] {
    return [...this.#newest.values()].map(({ square }) => square).sort(byPlace);
  }
}

export type CatalogueOptions = {
  /** Values the user gave for what addresses leave open. */
  readonly variables?: Variables;
  /** Most squares that find() may give; 20,000 when left out. */
  readonly maxSquares?: number;
  readonly limits?: Partial<CatalogueLimits>;
  readonly policy?: RetryPolicy;
  /** Called before each retry of a request. */
  readonly onRetry?: (notice: RetryNotice) => void;
  /**
   * Called for each unreadable entry, which is left out. Without it such an entry is an error, so
   * that squares never vanish unnoticed.
   */
  readonly onLeftOut?: (error: GrabberError) => void;
  readonly clock?: Clock;
};

/**
 * Limits for the replies of a portal, so that a faulty one can neither fill the memory nor run
 * forever.
 */
export type CatalogueLimits = {
  readonly pages: number;
  /** Limit for items or features, including those outside the region. */
  readonly items: number;
  readonly reply_bytes: number;
};

export const kLimits: CatalogueLimits = {
  pages: 2000,
  items: 100_000,
  reply_bytes: 16 * 1024 * 1024,
};
const kRetries = 4;

/** All options, none left out. */
export type CatalogueSettings = Required<Omit<CatalogueOptions, 'limits'>> & {
  readonly limits: CatalogueLimits;
};

export function toSettings(options: CatalogueOptions): CatalogueSettings {
  return {
    variables: options.variables ?? {},
    maxSquares: options.maxSquares ?? kMaxSquares,
    limits: { ...kLimits, ...options.limits },
    policy: options.policy ?? { ...kBackoff, retries: kRetries },
    onRetry: options.onRetry ?? (() => undefined),
    onLeftOut: options.onLeftOut ?? refuse,
    clock: options.clock ?? kSystemClock,
  };
}

function refuse(error: GrabberError): never {
  throw error;
}

/**
 * Up to this number of distant squares are requested one by one, rather than everything between
 * them.
 */
const kMaxSingles = 50;
const kSpread = 8;

/** The boxes to request from a catalogue, within the source's extent. */
export function listBoxes(region: Region, source: Source): BoundsM[] {
  const whole = intersectBounds(region.bounds, source.extent_m);
  if (whole === undefined) return [];
  const size = source.square_m;
  const names = region.names;
  if (size === undefined || names === undefined || names.size > kMaxSingles) return [whole];
  const between = ((whole[2] - whole[0]) / size) * ((whole[3] - whole[1]) / size);
  if (between <= kSpread * names.size) return [whole];
  return [...names].map(
    (name) =>
      boundsOfSquare(parseSquare(name, { square_m: size, extent_m: source.extent_m }), size) ??
      whole,
  );
}

/**
 * So many that cannot be read, and none that can, come from another catalogue than the one that is
 * configured.
 */
const kMaxUnread = 100;

/**
 * Reads the entries of a catalogue one by one. An unreadable entry is reported and left out, so
 * that one faulty entry does not block the whole catalogue. When none can be read, the first error
 * is thrown.
 */
export class Entries {
  readonly #onLeftOut: CatalogueSettings['onLeftOut'];
  #read = 0;
  #unread = 0;
  #first: GrabberError | undefined;

  constructor({ onLeftOut }: CatalogueSettings) {
    this.#onLeftOut = onLeftOut;
  }

  /** @return undefined for one that is left out */
  read<T>(action: () => T): T | undefined {
    try {
      const entry = action();
      ++this.#read;
      return entry;
    } catch (error) {
      if (!(error instanceof GrabberError)) throw error;
      this.#first ??= error;
      this.#onLeftOut(error);
      this.#unread += 1;
      if (this.#unread === kMaxUnread) this.end();
      return undefined;
    }
  }

  /** @throws GrabberError CATALOGUE */
  end(): void {
    if (this.#read === 0 && this.#first !== undefined) throw this.#first;
  }
}
