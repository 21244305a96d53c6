/** A half float (IEEE 754 binary16) as a number. */
export function fromHalf(half: number): number {
  const exponent = (half >> 10) & 31;
  const mantissa = half & 0x3ff;
  const size = exponent === 0 ? mantissa * 2 ** -24 : (mantissa + 1024) * 2 ** (exponent - 25);
  return (half & 0x8000) !== 0 ? -size : size;
}
