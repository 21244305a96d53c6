/**
 * How large a picture is traced at once: a moving picture gets the resolution that the processor
 * manages in a frame; a still one is traced at full resolution in bands, so that the page answers
 * meanwhile. Pure logic.
 */

const kMovingMs = 28; // a pass while something moves: 30 frames a second with room for the rest
const kBandMs = 40; // a band of a still picture
const kMinScale = 1 / 6;
const kFirstPixelsPerMs = 800; // of a slow processor; the first passes correct it

export class Pace {
  #pixelsPerMs = kFirstPixelsPerMs;

  /** @param pixels that were traced in that time */
  learn(pixels: number, ms: number): void {
    if (!(ms > 0) || pixels <= 0) return;
    const rate = pixels / ms;
    // Quickly down, slowly up: a hitch is worse than a coarse frame.
    const weight = rate < this.#pixelsPerMs ? 0.6 : 0.2;
    this.#pixelsPerMs += (rate - this.#pixelsPerMs) * weight;
  }

  /** The size of a moving picture. @param full size of the still one, pixels */
  movingSize(full: readonly [number, number]): readonly [number, number] {
    const wanted = Math.sqrt((this.#pixelsPerMs * kMovingMs) / (full[0] * full[1]));
    const scale = Math.min(1, Math.max(kMinScale, wanted));
    // In steps, so that targets are not made anew with each small change.
    const stepped = 1 / Math.max(1, Math.round(2 / scale) / 2);
    return [Math.max(1, Math.round(full[0] * stepped)), Math.max(1, Math.round(full[1] * stepped))];
  }

  /** Rows of the next band of a still picture. */
  bandRows(width: number): number {
    return Math.max(8, Math.floor((this.#pixelsPerMs * kBandMs) / width));
  }
}
