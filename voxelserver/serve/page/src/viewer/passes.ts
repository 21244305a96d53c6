import type { Vec2 } from '../vec3.js';
import type { Band } from './draw/renderer.js';

const kMovingMs = 28; // a pass while something moves: 30 frames a second with room for the rest
const kBandMs = 40; // a band of a still picture
const kMinScale = 1 / 6;
const kFirstPixelsPerMs = 800; // of a slow processor; the first passes correct it

type Size = Vec2;

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

  /** Whole passes, how long the last one took, and whether the newest is at the full size. */
  get state(): { readonly count: number; readonly passMs: number; readonly isSharp: boolean } {
    return { count: this.#count, passMs: this.#passMs, isSharp: this.#isSharp };
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

/**
 * How large a picture is traced at once: a moving picture gets the resolution that the processor
 * manages in a frame; a still one is traced at full resolution in bands, so that the page answers
 * meanwhile.
 */
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
  movingSize(full: Vec2): Vec2 {
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

/** Times the drawing: how long the graphics processor took for what was last given to it. */
class DrawClock {
  readonly #gl: WebGL2RenderingContext;
  #fence: WebGLSync | undefined;
  #startedMs = 0;

  constructor(gl: WebGL2RenderingContext) {
    this.#gl = gl;
  }

  /** Marks the end of what has been given to the processor. */
  mark(nowMs: number): void {
    const fence = this.#gl.fenceSync(this.#gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.#gl.flush();
    this.#fence = fence ?? undefined;
    this.#startedMs = nowMs;
  }

  /**
   * @return undefined while the processor is busy with what was marked; then once the time that it
   * took, ms, and 0 after that
   */
  finished(nowMs: number): number | undefined {
    if (this.#fence === undefined) return 0;
    const state = this.#gl.clientWaitSync(this.#fence, 0, 0);
    if (state === this.#gl.TIMEOUT_EXPIRED) return undefined;
    this.#gl.deleteSync(this.#fence);
    this.#fence = undefined;
    return nowMs - this.#startedMs;
  }
}
