import * as fc from 'fast-check';

/** One thing that goes wrong with a file on its way; positions wrap around at the end of it. */
export type Damage =
  | { readonly kind: 'byte'; readonly at: number; readonly value: number }
  | {
      readonly kind: 'number';
      readonly at: number;
      readonly bytes: 2 | 4 | 8;
      readonly value: bigint;
    }
  | { readonly kind: 'real'; readonly at: number; readonly value: number }
  | { readonly kind: 'cut'; readonly at: number }
  | { readonly kind: 'insert'; readonly at: number; readonly piece: Uint8Array }
  | { readonly kind: 'drop'; readonly at: number; readonly length: number }
  | {
      readonly kind: 'repeat';
      readonly at: number;
      readonly length: number;
      readonly times: number;
    };

/**
 * Which of the good files, and what happens to it: small enough to be printed, unlike the file
 * itself.
 */
export type Damaged = { readonly base: number; readonly damages: readonly Damage[] };

/** Headers lie at the start and directories at the end, so that half of all damage goes there. */
const at = fc.oneof(fc.nat(400), fc.integer({ min: -100, max: -1 }), fc.nat(2 ** 20));
/** Limits of signed and unsigned numbers of all widths, and what lies next to them. */
const limit = fc
  .tuple(
    fc.constantFrom(0n, 7n, 8n, 15n, 16n, 31n, 32n, 53n, 63n, 64n),
    fc.bigInt({ min: -2n, max: 2n }),
  )
  .map(([bits, more]) => BigInt.asUintN(64, 2n ** bits + more));

const damage: fc.Arbitrary<Damage> = fc.oneof(
  fc.record({ kind: fc.constant('byte' as const), at, value: fc.nat(255) }),
  fc.record({
    kind: fc.constant('number' as const),
    at,
    bytes: fc.constantFrom(2 as const, 4 as const, 8 as const),
    value: limit,
  }),
  fc.record({ kind: fc.constant('real' as const), at, value: fc.double() }),
  fc.record({ kind: fc.constant('cut' as const), at }),
  fc.record({ kind: fc.constant('insert' as const), at, piece: fc.uint8Array({ maxLength: 40 }) }),
  fc.record({ kind: fc.constant('drop' as const), at, length: fc.integer({ min: 1, max: 200 }) }),
  fc.record({
    kind: fc.constant('repeat' as const),
    at,
    length: fc.integer({ min: 1, max: 60 }),
    times: fc.nat(40),
  }),
);

/** @param bases how many good files there are */
export function arbitraryDamage(bases: number): fc.Arbitrary<Damaged> {
  return fc.record({
    base: fc.nat(bases - 1),
    damages: fc.array(damage, { minLength: 1, maxLength: 6 }),
  });
}

/** The file as it arrives. */
export function arrived(files: readonly Buffer[], { base, damages }: Damaged): Buffer {
  let bytes: Buffer = Buffer.from(files[base] ?? Buffer.alloc(0));
  for (const one of damages) bytes = withDamage(bytes, one);
  return bytes;
}

function withDamage(bytes: Buffer, one: Damage): Buffer {
  if (bytes.length === 0) return bytes;
  const start = ((one.at % bytes.length) + bytes.length) % bytes.length;
  switch (one.kind) {
    case 'byte':
      bytes.writeUInt8(one.value, start);
      return bytes;
    case 'number':
    case 'real': {
      const number = Buffer.alloc(8);
      if (one.kind === 'real') number.writeDoubleLE(one.value);
      else number.writeBigUInt64LE(one.value);
      number.copy(bytes, start, 0, one.kind === 'real' ? 8 : one.bytes);
      return bytes;
    }
    case 'cut':
      return bytes.subarray(0, start);
    case 'insert':
      return Buffer.concat([bytes.subarray(0, start), one.piece, bytes.subarray(start)]);
    case 'drop':
      return Buffer.concat([bytes.subarray(0, start), bytes.subarray(start + one.length)]);
    case 'repeat': {
      const piece = bytes.subarray(start, start + one.length);
      const copies = Array.from({ length: one.times }, () => piece);
      return Buffer.concat([bytes.subarray(0, start), ...copies, bytes.subarray(start)]);
    }
  }
}
