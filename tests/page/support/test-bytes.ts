/** Numbers in [0, 1) from a fixed seed. */
export function makeShare(seed: number): () => number {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

/** Whole numbers from a fixed seed. */
export function makeRandom(seed: number): (below: number) => number {
  const share = makeShare(seed);
  return (below) => Math.floor(share() * below);
}

/** Bytes that occur unequally often. */
export const skewed = (count: number): Uint8Array => {
  const random = makeRandom(1);
  return Uint8Array.from({ length: count }, () => {
    const r = random(65536);
    return 97 + Math.min(r % 7, r % 11, r % 13);
  });
};

export const toBytes = (...numbers: number[]): Uint8Array => Uint8Array.from(numbers);
