/** Numbers as text. English, as is the rest of the page. */

const kBytes = ['B', 'KiB', 'MiB', 'GiB', 'TiB'];

export function formatBytes(bytes: number): string {
  let value = Math.max(0, bytes);
  let unit = 0;
  for (; value >= 1024 && unit + 1 < kBytes.length; ++unit) value /= 1024;
  return `${unit === 0 || value >= 100 ? Math.round(value) : value.toFixed(1)} ${kBytes[unit]!}`;
}

const kWhole = new Intl.NumberFormat('en', { maximumFractionDigits: 0 });
export const formatCount = (value: number): string => kWhole.format(value);

/** A mean time of a run: three digits, with the unit that suits. */
export function formatSeconds(seconds: number): string {
  const units = [
    [1, 's'],
    [1e-3, 'ms'],
    [1e-6, 'µs'],
  ] as const;
  const [size, name] = units.find(([size]) => seconds >= size) ?? units[2];
  const value = seconds / size;
  if (value >= 100) return `${kWhole.format(value)} ${name}`;
  return `${value.toFixed(value >= 10 ? 1 : 2)} ${name}`;
}

export function formatDuration(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds));
  const days = Math.floor(whole / 86400);
  const [hours, minutes] = [Math.floor(whole / 3600) % 24, Math.floor(whole / 60) % 60];
  if (days > 0) return `${days} d ${hours} h`;
  if (hours > 0) return `${hours} h ${minutes} min`;
  return minutes > 0 ? `${minutes} min ${whole % 60} s` : `${whole} s`;
}

export const formatShare = (part: number, whole: number): string =>
  whole > 0 ? `${Math.round((100 * part) / whole)} %` : '0 %';
