/**
 * Orders texts by their UTF-16 code units, whatever the language of the system.
 * @return below 0 when `a` comes first, above 0 when `b` does, 0 for equal texts
 */
export function compareText(a: string, b: string): number {
  if (a < b) return -1;
  return a > b ? 1 : 0;
}
