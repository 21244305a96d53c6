/** What can go wrong with one request for a file; real portals were seen to do each of these. */
export const kFaults = [
  'reset', // the connection breaks at a random byte
  '500',
  '503', // with Retry-After
  '429', // with Retry-After
  'short', // Content-Length and body end early
  'long', // more is announced than comes
  'nolength',
  'html', // status 200, but a page
  'norange', // Range is ignored
  'etag', // another ETag than before
  'gzip', // Content-Encoding although identity was requested
  'redirect', // to the same file of this server
  'foreign', // redirect to a server elsewhere
  'slow', // a trickle
  'stall', // silence in the middle of the body
] as const;
export type Fault = (typeof kFaults)[number];

/** Those that a second try, or none at all, gets over, without long waits. */
export const kTransient: readonly Fault[] = [
  'reset',
  '500',
  '503',
  '429',
  'short',
  'long',
  'nolength',
  'html',
  'norange',
  'etag',
  'gzip',
  'redirect',
];

/** Chance of each fault per request. */
export type FaultChances = ReadonlyMap<Fault, number>;

/**
 * @param text such as "reset=0.05,html=0.01", or "transient=0.1": that chance shared by all of
 * kTransient
 */
export function parseFaults(text: string): FaultChances {
  const chances = new Map<Fault, number>();
  for (const part of text.split(',').filter((one) => one !== '')) {
    const [name = '', value = ''] = part.split('=');
    const chance = Number(value);
    const faults = name === 'transient' ? kTransient : kFaults.filter((one) => one === name);
    if (faults.length === 0 || value === '' || !(chance >= 0 && chance <= 1)) {
      throw new Error(
        `read --faults: "${part}"; allowed: NAME=CHANCE with 0 to 1 and transient, ` +
          `${kFaults.join(', ')}`,
      );
    }
    for (const fault of faults) {
      chances.set(fault, (chances.get(fault) ?? 0) + chance / faults.length);
    }
  }
  return chances;
}

export function drawFault(chances: FaultChances, random: () => number): Fault | undefined {
  let left = random();
  for (const [fault, chance] of chances) {
    if (left < chance) return fault;
    left -= chance;
  }
  return undefined;
}

export type FileStats = {
  requests: number;
  /** Bytes of bodies handed to the network. */
  bytes: number;
  /** Answers with status 200 whose whole body was handed over. */
  whole: number;
  faults: number;
};

/** What was sent, by path. */
export class PortalStats {
  readonly #files = new Map<string, FileStats>();

  of(path: string): FileStats {
    let stats = this.#files.get(path);
    if (stats === undefined) {
      stats = { requests: 0, bytes: 0, whole: 0, faults: 0 };
      this.#files.set(path, stats);
    }
    return stats;
  }

  reset(): void {
    this.#files.clear();
  }

  toJSON(): Record<string, FileStats> {
    return Object.fromEntries(this.#files);
  }
}
