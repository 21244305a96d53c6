/** A gamepad of the standard mapping as movements: sticks, triggers, shoulder buttons. */
import type { Vec3 } from '../draw/camera.js';

/** The part of the browser's Gamepad that counts. */
export type Pad = {
  /** Left stick x and y, right stick x and y; x to the right, y down, [-1, 1]. */
  readonly axes: readonly number[];
  readonly buttons: readonly { readonly value: number; readonly pressed: boolean }[];
};

export type PadMotion = {
  /** Right, up, forward, [-1, 1] each. */
  readonly move: Vec3;
  /** Heading and pitch, [-1, 1] each. */
  readonly turn: readonly [number, number];
  readonly pace: 'slow' | 'usual' | 'fast';
};

const kDeadZone = 0.15; // sticks at rest are seldom at 0
const kTriggerRest = 0.05;
const kLeftShoulder = 4;
const kRightShoulder = 5;
const kLeftTrigger = 6;
const kRightTrigger = 7;

/** @return undefined while nothing is touched */
export function padMotion(pad: Pad): PadMotion | undefined {
  const [sideways, back] = stick(pad.axes[0], pad.axes[1]);
  const [right, down] = stick(pad.axes[2], pad.axes[3]);
  const upward = trigger(pad, kRightTrigger) - trigger(pad, kLeftTrigger);
  // What is 0 may have a sign, which no reader expects.
  const plain = (v: number): number => (v === 0 ? 0 : v);
  const move: Vec3 = [plain(sideways), plain(upward), plain(-back)];
  const turn = [plain(right), plain(-down)] as const;
  if (![...move, ...turn].some((v) => v !== 0)) return undefined;
  return { move, turn, pace: paceOf(pad) };
}

function paceOf(pad: Pad): PadMotion['pace'] {
  if (pad.buttons[kRightShoulder]?.pressed === true) return 'fast';
  return pad.buttons[kLeftShoulder]?.pressed === true ? 'slow' : 'usual';
}

// Outside of a round dead zone the deflection begins with 0.
function stick(x = 0, y = 0): readonly [number, number] {
  const length = Math.hypot(x, y);
  if (!(length > kDeadZone)) return [0, 0];
  const scale = (Math.min(1, length) - kDeadZone) / (1 - kDeadZone) / length;
  return [x * scale, y * scale];
}

function trigger(pad: Pad, button: number): number {
  const value = pad.buttons[button]?.value ?? 0;
  return value > kTriggerRest ? Math.min(1, value) : 0;
}
