/** Part of the interface: scripts branch on these. */
export const kExit = {
  done: 0,
  /** Some square failed, or the command could not run. */
  failed: 1,
  usage: 2,
  /** All squares were asked for, but the source has not all of them. */
  holes: 3,
  /** 128 + the signal's number, as shells do. */
  interrupted: 130,
  terminated: 143,
} as const;
