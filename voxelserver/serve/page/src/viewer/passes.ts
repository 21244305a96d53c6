import { DrawClock } from './draw/clock.js';
import { Pace } from './draw/pace.js';
import type { Band } from './draw/renderer.js';

type Size = readonly [number, number];

/** What is drawn next: a band of a picture of this size. */
export type NextBand = Band & { readonly size: Size };

/**
 * How far the picture is: after each change a coarse one at once, then passes at the full size,
 * band by band. Draws nothing.
 */
export class Passes {
  readonly #clock: DrawClock;
  readonly #pace: Pace;
  /** Of the next band. */
  #y = 0;
  #hasCoarse = false;
  #isSharp = false;
  #pixels = 0;
  #startedMs = 0;
  #passMs = 0;
  #count = 0;

  /** @param pace what was learned of this processor before */
  constructor(gl: WebGL2RenderingContext, pace = new Pace()) {
    this.#clock = new DrawClock(gl);
    this.#pace = pace;
  }

  /** Whole passes. */
  get count(): number {
    return this.#count;
  }

  /** Of the last whole pass. */
  get passMs(): number {
    return this.#passMs;
  }

  /** Whether the newest pass is at the full size. */
  get isSharp(): boolean {
    return this.#isSharp;
  }

  /** What was drawn is no longer the picture. */
  restart(): void {
    this.#hasCoarse = false;
    this.#y = 0;
  }

  /** @return whether the processor has just ended a pass; undefined while it is busy */
  poll(nowMs: number): boolean | undefined {
    const ms = this.#clock.finished(nowMs);
    if (ms === undefined || ms === 0) return ms === 0 ? false : undefined;
    if (this.#pixels > 0) this.#pace.learn(this.#pixels, ms);
    if (this.#y !== 0) return false;
    this.#passMs = nowMs - this.#startedMs;
    this.#count += 1;
    return true;
  }

  /** Whether a pass at the full size stands, and the next one would be another. */
  isWhole(isMoving: boolean): boolean {
    return !isMoving && this.#hasCoarse && this.#isSharp && this.#y === 0;
  }

  next(nowMs: number, full: Size, isMoving: boolean): NextBand {
    const isCoarse = isMoving || !this.#hasCoarse;
    const size = isCoarse ? this.#pace.movingSize(full) : full;
    if (isCoarse) this.#y = 0;
    if (this.#y === 0) this.#startedMs = nowMs;
    const left = size[1] - this.#y;
    const height = isCoarse ? left : Math.min(this.#pace.bandRows(size[0]), left);
    this.#hasCoarse = true;
    this.#isSharp = !isCoarse;
    return { y: this.#y, height, size };
  }

  /**
   * The band has been given to the processor.
   * @param isBare it shows nothing but the sky, which says nothing of how long pixels take
   * @return whether it was the last one of its pass
   */
  given({ height, size }: NextBand, isBare: boolean): boolean {
    this.#pixels = isBare ? 0 : height * size[0];
    this.#y = this.#y + height >= size[1] ? 0 : this.#y + height;
    return this.#y === 0;
  }

  /** All of the frame has been given. */
  mark(nowMs: number): void {
    this.#clock.mark(nowMs);
  }
}
