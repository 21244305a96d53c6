/** Date and time of day, UTC, and where the sun stands then. */
import { byId, setText } from '../../dom.js';
import type { SunPosition } from '../draw/sun-position.js';
import { numberText } from './number-text.js';
import type { Language, Say } from './texts.js';

const kDayMs = 86_400_000;
const kMinuteMs = 60_000;

/** @param onChange UTC, milliseconds since 1970 */
export function setUpTime(onChange: (timeMs: number) => void): void {
  const date = byId('date', HTMLInputElement);
  const time = byId('time', HTMLInputElement);
  const changed = (): void => {
    const day = date.valueAsNumber;
    if (Number.isFinite(day)) onChange(day + time.valueAsNumber * kMinuteMs);
  };
  date.addEventListener('input', changed);
  time.addEventListener('input', changed);
}

export function showTime(
  timeMs: number,
  { altitudeDeg, azimuthDeg }: SunPosition,
  say: Say,
  language: Language,
): void {
  const date = byId('date', HTMLInputElement);
  const time = byId('time', HTMLInputElement);
  const day = Math.floor(timeMs / kDayMs) * kDayMs;
  date.valueAsNumber = day;
  time.valueAsNumber = Math.round((timeMs - day) / kMinuteMs);
  const clock = `${new Date(timeMs).toISOString().slice(11, 16)} ${say('utc')}`;
  time.setAttribute('aria-valuetext', clock);
  setText(byId('clock', HTMLOutputElement), clock);
  const degrees = numberText(language, 1);
  setText(
    byId('sun', HTMLParagraphElement),
    say('sun', degrees.number(altitudeDeg, 1), degrees.number(azimuthDeg, 0)),
  );
}
