/** Keeps values up to a limit of bytes; the one that was used longest ago leaves first. */
export class ByteCache<K, V> {
  readonly #limitBytes: number;
  // A Map iterates in the order of insertion: a value that is used is inserted again.
  readonly #values = new Map<K, { readonly value: V; readonly bytes: number }>();
  #bytes = 0;

  constructor(limitBytes: number) {
    this.#limitBytes = limitBytes;
  }

  has(key: K): boolean {
    return this.#values.has(key);
  }

  get(key: K): V | undefined {
    const found = this.#values.get(key);
    if (found === undefined) return undefined;
    this.#values.delete(key);
    this.#values.set(key, found);
    return found.value;
  }

  /** A value above the limit is kept until the next one comes. */
  set(key: K, value: V, bytes: number): void {
    const old = this.#values.get(key);
    if (old !== undefined) {
      this.#values.delete(key);
      this.#bytes -= old.bytes;
    }
    for (const [oldest, { bytes: freed }] of this.#values) {
      if (this.#bytes + bytes <= this.#limitBytes) break;
      this.#values.delete(oldest);
      this.#bytes -= freed;
    }
    this.#values.set(key, { value, bytes });
    this.#bytes += bytes;
  }
}
