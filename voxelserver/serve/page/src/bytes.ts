/** Bytes in memory. */

export const toView = (bytes: Uint8Array): DataView =>
  new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);

export function join(parts: readonly Uint8Array[]): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}

/** @return undefined where there are more than `limit` bytes */
export async function collect(
  chunks: AsyncIterable<Uint8Array>,
  limit: number,
): Promise<Uint8Array<ArrayBuffer> | undefined> {
  const parts: Uint8Array[] = [];
  let size = 0;
  for await (const chunk of chunks) {
    size += chunk.length;
    if (size > limit) return undefined;
    parts.push(chunk);
  }
  return join(parts);
}

/** Unpacks a stream. @throws TypeError for what is no such stream */
export async function inflate(packed: Uint8Array, format: CompressionFormat): Promise<Uint8Array> {
  const stream = new Blob([packed.slice()]).stream();
  const unpacked = new Response(stream.pipeThrough(new DecompressionStream(format)));
  return new Uint8Array(await unpacked.arrayBuffer());
}

/** A half float (IEEE 754 binary16) as a number. */
export function fromHalf(half: number): number {
  const exponent = (half >> 10) & 31;
  const mantissa = half & 0x3ff;
  const size = exponent === 0 ? mantissa * 2 ** -24 : (mantissa + 1024) * 2 ** (exponent - 25);
  return (half & 0x8000) !== 0 ? -size : size;
}
