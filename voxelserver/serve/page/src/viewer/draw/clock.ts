/** Times the drawing: how long the graphics processor took for what was last given to it. */
export class DrawClock {
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
