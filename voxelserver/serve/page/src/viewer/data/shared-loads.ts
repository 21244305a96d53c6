/**
 * Loads of the same thing that several callers wait for are made once. Such a load is cancelled
 * when no caller waits for it any more.
 */
export class SharedLoads<K, V> {
  readonly #running = new Map<K, Load<V>>();

  /**
   * @param load starts the load, unless one of the same key is running
   * @throws what the load throws; the reason of `signal`
   */
  get(key: K, signal: AbortSignal, load: (signal: AbortSignal) => Promise<V>): Promise<V> {
    if (signal.aborted) return Promise.reject(signal.reason as Error);
    const shared = this.#running.get(key) ?? this.#start(key, load);
    shared.waiting += 1;
    return new Promise((resolve, reject) => {
      const onAbort = (): void => {
        reject(signal.reason as Error);
        shared.waiting -= 1;
        if (shared.waiting > 0) return;
        this.#forget(key, shared);
        shared.controller.abort();
      };
      signal.addEventListener('abort', onAbort, { once: true });
      const done = (): void => signal.removeEventListener('abort', onAbort);
      shared.result.then(resolve, reject).finally(done);
    });
  }

  /** Whether a load of this is running. */
  has(key: K): boolean {
    return this.#running.has(key);
  }

  #start(key: K, load: (signal: AbortSignal) => Promise<V>): Load<V> {
    const controller = new AbortController();
    const result = load(controller.signal);
    const shared = { controller, result, waiting: 0 };
    this.#running.set(key, shared);
    const forget = (): void => this.#forget(key, shared);
    result.then(forget, forget);
    return shared;
  }

  #forget(key: K, shared: Load<V>): void {
    if (this.#running.get(key) === shared) this.#running.delete(key);
  }
}

type Load<V> = {
  readonly controller: AbortController;
  readonly result: Promise<V>;
  waiting: number;
};
