const kWindow_ms = 10_000;
const kSlot_ms = 500;

/** Bytes a second over the last ten seconds. */
export class Rate {
  readonly #now_ms: () => number;
  readonly #began_ms: number;
  /** Start of a slot and its bytes, oldest first. */
  readonly #slots: { at_ms: number; bytes: number }[] = [];

  constructor(now_ms: () => number) {
    this.#now_ms = now_ms;
    this.#began_ms = now_ms();
  }

  add(bytes: number): void {
    const now = this.#now_ms();
    const last = this.#slots.at(-1);
    if (last !== undefined && now - last.at_ms < kSlot_ms) last.bytes += bytes;
    else this.#slots.push({ at_ms: now, bytes });
    while ((this.#slots[0]?.at_ms ?? now) < now - kWindow_ms) this.#slots.shift();
  }

  perSecond(): number {
    const now = this.#now_ms();
    const recent = this.#slots.filter((slot) => slot.at_ms >= now - kWindow_ms);
    const since = Math.max(kSlot_ms, now - (recent[0]?.at_ms ?? now));
    return (recent.reduce((sum, slot) => sum + slot.bytes, 0) * 1000) / since;
  }

  elapsed_s(): number {
    return (this.#now_ms() - this.#began_ms) / 1000;
  }
}
