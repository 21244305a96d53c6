import { element, setText, svgElement } from './dom.js';
import { Rates } from './rates.js';

const [kWidth, kHeight] = [240, 44];

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
