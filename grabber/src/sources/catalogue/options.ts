import { kBackoff, type RetryNotice, type RetryPolicy } from '../../fetch/retry.js';
import { kSystemClock, type Clock } from '../../util/clock.js';
import { kMaxSquares } from '../square.js';
import type { GrabberError } from '../../util/errors.js';
import type { Variables } from '../url-template.js';

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
