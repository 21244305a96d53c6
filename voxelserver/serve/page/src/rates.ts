/** Requests a second over the last two minutes, from a count that only grows. */

export type Sample = { readonly atS: number; readonly rate: number };

const kSpanS = 120;

export class Rates {
  #last: { readonly atS: number; readonly count: number } | undefined;
  #samples: Sample[] = [];

  /**
   * A smaller count than before is that of a server started anew: a gap in the line, not a negative
   * rate.
   */
  add(atS: number, count: number): void {
    const last = this.#last;
    this.#last = { atS, count };
    if (last === undefined || atS <= last.atS || count < last.count) return;
    this.#samples.push({ atS, rate: (count - last.count) / (atS - last.atS) });
    this.#samples = this.#samples.filter((sample) => sample.atS > atS - kSpanS);
  }

  get samples(): readonly Sample[] {
    return this.#samples;
  }
  get current(): number {
    return this.#samples.at(-1)?.rate ?? 0;
  }
  get highest(): number {
    return this.#samples.reduce((most, sample) => Math.max(most, sample.rate), 0);
  }

  /** Points of an SVG polyline: the newest at the right edge. */
  line(width: number, height: number): string {
    const end = this.#samples.at(-1)?.atS ?? 0;
    const top = Math.max(1, this.highest);
    const places = this.#samples.map(({ atS, rate }) => [
      width * (1 - (end - atS) / kSpanS),
      height * (1 - rate / top),
    ]);
    return places.map((place) => place.map((v) => v.toFixed(1)).join()).join(' ');
  }
}
