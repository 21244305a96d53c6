/** Numbers from a fixed seed. */
export function randomOf(seed: number): (below: number) => number {
  let state = seed;
  return (below) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return Math.floor((state / 2 ** 32) * below);
  };
}

/** Bytes that occur unequally often. */
export const skewed = (count: number): Uint8Array => {
  const random = randomOf(1);
  return Uint8Array.from({ length: count }, () => {
    const r = random(65536);
    return 97 + Math.min(r % 7, r % 11, r % 13);
  });
};

export const bytesOf = (...numbers: number[]): Uint8Array => Uint8Array.from(numbers);
