import { element, setText, svgElement } from './dom.js';

const [kWidth, kHeight] = [240, 44];
const kSpanS = 120;

/** Requests a second over the last two minutes: a line, and the same in words. */
export class RateChart {
  readonly #rates = new Rates();
  readonly #line = svgElement('polyline', { transform: 'translate(0 2)' });
  readonly #text = element('p', { class: 'rate-text' });

  constructor(target: HTMLElement) {
    const viewBox = `0 0 ${kWidth} ${kHeight}`;
    const drawn = { viewBox, preserveAspectRatio: 'none', 'aria-hidden': 'true' };
    target.append(this.#text, svgElement('svg', drawn, this.#line));
    this.#draw();
  }

  add(atS: number, requests: number): void {
    this.#rates.add(atS, requests);
    this.#draw();
  }

  #draw(): void {
    this.#line.setAttribute('points', this.#rates.line(kWidth, kHeight - 4));
    const rate = (value: number): string => value.toFixed(value < 10 ? 1 : 0);
    const isKnown = this.#rates.samples.length > 0;
    const { current, highest } = this.#rates;
    const known = `${rate(current)} requests a second, at most ${rate(highest)} in 2 minutes`;
    setText(this.#text, isKnown ? known : 'Counting requests a second …');
  }
}

type Sample = { readonly atS: number; readonly rate: number };

/** Requests a second over the last two minutes, from a count that only grows. */
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
