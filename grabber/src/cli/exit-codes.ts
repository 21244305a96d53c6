/**
 * The exit codes of the program. They are part of its interface, because scripts branch on them.
 */
export const kExit = {
  done: 0,
  /** Some square failed, or the command could not run. */
  failed: 1,
  /** Wrong usage, or a configuration file with a value that is not allowed. */
  usage: 2,
  /** Done, but the source lacks some of the requested squares, or some wait for another command. */
  holes: 3,
  /** 128 + the signal's number, as shells do. */
  interrupted: 130,
  terminated: 143,
} as const;

/**
 * Combines the exit codes of two parts of a run.
 * @return the more severe one
 */
export function chooseWorse(a: number, b: number): number {
  const order: readonly number[] = [kExit.failed, kExit.holes, kExit.done];
  return order.find((code) => code === a || code === b) ?? kExit.done;
}
