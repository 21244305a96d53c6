import { GrabberError } from '../../util/errors.js';
import type { CatalogueSettings } from './options.js';

/** So many that cannot be read, and none that can, come from another catalogue than the one that is configured. */
const kMostUnread = 100;

/**
 * Reads the entries of a catalogue one by one. One that cannot be read is told and left out, so that a slip of a portal
 * does not keep its whole country back. Where none can be read the first one's error is thrown.
 */
export class Entries {
  readonly #tell: CatalogueSettings['onLeftOut'];
  #read = 0;
  #unread = 0;
  #first: GrabberError | undefined;

  constructor({ onLeftOut }: CatalogueSettings) {
    this.#tell = onLeftOut;
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
      this.#tell(error);
      if (++this.#unread === kMostUnread) this.end();
      return undefined;
    }
  }

  /** @throws GrabberError CATALOGUE */
  end(): void {
    if (this.#read === 0 && this.#first !== undefined) throw this.#first;
  }
}
