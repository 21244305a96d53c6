/** Part of the interface: scripts branch on these. */
export const kExit = {
  done: 0,
  /** Some square failed, or the command could not run. */
  failed: 1,
  /** Wrong usage, or a configuration file that says what is not allowed. */
  usage: 2,
  /** All squares were asked for, but the source has not all of them, or some wait for another command. */
  holes: 3,
  /** 128 + the signal's number, as shells do. */
  interrupted: 130,
  terminated: 143,
} as const;

/** Of two parts of a run. */
export function worseOf(a: number, b: number): number {
  const order: readonly number[] = [kExit.failed, kExit.holes, kExit.done];
  return order.find((code) => code === a || code === b) ?? kExit.done;
}
