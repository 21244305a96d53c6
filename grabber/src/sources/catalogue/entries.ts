import { GrabberError } from '../../util/errors.js';
import type { CatalogueSettings } from './options.js';

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
