import assert from 'node:assert/strict';
import { test } from 'node:test';
import { readBox } from '../../voxelserver/page/src/box-reader.js';
import { Archive } from '../../voxelserver/page/src/viewer/data/archive.js';
import { ArchiveSource } from '../../voxelserver/page/src/viewer/data/archive-source.js';
import { readBoxArrays } from '../../voxelserver/page/src/viewer/data/box-arrays.js';
import { DataError, type DataErrorKind } from '../../voxelserver/page/src/viewer/data/errors.js';
import type { Environment } from '../../voxelserver/page/src/viewer/data/environment.js';
import { readFacts } from '../../voxelserver/page/src/viewer/data/facts.js';
import type { FromWorker } from '../../voxelserver/page/src/viewer/data/protocol.js';
import { RangeFile } from '../../voxelserver/page/src/viewer/data/range-file.js';
import { planRanges } from '../../voxelserver/page/src/viewer/data/range-plan.js';
import { Scheduler } from '../../voxelserver/page/src/viewer/data/scheduler.js';
import { ServerSource } from '../../voxelserver/page/src/viewer/data/server-source.js';
import { Session } from '../../voxelserver/page/src/viewer/data/session.js';
import type { BoxSource, Column } from '../../voxelserver/page/src/viewer/data/source.js';
import { xxh64, type Hash64 } from '../../voxelserver/page/src/viewer/data/xxh64.js';
import { unpack } from '../../voxelserver/page/src/viewer/data/zstd.js';
import type { ColumnKey } from '../../voxelserver/page/src/viewer/data/column-key.js';
import {
  boxBytes,
  kFacts,
  makeArchive,
  sealBox,
  slowXxh64,
  zstdBlock,
  zstdFrame,
  zstdFrameOf,
  type ArchiveOptions,
  type Key,
  type RawEntry,
  type RawLeaf,
  type TestBox,
} from './support/make-archive.js';
import { makeBox, type Voxel } from './support/make-box.js';

const kOpen = new AbortController().signal;

/** Numbers from a fixed seed. */
function randomOf(seed: number): (below: number) => number {
  let state = seed;
  return (below) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return Math.floor((state / 2 ** 32) * below);
  };
}

/** The kind of the DataError that this throws. */
function kindOf(work: () => unknown): DataErrorKind | 'none' {
  try {
    work();
    return 'none';
  } catch (error) {
    assert.ok(error instanceof DataError, String(error));
    return error.kind;
  }
}

async function kindOfAsync(work: Promise<unknown>): Promise<DataErrorKind | 'none'> {
  const [result] = await Promise.allSettled([work]);
  return kindOf(() => {
    if (result.status === 'rejected') throw result.reason;
  });
}

/** Time that passes only when nothing else happens: then the next timer is due. */
class FakeClock {
  readonly waits: number[] = [];
  #now = 1_700_000_000_000;
  readonly #timers = new Set<{ at: number; run: () => void }>();

  now(): number {
    return this.#now;
  }

  after(ms: number, run: () => void): () => void {
    const timer = { at: this.#now + ms, run };
    this.#timers.add(timer);
    return () => this.#timers.delete(timer);
  }

  /** Lets time pass until the work is done. */
  async finish<T>(work: Promise<T>): Promise<T> {
    let isDone = false;
    const done = (): void => void (isDone = true);
    work.then(done, done);
    for (let idle = 0; !isDone; ++idle) {
      await new Promise((resolve) => setImmediate(resolve));
      if (idle > 20 && this.#runNext()) idle = 0;
      assert.ok(idle < 10_000, 'nothing happens any more');
    }
    return work;
  }

  #runNext(): boolean {
    const [next] = [...this.#timers].sort((a, b) => a.at - b.at);
    if (next === undefined) return false;
    this.#timers.delete(next);
    if (next.at > this.#now) this.waits.push(next.at - this.#now);
    this.#now = next.at;
    next.run();
    return true;
  }
}

type Handler = (url: string, init: RequestInit) => Response | Promise<Response>;
type Asked = { readonly url: string; readonly init: RequestInit };

/** Files on a web server, and switches for what may go wrong. */
class FakeHost {
  readonly clock = new FakeClock();
  readonly files = new Map<string, Uint8Array>();
  readonly asked: Asked[] = [];
  etag: string | undefined = '"one"';
  /** Answers instead of the files, one after the other; undefined: as usual. */
  readonly next: (Handler | undefined)[] = [];
  handler: Handler = (url, init) => this.#answer(url, init);
  readonly environment: Environment = {
    clock: this.clock,
    random: () => 0.5,
    origin: 'http://host',
    fetch: (url, init) => this.#fetch(url, init),
  };
  readonly http = {
    environment: this.environment,
    stats: { requests: 0, bytes: 0 },
    timeoutMs: 30_000,
  };

  constructor(files: Readonly<Record<string, Uint8Array>> = {}) {
    for (const [url, bytes] of Object.entries(files)) this.files.set(url, bytes);
  }

  file(place: ConstructorParameters<typeof RangeFile>[1] = 'http://host/a'): RangeFile {
    return new RangeFile(this.http, place);
  }

  async open(url = 'http://host/a'): Promise<Archive> {
    return this.clock.finish(Archive.open(this.file(url), kOpen));
  }

  async #fetch(url: string, init: RequestInit): Promise<Response> {
    this.asked.push({ url, init });
    init.signal?.throwIfAborted();
    return (this.next.shift() ?? this.handler)(url, init);
  }

  #answer(url: string, init: RequestInit): Response {
    const bytes = this.files.get(url);
    if (bytes === undefined) return new Response('no', { status: 404 });
    const headers = new Headers(init.headers);
    if ((headers.get('If-Match') ?? this.etag) !== this.etag)
      return new Response('', { status: 412 });
    const own: Record<string, string> = this.etag === undefined ? {} : { ETag: this.etag };
    const [, from, to] = /bytes=(\d+)-(\d+)/.exec(headers.get('Range') ?? '') ?? [];
    if (Number(from) >= bytes.length)
      return new Response('', {
        status: 416,
        headers: { ...own, 'Content-Range': `bytes */${bytes.length}` },
      });
    const end = Math.min(Number(to) + 1, bytes.length);
    const range = `bytes ${from}-${end - 1}/${bytes.length}`;
    return new Response(bytes.slice(Number(from), end), {
      status: 206,
      headers: { ...own, 'Content-Range': range },
    });
  }
}

const status =
  (code: number, headers: Record<string, string> = {}): Handler =>
  () =>
    new Response(code === 204 ? null : 'x', { status: code, headers });

/** A body that never ends, or fails; it has these bytes before. */
function brokenBody(bytes: number, how: 'hangs' | 'fails' | 'ends'): ReadableStream<Uint8Array> {
  return new ReadableStream<Uint8Array>({
    pull(controller) {
      if (bytes > 0) controller.enqueue(new Uint8Array(bytes));
      if (how === 'fails') controller.error(new TypeError('network'));
      if (how === 'ends') controller.close();
      return how === 'hangs' ? new Promise(() => undefined) : undefined;
    },
  });
}

const partOf = (body: BodyInit, range: string, etag = '"one"'): Response =>
  new Response(body, { status: 206, headers: { 'Content-Range': range, ETag: etag } });

/* Hashes. */

const big = ({ low, high }: Hash64): bigint => (BigInt(high) << 32n) | BigInt(low);
const halves = (value: bigint): Hash64 => ({
  low: Number(value & 0xffffffffn),
  high: Number(value >> 32n),
});

// Of xxhash's own sanity check: bytes of this generator, and a prime as the seed.
const kVectors = [
  [0, 0n, 0xef46db3751d8e999n],
  [0, 0x9e3779b1n, 0xac75fda2929b17efn],
  [1, 0n, 0xe934a84adb052768n],
  [1, 0x9e3779b1n, 0x5014607643a9b4c3n],
  [4, 0n, 0x9136a0dca57457een],
  [14, 0n, 0x8282dcc4994e35c8n],
  [14, 0x9e3779b1n, 0xc3bd6bf63deb6df0n],
  [31, 0xfedcba9876543210n, 0x18865f92dd3ab2d4n],
  [32, 0n, 0x18b216492bb44b70n],
  [33, 0x9e3779b1n, 0xe92c292f64bc3071n],
  [63, 0xfedcba9876543210n, 0xed074a73230ebe21n],
  [222, 0n, 0xb641ae8cb691c174n],
  [222, 0x9e3779b1n, 0x20cb8ab7ae10c14an],
] as const;

test('XXH64 gives the official values, with and without a seed', () => {
  const bytes = new Uint8Array(222);
  let state = 0x9e3779b1n;
  for (let i = 0; i < bytes.length; ++i) {
    bytes[i] = Number(state >> 56n);
    state = BigInt.asUintN(64, state * 0x9e3779b185ebca8dn);
  }
  for (const [length, seed, hash] of kVectors)
    assert.equal(big(xxh64(bytes.subarray(0, length), halves(seed))), hash, `${length}, ${seed}`);
  const random = randomOf(1);
  for (let length = 0; length < 200; ++length) {
    const some = Uint8Array.from({ length }, () => random(256));
    const seed = BigInt.asUintN(64, slowXxh64(some));
    assert.equal(big(xxh64(some, halves(seed))), slowXxh64(some, seed), `${length}`);
  }
});

/* Frames. */

const kWords = ['rock ', 'grass ', 'water ', 'roof ', 'tower of glass '];
const lines = (count: number): Uint8Array => {
  const random = randomOf(1);
  const text = Array.from({ length: count }, () => kWords[random(65536) % 5]).join('');
  return new TextEncoder().encode(text);
};
const skewed = (count: number): Uint8Array => {
  const random = randomOf(1);
  return Uint8Array.from({ length: count }, () => {
    const r = random(65536);
    return 97 + Math.min(r % 7, r % 11, r % 13);
  });
};

// Of the zstd program (1.5.4): sequences with tables that are new, then repeated, and a checksum;
// literals with a Huffman code that is new, then repeated; literals in four streams.
const kFrames = {
  repeated: [
    'KLUv/WSxBgwCAOhncmFzcyByb2NrIHdhdGVydG93ZXIgb2YgZ2xvZgug0GNlNyBEQBRCVh2Lsi6Vy1hdRCAIB8DBTg3o',
    'RDxLGy4FBAIAMGdyb2ZvZh38Qaix/fSzfyfsEOSh4089Gt6T2vQQGg37zBhmQ4EpI76tjJmHYQBRMTarn+Qp03NTts1R',
    'hhj5hgwCAAAe/Cc3WTaHmdM1q33QGDTsye/9EX2rLSPNEyfK78dxiR84nc22O9X71FnHj90dDBJn6oTjbzHbSbG06YhH',
    'NDwO1QEAEGdyGfwoI1Dp1jkMC2PAmMJZw3oF46w/o7doHvm4krszUUIcyVOG+sI8/HzbEX00MUQ1UHlOvpRlHTJQbwA=',
  ],
  treeless: [
    'KLUv/WS8AVwCAIKFCQjg6VtKyQBVB0sY1ZiAvuzvIzIlqU1oPbaUR7vJirQlMcwZXjpqBahBIXSISmaCpiTVwgEQEmIU',
    'pD4QuHwhRPU5nE/3kll0VAwCANNFCBLelkPXOr0MchvLOcMMvMRriBwAFNmBPE+J+sxIUSomBA/8IURFxVpjOrLonkO0',
    'mJ0UmPJS0Z9+jSwKEwgBBAIAo0UIEYGdE4ULCARvSeWAzO/JGQXFBwMBs+psbxFFb80BGEECDvyxQQla/Yvxj81oZeH8',
    'U6Dmk+6REO4jTkl3dRQCAFMDBfEyA5ExabateMIoWidbSBXKQgkBGPySYNO9AahNZ2ETJg8jNDWBH4VBQuo1dbjtXhfE',
    'ZNcA8uuePJrm7OYiFp0BAGOCAxszdrlpm5OIMQCeAWsIE/zwGcFyVOWPK9hU/M+eDp5uhRGFw+1xFxZ+zlXTYZ+PUfSP',
    'QI8=',
  ],
  streams: [
    'KLUv/WS8AWUJAKaWIwjg6VtKyQBVBx4AIAAhABOWMKoxAX3Z30dkSlKb0HpsKY92kxVpS2KYM7x01JHwthy61ullkNtY',
    'zhlm4CVeQ+QAoMgO5HlK1GdGilIRQkRg50ThAgLBW1I5IPN7ckZB8cFAwKw621tE0VtzAEYQGzN2uWmbk4gxAJ4Ba4iX',
    'GYiMSbNtxRNG0TrZQqpQFipNqEEhdIhKZoKmJNXCARASYhSkPhC4fPAZwXJU5Y8r2FT8z54Onm6FEYXD7XEXFn7OVdNh',
    'X46EsZne4FSms7AJk4cRmprAj8IgIfWaOtx2rwtismsA+XVPHk1zdgsxWsla7Yvwh83QKuHwp0DNk+4iIdpHXBK3YEaX',
    'xWFTurPonyO0mp0XOHmp6U+/RhYFFkIY1fdwBt1LZtFRAfSPQI8=',
  ],
};
const frameOf = (lines: readonly string[]): Uint8Array =>
  new Uint8Array(Buffer.from(lines.join(''), 'base64'));
const bytesOf = (...numbers: number[]): Uint8Array => Uint8Array.from(numbers);

test('frames unpack to their content, whatever their blocks are', () => {
  const runs = new Uint8Array(300_000).fill(7, 1000, 290_000);
  for (const content of [new Uint8Array(0), bytesOf(9), skewed(5000), runs])
    assert.deepEqual(unpack(zstdFrame(content), content.length), content);
  assert.deepEqual(unpack(frameOf(kFrames.repeated), 4000), lines(260));
  assert.deepEqual(unpack(frameOf(kFrames.treeless), 4000), skewed(700));
  assert.deepEqual(unpack(frameOf(kFrames.streams), 4000), skewed(700));
});

test('a frame must declare the size that it has, which is checked before memory is taken', () => {
  const content = skewed(100);
  const frame = zstdFrame(content);
  const raw = (size: number): Uint8Array => zstdBlock('raw', size, content.subarray(0, size));
  const magic = [0x28, 0xb5, 0x2f, 0xfd];
  const cases: [string, DataErrorKind, Uint8Array][] = [
    ['another magic number', 'damaged', frame.map((byte, i) => (i === 0 ? 0 : byte))],
    ['a size above the limit', 'too-large', zstdFrameOf(1001, [raw(100)])],
    ['4 GiB', 'too-large', zstdFrameOf(0xffffffff, [zstdBlock('rle', 100, bytesOf(1))])],
    ['fewer bytes than declared', 'damaged', zstdFrameOf(101, [raw(100)])],
    ['more bytes than declared', 'damaged', zstdFrameOf(99, [raw(100)])],
    ['an RLE block beyond the end', 'damaged', zstdFrameOf(9, [zstdBlock('rle', 10, bytesOf(1))])],
    ['a byte after it', 'damaged', Uint8Array.from([...frame, 0])],
    ['a frame after it', 'damaged', Uint8Array.from([...frame, ...frame])],
    ['no declared size', 'damaged', Uint8Array.from([...magic, 0x00, 0x58, 1, 0, 0])],
    ['a dictionary', 'damaged', Uint8Array.from([...magic, 0x21, 5, 0, 1, 0, 0])],
    [
      'a window of 2^40 bytes',
      'damaged',
      Uint8Array.from([...magic, 0x80, 0xf0, 0, 0, 0, 0, 1, 0, 0]),
    ],
    ['a reserved bit', 'damaged', frame.map((byte, i) => (i === 4 ? byte | 8 : byte))],
    ['no blocks', 'damaged', frame.subarray(0, 9)],
    ['half of a block', 'damaged', frame.subarray(0, 50)],
    ['nothing', 'damaged', new Uint8Array(0)],
  ];
  for (const [name, kind, bytes] of cases)
    assert.equal(
      kindOf(() => unpack(bytes, 1000)),
      kind,
      name,
    );
});

// Each of them occupies other decoders for minutes, or for ever.
test('small frames that ask for endless work are refused at once', () => {
  const huffman = (10 << 4) | 2 | (10 << 14);
  const oneSymbol = (63 << 4) | 0;
  const body = (type: 'raw' | 'compressed', ...bytes: number[]): Uint8Array =>
    zstdBlock(type, bytes.length, Uint8Array.from(bytes));
  const bombs: [string, Uint8Array][] = [
    [
      'sequences of the longest runs, which take no bits',
      zstdFrameOf(1000, [body('compressed', 9, 7, 255, 255, 31, 0x54, 35, 0, 52, 255)]),
    ],
    [
      'Huffman weights of states that take no bits',
      zstdFrameOf(1000, [
        body(
          'compressed',
          ...[
            huffman & 255,
            (huffman >> 8) & 255,
            huffman >> 16,
            4,
            oneSymbol & 255,
            oneSymbol >> 8,
          ],
          ...[255, 255, 1, 1, 1, 1, 1, 1, 0],
        ),
      ]),
    ],
    [
      'blocks of nothing',
      zstdFrameOf(
        1,
        Array.from({ length: 100_000 }, () => body('raw')),
      ),
    ],
  ];
  for (const [name, frame] of bombs) {
    const start = performance.now();
    assert.equal(
      kindOf(() => unpack(frame, 1 << 20)),
      'damaged',
      name,
    );
    assert.ok(performance.now() - start < 1000, name);
  }
});

test('a changed byte of a frame gives an error or bytes of the declared size, and soon', () => {
  const random = randomOf(7);
  for (const frame of Object.values(kFrames).map(frameOf))
    for (let at = 0; at < frame.length; ++at)
      for (const change of [1 << random(8), 1 + random(255)]) {
        const changed = frame.map((byte, i) => (i === at ? byte ^ change : byte));
        const kind = kindOf(() => assert.ok(unpack(changed, 100_000).length <= 100_000));
        assert.ok(['none', 'damaged', 'too-large'].includes(kind));
      }
});

/* Boxes. */

const kKey = { level: 1, bx: -2, by: 0, bz: 3 };
const keyOf = ({ level, bx, by, bz }: typeof kKey): Key => [level, bx, by, bz];
const kVoxels: Voxel[] = [
  { x: 0, y: 0, z: 0, material: 4 },
  { x: 63, y: 255, z: 63, material: 32, rgb: [1, 2, 3] },
  { x: 5, y: 70, z: 6, material: 13, rgb: [255, 0, 128] },
  { x: 6, y: 70, z: 6, material: 0 },
  { x: 5, y: 130, z: 40, material: 200, rgb: [9, 9, 9] },
  { x: 5, y: 131, z: 40, material: 33 },
];

/** The attribute of a voxel by a walk through the arrays. */
function attributeAt(box: ReturnType<typeof readBoxArrays>, voxel: Voxel): number | undefined {
  let cell = voxel.y >> 6;
  for (const shift of [4, 2, 0]) {
    const part = (value: number): number => (value >> shift) & 3;
    const bit = BigInt(part(voxel.x) + 4 * part(voxel.z) + 16 * part(voxel.y));
    const word = (i: number): bigint => BigInt(box.cells[4 * cell + i]!);
    const detail = word(2) | (word(3) << 32n);
    if (((detail >> bit) & 1n) === 0n) return undefined;
    const before = detail & ((1n << bit) - 1n);
    const index = box.first[cell]! + before.toString(2).replaceAll('0', '').length;
    assert.ok(index < (shift === 0 ? box.attributes : box.first).length);
    if (shift === 0) return box.attributes[index];
    cell = index;
  }
  return undefined;
}

test('arrays of a box hold every voxel with its material, colour and class', () => {
  const bytes = makeBox(kVoxels);
  bytes[bytes.length - 8 * kVoxels.length + 1] = 200;
  const box = readBoxArrays(sealBox(bytes, keyOf(kKey)), kKey);
  assert.equal(box.cells.length, 4 * box.first.length);
  assert.equal(box.attributes.length, kVoxels.length);
  assert.equal(box.classes[0], 200);
  for (const voxel of kVoxels) {
    const [r, g, b] = voxel.rgb ?? [0, 0, 0];
    const material = voxel.material > 32 ? 23 : voxel.material;
    const colour = r + g * 2 ** 8 + b * 2 ** 16 + material * 2 ** 24;
    assert.equal(attributeAt(box, voxel), colour + (voxel.rgb ? 2 ** 31 : 0));
  }
  assert.equal(attributeAt(box, { x: 1, y: 0, z: 0, material: 0 }), undefined);
  // From any place of a larger buffer.
  const moved = Buffer.concat([Buffer.alloc(3), bytes]).subarray(3);
  assert.deepEqual(readBoxArrays(moved, kKey), box);
});

test('the top of a box is the same as by the reader of the map', () => {
  const random = randomOf(3);
  const voxels = Array.from({ length: 400 }, () => {
    return { x: random(64), y: random(256), z: random(64), material: 1 + random(32) };
  });
  const places = new Map(voxels.map((voxel) => [`${voxel.x},${voxel.y},${voxel.z}`, voxel]));
  const bytes = sealBox(makeBox([...places.values()]), keyOf(kKey));
  const arrays = readBoxArrays(bytes, kKey);
  for (const voxel of places.values()) {
    const top = readBox(bytes).top(voxel.x, voxel.z);
    assert.ok(top !== undefined && top.y >= voxel.y);
    assert.equal(attributeAt(arrays, { ...voxel, y: top.y })! >>> 24, top.look?.material);
  }
});

test('a box with any changed byte is refused', () => {
  const box = boxBytes(keyOf(kKey), kVoxels);
  for (let at = 0; at < box.length; ++at) {
    const changed = box.map((byte, i) => (i === at ? byte ^ 0x10 : byte));
    assert.equal(
      kindOf(() => readBoxArrays(changed, kKey)),
      'damaged',
      `byte ${at}`,
    );
  }
  for (const length of [0, 63, 64, box.length - 1])
    assert.equal(
      kindOf(() => readBoxArrays(box.subarray(0, length), kKey)),
      'damaged',
    );
  assert.equal(
    kindOf(() => readBoxArrays(box, { ...kKey, bz: 4 })),
    'damaged',
  );
});

test('a box whose checksum holds is refused when an index leaves the order of the format', () => {
  const good = boxBytes(keyOf(kKey), kVoxels);
  const cells = new DataView(good.buffer).getUint32(28, true);
  const change = (at: number, value: number, size = good.length): Uint8Array => {
    const bytes = new Uint8Array(size);
    bytes.set(good.subarray(0, size));
    new DataView(bytes.buffer).setUint32(at, value, true);
    return bytes;
  };
  const lastBrick = 64 + 24 * (cells - 1);
  const cases: [string, Uint8Array][] = [
    ['the first child of a root', change(64 + 16, 5)],
    ['the first attribute of a brick', change(lastBrick + 16, 1)],
    ['detail where there is no mask', change(64, 0)],
    ['a bit of detail more', change(64 + 8, 3)],
    ['a bit of detail less', change(lastBrick + 12, 0)],
    ['more cells than there are', change(28, cells + 1)],
    ['too few cells', change(28, 3)],
    ['too many cells', change(28, 16_645)],
    ['too many attributes', change(32, 1_048_577)],
    ['a cell too many', change(28, cells + 1, good.length + 24)],
    ['an attribute too many', change(32, kVoxels.length + 1, good.length + 8)],
    ['another version', change(8, 2)],
  ];
  assert.equal(
    kindOf(() => readBoxArrays(sealBox(good.slice(), keyOf(kKey)), kKey)),
    'none',
  );
  for (const [name, bytes] of cases)
    assert.equal(
      kindOf(() => readBoxArrays(sealBox(bytes, keyOf(kKey)), kKey)),
      'damaged',
      name,
    );
  const level = { ...kKey, level: 21 };
  assert.equal(
    kindOf(() => readBoxArrays(sealBox(good.slice(), keyOf(level)), level)),
    'damaged',
  );
});

test('no walk leaves the arrays of a box that was accepted, whatever its cells say', () => {
  const good = boxBytes(keyOf(kKey), kVoxels);
  const cells = new DataView(good.buffer).getUint32(28, true);
  const random = randomOf(13);
  let accepted = 0;
  for (let i = 0; i < 1000; ++i) {
    const bytes = good.slice();
    const at = 64 + random(24 * cells);
    bytes[at]! ^= 1 << random(8);
    sealBox(bytes, keyOf(kKey));
    if (kindOf(() => readBoxArrays(bytes, kKey)) !== 'none') continue;
    accepted += 1;
    const box = readBoxArrays(bytes, kKey);
    for (const voxel of kVoxels) {
      const attribute = attributeAt(box, voxel);
      assert.ok(attribute === undefined || attribute <= 0xffffffff);
    }
  }
  // A bit of a mask without detail, and what is reserved, may change.
  assert.ok(accepted > 0 && accepted < 900, `${accepted}`);
});

/* Ranges of files. */

test('ranges are merged over small gaps, up to a size, and each is in one request', () => {
  const KiB = 1024;
  const cases: [string, [number, number][], [number, number][]][] = [
    ['none', [], []],
    [
      'a gap of 32 KiB',
      [
        [0, 10],
        [10 + 32 * KiB, 10],
      ],
      [[0, 20 + 32 * KiB]],
    ],
    [
      'a larger gap',
      [
        [0, 10],
        [11 + 32 * KiB, 10],
      ],
      [
        [0, 10],
        [11 + 32 * KiB, 10],
      ],
    ],
    [
      'out of order, overlapping',
      [
        [50, 50],
        [0, 60],
        [20, 10],
      ],
      [[0, 100]],
    ],
    [
      '1 MiB',
      [
        [0, 1000 * KiB],
        [1000 * KiB, 24 * KiB],
      ],
      [[0, 1024 * KiB]],
    ],
    [
      'above',
      [
        [0, 1000 * KiB],
        [1000 * KiB, 25 * KiB],
      ],
      [
        [0, 1000 * KiB],
        [1000 * KiB, 25 * KiB],
      ],
    ],
    ['a large one', [[5, 3000 * KiB]], [[5, 3000 * KiB]]],
  ];
  for (const [name, wanted, requests] of cases) {
    const plan = planRanges(wanted.map(([offset, bytes]) => ({ offset, bytes })));
    assert.deepEqual(
      plan.map(({ offset, bytes }) => [offset, bytes]),
      requests,
      name,
    );
    assert.equal(plan.flatMap(({ ranges }) => ranges).length, wanted.length, name);
  }
});

const kContent = Uint8Array.from({ length: 1000 }, (_, i) => i % 251);
const read = (host: FakeHost, file: RangeFile, offset: number, length: number) =>
  host.clock.finish(file.read(offset, length, kOpen));

test('a file is read by ranges, and its size is that of the first reply', async () => {
  const host = new FakeHost({ 'http://host/a': kContent });
  const file = host.file();
  assert.equal(file.size, undefined);
  assert.deepEqual(await host.clock.finish(file.head(64, kOpen)), kContent.subarray(0, 64));
  assert.equal(file.size, 1000);
  assert.deepEqual(await read(host, file, 900, 100), kContent.subarray(900));
  assert.equal((await read(host, file, 5, 0)).length, 0);
  assert.equal(await kindOfAsync(read(host, file, 900, 101)), 'cut');
  assert.deepEqual(host.http.stats, { requests: 2, bytes: 164 });
  assert.deepEqual(
    host.asked.map(({ init }) => init.headers),
    [{ Range: 'bytes=0-63' }, { Range: 'bytes=900-999', 'If-Match': '"one"' }],
  );
  const small = host.file();
  assert.equal((await host.clock.finish(small.head(5000, kOpen))).length, 1000);
});

test('parts of a file are read as one', async () => {
  const host = new FakeHost();
  const parts = [400, 1, 599].map((bytes, i) => ({ url: `http://other/${i}`, bytes }));
  let start = 0;
  for (const { url, bytes } of parts) {
    host.files.set(url, kContent.subarray(start, start + bytes));
    start += bytes;
  }
  const file = host.file(parts);
  assert.equal(file.size, 1000);
  assert.deepEqual(await read(host, file, 390, 20), kContent.subarray(390, 410));
  assert.equal(host.asked.length, 3);
  assert.deepEqual(await read(host, file, 500, 7), kContent.subarray(500, 507));
  assert.equal(host.asked.length, 4);
  // A condition would take a preflight request on another origin.
  assert.deepEqual(host.asked[3]!.init.headers, { Range: 'bytes=99-105' });
  host.files.set('http://other/0', kContent.subarray(0, 399));
  assert.equal(await kindOfAsync(read(host, host.file(parts), 0, 5)), 'changed');
  assert.equal(
    kindOf(() => host.file([{ url: 'http://h/', bytes: 0 }])),
    'damaged',
  );
});

test('failures of a host have their kinds; only those that may pass are tried again', async () => {
  const ok = 'bytes 0-9/1000';
  const cases: [string, Handler, DataErrorKind, number][] = [
    ['404', status(404), 'missing', 1],
    ['401', status(401), 'refused', 1],
    ['403', status(403), 'refused', 1],
    ['400', status(400), 'refused', 1],
    ['412', status(412), 'changed', 1],
    ['416', status(416, { 'Content-Range': 'bytes */5' }), 'range', 1],
    ['204', status(204), 'no-range', 1],
    ['429', status(429), 'server', 3],
    ['500', status(500), 'server', 3],
    ['503', status(503), 'server', 3],
    ['no network', () => Promise.reject(new TypeError('failed')), 'cors', 3],
    ['no reply', () => new Promise<Response>(() => undefined), 'timeout', 3],
    ['a stalled body', () => partOf(brokenBody(3, 'hangs'), ok), 'timeout', 3],
    ['a lost connection', () => partOf(brokenBody(3, 'fails'), ok), 'cut', 3],
    ['a short body', () => partOf(brokenBody(3, 'ends'), ok), 'cut', 3],
    ['a long body', () => partOf(brokenBody(99, 'hangs'), ok), 'no-range', 1],
    ['no Content-Range', () => new Response('x', { status: 206 }), 'no-range', 1],
    ['another range', () => partOf('0123456789', 'bytes 1-10/1000'), 'range', 1],
    ['a longer range', () => partOf('01234567890', 'bytes 0-10/1000'), 'range', 1],
    ['no size', () => partOf('0123456789', 'bytes 0-9/*'), 'no-range', 1],
  ];
  for (const [name, handler, kind, attempts] of cases) {
    const host = new FakeHost();
    host.handler = handler;
    const found = host.clock.finish(host.file().head(10, kOpen));
    assert.equal(await kindOfAsync(found), kind, name);
    assert.equal(host.asked.length, attempts, name);
    const message = await found.catch((error: Error) => error.message);
    assert.match(String(message), /^fetch http:\/\/host\/a, bytes 0 to 9: [^\n]+$|^read/, name);
  }
});

test('waits between attempts grow, and are as long as Retry-After, up to a minute', async () => {
  const waitsWith = async (headers: Record<string, string>): Promise<number[]> => {
    const host = new FakeHost({ 'http://host/a': kContent });
    host.next.push(status(503, headers), status(429, headers));
    assert.equal((await host.clock.finish(host.file().head(10, kOpen))).length, 10);
    return host.clock.waits;
  };
  assert.deepEqual(await waitsWith({}), [500, 2000]);
  assert.deepEqual(await waitsWith({ 'Retry-After': '7' }), [7000, 7000]);
  assert.deepEqual(await waitsWith({ 'Retry-After': '3600' }), [60_000, 60_000]);
});

test('a host that ignores ranges is accepted with a small file alone', async () => {
  const whole = (bytes: BodyInit, headers: Record<string, string> = {}): FakeHost => {
    const host = new FakeHost();
    host.handler = () => new Response(bytes, { status: 200, headers });
    return host;
  };
  const host = whole(kContent);
  const file = host.file();
  assert.deepEqual(await host.clock.finish(file.head(64, kOpen)), kContent.subarray(0, 64));
  assert.deepEqual(await read(host, file, 700, 300), kContent.subarray(700));
  assert.equal(host.asked.length, 1);
  let isRead = false;
  const body = new ReadableStream({ pull: () => void (isRead = true) }, { highWaterMark: 0 });
  const large = whole(body, { 'Content-Length': '9000000' });
  assert.equal(await kindOfAsync(large.clock.finish(large.file().head(64, kOpen))), 'no-range');
  assert.equal(isRead, false);
  // Without a stated length it is read up to the limit.
  const endless = whole(
    new ReadableStream({ pull: (to) => to.enqueue(new Uint8Array(1 << 20)) }, { highWaterMark: 0 }),
  );
  assert.equal(await kindOfAsync(endless.clock.finish(endless.file().head(64, kOpen))), 'no-range');
  assert.ok(endless.http.stats.bytes <= 10 << 20);
});

test('a file that changes ends reading for good, on any origin', async () => {
  const range = 'bytes 5-9/1000';
  const changes: [string, Handler][] = [
    ['another tag', () => partOf('56789', range, '"two"')],
    ['another size', () => partOf('56789', 'bytes 5-9/1001')],
    ['no tag', () => new Response('56789', { status: 206, headers: { 'Content-Range': range } })],
    ['412', status(412)],
    ['416 of a shorter file', status(416, { 'Content-Range': 'bytes */3', ETag: '"two"' })],
    ['all of another file', () => new Response('56789', { headers: { ETag: '"two"' } })],
  ];
  for (const url of ['http://host/a', 'http://other/a'])
    for (const [name, handler] of changes) {
      const host = new FakeHost({ [url]: kContent });
      const file = host.file(url);
      await host.clock.finish(file.head(64, kOpen));
      host.next.push(handler, handler);
      assert.equal(await kindOfAsync(read(host, file, 5, 5)), 'changed', `${url}: ${name}`);
      const asked = host.asked.length;
      assert.equal(await kindOfAsync(read(host, file, 5, 5)), 'changed', `${url}: ${name}`);
      assert.equal(host.asked.length, asked);
    }
});

test('an outdated reply of the cache is requested again, past the cache', async () => {
  for (const [url, etag] of [
    ['http://other/a', '"one"'],
    ['http://host/a', 'W/"one"'],
  ] as const) {
    const host = new FakeHost({ [url]: kContent });
    host.etag = etag;
    const file = host.file(url);
    await host.clock.finish(file.head(64, kOpen));
    host.next.push(() => partOf('56789', 'bytes 5-9/1000', '"old"'));
    assert.deepEqual(await read(host, file, 5, 5), kContent.subarray(5, 10));
    const modes = host.asked.map(({ init }) => init.cache);
    assert.deepEqual(modes, ['no-store', 'default', 'reload']);
  }
});

test('weak tags are compared and not sent; a date stands in for a tag', async () => {
  const host = new FakeHost({ 'http://host/a': kContent });
  host.etag = 'W/"one"';
  const file = host.file();
  await host.clock.finish(file.head(64, kOpen));
  await read(host, file, 5, 5);
  assert.deepEqual(host.asked[1]!.init.headers, { Range: 'bytes=5-9' });
  const date = 'Sun, 06 Nov 1994 08:49:37 GMT';
  const dated = new FakeHost();
  dated.handler = (_, init) => {
    const [, from, to] = /(\d+)-(\d+)/.exec(new Headers(init.headers).get('Range')!)!;
    const body = kContent.slice(Number(from), Number(to) + 1);
    const headers = { 'Content-Range': `bytes ${from}-${to}/1000`, 'Last-Modified': date };
    return new Response(body, { status: 206, headers });
  };
  const other = dated.file();
  await dated.clock.finish(other.head(64, kOpen));
  await read(dated, other, 5, 5);
  const sent = dated.asked[1]!.init.headers;
  assert.deepEqual(sent, { Range: 'bytes=5-9', 'If-Unmodified-Since': date });
});

test('a cancelled read rejects with the reason and sends nothing more', async () => {
  const host = new FakeHost();
  host.handler = () => partOf(brokenBody(3, 'hangs'), 'bytes 0-9/1000');
  const controller = new AbortController();
  const reading = host.file().head(10, controller.signal);
  await new Promise((resolve) => setImmediate(resolve));
  controller.abort(new Error('enough'));
  await assert.rejects(reading, /enough/);
  await assert.rejects(host.file().head(10, controller.signal), /enough/);
  assert.equal(host.asked.length, 1);
});

/* Archives. */

const kBoxes: TestBox[] = [
  { key: [0, 0, 0, 0], voxels: kVoxels },
  { key: [0, 0, -1, 0], voxels: [{ x: 1, y: 2, z: 3, material: 4 }] },
  { key: [0, 1, 0, 1], hole: 'the disk\nwas wet' },
  { key: [0, -1, 0, -2], voxels: [{ x: 9, y: 9, z: 9, material: 5, rgb: [1, 1, 1] }] },
  { key: [1, 0, 0, 0], voxels: [{ x: 7, y: 7, z: 7, material: 6 }] },
  { key: [2, 0, 0, 0], voxels: [{ x: 3, y: 200, z: 3, material: 7 }] },
];

const kColumns: ColumnKey[] = [2, 1, 0].flatMap((level) => {
  const side = 4 >> level;
  const places = Array.from({ length: side }, (_, i) => i - side / 2 || 0).map(Math.floor);
  return places.flatMap((bx) => places.map((bz) => ({ level, bx, bz })));
});
kColumns.push({ level: 2, bx: 0, bz: 0 });

const nameOf = ({ level, bx, bz }: ColumnKey): string => `${level}/${bx}/${bz}`;
const hostOf = (bytes: Uint8Array): FakeHost => new FakeHost({ 'http://host/a': bytes });
const archiveHost = (options?: ArchiveOptions, boxes = kBoxes): FakeHost =>
  hostOf(makeArchive(boxes, options));

async function collect(
  host: FakeHost,
  source: BoxSource,
  columns: readonly ColumnKey[],
): Promise<Map<string, Column | DataError>> {
  const found = new Map<string, Column | DataError>();
  const work = async (): Promise<void> => {
    for await (const result of source.columns(columns, kOpen))
      if ('column' in result) found.set(nameOf(result.column), result.column);
      else found.set(nameOf(result.failed), result.error);
  };
  await host.clock.finish(work());
  return found;
}

const columnsOf = async (host: FakeHost, columns = kColumns) =>
  collect(host, new ArchiveSource(await host.open(), host.clock), columns);

test('an archive gives every box that it holds, its holes, and air for all else', async () => {
  for (const entriesPerLeaf of [1024, 2, 1]) {
    const host = archiveHost({ entriesPerLeaf, header: { damage: 3 } });
    const { facts } = await host.open();
    assert.equal(facts.world.title, 'small');
    assert.equal(facts.damage, 3);
    const found = await columnsOf(host);
    assert.equal(found.size, new Set(kColumns.map(nameOf)).size);
    const column = found.get('0/0/0') as Column;
    assert.equal(column.byBegin, -1);
    const expected = kBoxes
      .slice(0, 2)
      .map(({ key: [level, bx, by, bz], voxels }) =>
        readBoxArrays(boxBytes([level, bx, by, bz], voxels!), { level, bx, by, bz }),
      );
    assert.deepEqual(column.boxes, expected.reverse());
    assert.deepEqual(found.get('0/1/1'), {
      ...{ level: 0, bx: 1, bz: 1, byBegin: 0 },
      boxes: [{ hole: 'the disk was wet' }],
    });
    const air = found.get('0/1/0');
    assert.deepEqual(air, { level: 0, bx: 1, bz: 0, byBegin: 0, boxes: [] });
    const full = [...found.values()].filter((c) => !(c instanceof DataError) && c.boxes.length > 0);
    assert.equal(full.length, 5);
    const outside = await columnsOf(host, [
      { level: 0, bx: 77, bz: 0 },
      { level: 3, bx: 0, bz: 0 },
    ]);
    assert.deepEqual((outside.get('0/77/0') as Column).boxes, []);
    assert.equal((outside.get('3/0/0') as DataError).kind, 'missing');
  }
});

test('a small archive opens with one request, and boxes of a column come with one', async () => {
  const small = archiveHost();
  await small.open();
  assert.equal(small.asked.length, 1);
  const host = archiveHost({ gapBytes: 20_000, entriesPerLeaf: 3 });
  const archive = await host.open();
  assert.equal(host.asked.length, 2);
  const source = new ArchiveSource(archive, host.clock);
  await collect(host, source, [{ level: 0, bx: 0, bz: 0 }]);
  assert.ok(host.asked.length <= 5);
  const before = host.asked.length;
  await collect(host, source, [{ level: 0, bx: 0, bz: 0 }]);
  assert.equal(host.asked.length, before + 1);
});

test('an archive with a changed byte gives the same columns or errors', async () => {
  const whole = makeArchive(kBoxes, { entriesPerLeaf: 3 });
  const good = await columnsOf(hostOf(whole));
  const random = randomOf(5);
  let refused = 0;
  for (let at = 0; at < whole.length; ++at) {
    const changed = whole.slice();
    changed[at]! ^= 1 << random(8);
    const found = await columnsOf(hostOf(changed)).catch((error: unknown) => {
      assert.ok(error instanceof DataError, `byte ${at}: ${String(error)}`);
      return undefined;
    });
    if (found === undefined) ++refused;
    for (const [name, column] of found ?? [])
      if (column instanceof DataError) ++refused;
      else assert.deepEqual(column, good.get(name), `byte ${at}, column ${name}`);
  }
  assert.ok(refused > whole.length * 0.6, `${refused} of ${whole.length}`);
});

test('an archive that is cut off or has more bytes is refused', async () => {
  const whole = makeArchive(kBoxes);
  for (const length of [1, 63, 64, 500, whole.length - 1])
    assert.notEqual(await kindOfAsync(hostOf(whole.slice(0, length)).open()), 'none', `${length}`);
  assert.equal(await kindOfAsync(hostOf(whole.slice(0, whole.length - 1)).open()), 'cut');
  assert.equal(await kindOfAsync(hostOf(new Uint8Array([...whole, 0])).open()), 'damaged');
});

const reversed = <T>(items: T[]): T[] => [...items].reverse();
const withLeaf = (change: Partial<RawLeaf>): ArchiveOptions => ({
  changeLeaves: ([first, ...rest]) => [{ ...first!, ...change }, ...rest],
});
const withEntry = (change: Partial<RawEntry>): ArchiveOptions => ({
  changeEntries: ([first, ...rest]) => [{ ...first!, ...change }, ...rest],
});

test('an index that lies is refused', async () => {
  const far: Key = [0, 2, 0, 0];
  const cases: [string, ArchiveOptions, TestBox[]?][] = [
    ['another version', { header: { version: 2 } }],
    ['never finished', { header: { rootOffset: 0 } }],
    ['a root beyond the end', { header: { rootOffset: 2 ** 40 } }],
    ['a root of half an entry', { header: { rootBytes: 28 } }],
    ['a root without a checksum', { header: { rootBytes: 0 } }],
    ['facts of 5 MiB', { header: { infoBytes: 5 << 20 } }],
    ['another length of the file', { header: { fileBytes: 1e6 } }],
    ['leaves out of order', { entriesPerLeaf: 2, changeLeaves: reversed }],
    ['a leaf twice', { entriesPerLeaf: 2, changeLeaves: ([a, ...rest]) => [a!, a!, ...rest] }],
    ['a leaf of no entries', withLeaf({ entries: 0 })],
    ['a leaf of 1025 entries', withLeaf({ entries: 1025 })],
    ['a leaf of more entries', withLeaf({ entries: 7 })],
    ['a leaf beyond the end', withLeaf({ offset: 1e12 })],
    ['a leaf of 4 GiB', withLeaf({ bytes: 0xffffffff })],
    ['a leaf with another first box', withLeaf({ first: far })],
    ['a leaf of level 21', withLeaf({ first: [21, 0, 0, 0] })],
    ['entries out of order', { changeEntries: reversed }],
    ['an entry twice', { changeEntries: ([a, ...rest]) => [a!, a!, ...rest] }],
    ['an entry of 4 GiB', withEntry({ bytes: 0xffffffff })],
    ['an entry beyond the end', withEntry({ offset: 1e12 })],
    ['an entry beyond 2^53', withEntry({ offset: 2 ** 60 })],
    ['an entry in the header', withEntry({ offset: 60 })],
    ['an entry of another kind', withEntry({ kind: 2 })],
    ['an entry of another length', withEntry({ bytes: 10 })],
    ['an entry of another place', withEntry({ offset: 900 })],
    ['a box outside of the bounds', {}, [...kBoxes, { key: far, voxels: [] }]],
    ['a box of another level', {}, [...kBoxes, { key: [3, 0, 0, 0], voxels: [] }]],
    ['a box far away', {}, [...kBoxes, { key: [0, 1 << 20, 0, 0], voxels: [] }]],
    [
      'boxes of the next leaf',
      {
        entriesPerLeaf: 3,
        changeLeaves: ([a, b]) => [a!, { ...b!, first: [0, 0, 0, 0] }],
        changeEntries: reversed,
      },
    ],
  ];
  for (const [name, options, boxes] of cases) {
    const host = archiveHost(options, boxes);
    const found = await columnsOf(host).catch((error: unknown) => error);
    const errors = found instanceof Map ? [...found.values()] : [found];
    const failed = errors.filter((error) => error instanceof Error);
    assert.ok(failed.length > 0, name);
    for (const error of failed) assert.ok(error instanceof DataError, `${name}: ${String(error)}`);
  }
  const large = archiveHost({ header: { rootBytes: 8 + 40 * 900_000, fileBytes: 1e9 } });
  assert.equal(await kindOfAsync(large.open()), 'too-large');
});

test('facts that no world has are refused', async () => {
  const bounds = (min: number[], max: number[]) => ({ bounds: { min, max } });
  const wide = 2 ** 26;
  const cases: [string, Record<string, unknown>, DataErrorKind | 'none'][] = [
    ['sound', {}, 'none'],
    ['no bounds', { bounds: undefined }, 'damaged'],
    ['another version', { version: 1 }, 'damaged'],
    ['other boxes', { box: [64, 64, 64] }, 'damaged'],
    ['a title that is none', { title: 7 }, 'damaged'],
    ['bounds upside down', bounds([0, 0, 0], [1, -1, 1]), 'damaged'],
    ['bounds of halves', bounds([0, 0, 0], [1.5, 1, 1]), 'damaged'],
    ['bounds beyond 2^30', bounds([-(2 ** 30) - 1, 0, 0], [1, 1, 1]), 'damaged'],
    ['voxels of nothing', { voxel_m: 0 }, 'damaged'],
    ['voxels of 1001 m', { voxel_m: 1001 }, 'damaged'],
    ['no levels', { levels: 0 }, 'damaged'],
    ['half levels', { levels: 3.5 }, 'damaged'],
    ['22 levels', { levels: 22 }, 'damaged'],
    ['fewer levels than the bounds need', { levels: 2 }, 'damaged'],
    ['a frame that is none', { framed: 5 }, 'damaged'],
    ['millions of coarse boxes', { ...bounds([-wide, 0, -wide], [wide, 9, wide]) }, 'damaged'],
    [
      'too far from the origin',
      { ...bounds([2 ** 27, 0, 0], [2 ** 27 + 64, 9, 9]), levels: 1 },
      'damaged',
    ],
    [
      'a tower of 8192 boxes',
      { ...bounds([0, 0, 0], [64, 256 * 8192, 64]), levels: 1 },
      'too-large',
    ],
    ['as wide as it can be', { ...bounds([-wide, 0, -wide], [wide, 9, wide]), levels: 20 }, 'none'],
    ['nothing at all', { ...bounds([0, 0, 0], [0, 0, 0]), levels: 1 }, 'none'],
  ];
  for (const [name, facts, kind] of cases) {
    const found = await kindOfAsync(archiveHost({ facts }, []).open());
    assert.equal(found, kind, name);
  }
  const deep = JSON.stringify(kFacts).replace('[64,256,64]', '['.repeat(1e6) + ']'.repeat(1e6));
  const facts = new TextEncoder().encode(deep);
  assert.equal(
    kindOf(() => readFacts(facts, 'x')),
    'damaged',
  );
  const text = Buffer.from(makeArchive([])).toString('latin1');
  for (const bad of ['\xff', '{'.repeat(90), '['.repeat(90)]) {
    const bytes = new Uint8Array(
      Buffer.from(text.slice(0, 64) + bad + text.slice(64 + bad.length), 'latin1'),
    );
    assert.equal(await kindOfAsync(hostOf(bytes).open()), 'damaged');
  }
});

test('a frame that is no box, or a bomb, fails its column alone', async () => {
  const key: Key = [0, 1, 0, 0];
  const other = boxBytes([0, 1, 0, 1], kVoxels);
  const huge = Array.from({ length: 100 }, () => zstdBlock('rle', 131_072, bytesOf(1)));
  const cases: [string, Uint8Array][] = [
    ['no frame', bytesOf(1, 2, 3)],
    ['nothing', new Uint8Array(0)],
    ['another box', zstdFrame(other)],
    ['no box', zstdFrame(skewed(500))],
    ['more than any box', zstdFrameOf(13_107_200, huge)],
    ['a damaged box', zstdFrame(boxBytes(key, kVoxels).fill(1, 70, 71))],
  ];
  for (const [name, frame] of cases) {
    const found = await columnsOf(archiveHost({}, [...kBoxes, { key, frame }]));
    const failed = [...found].filter(([, column]) => column instanceof DataError);
    assert.deepEqual(
      failed.map(([place]) => place),
      ['0/1/0'],
      name,
    );
    assert.match(String(failed[0]![1]), /http:\/\/host\/a, box 0\/1\/0\/0: /, name);
  }
});

test('a column of more memory than a page should hold is refused', async () => {
  // The largest box: every voxel has an attribute. Its frame is small.
  const content = makeBox([{ x: 0, y: 0, z: 0, material: 1 }]);
  const cells = 4 + 256 + 16_384;
  const box = Buffer.alloc(64 + 24 * cells + 8 * (1 << 20));
  box.set(content.subarray(0, 64));
  box.writeUInt32LE(cells, 28);
  box.writeUInt32LE(1 << 20, 32);
  for (let i = 0; i < cells; ++i) {
    box.fill(255, 64 + 24 * i, 64 + 24 * i + 16);
    const first = i < 260 ? 4 + 64 * i : 64 * (i - 260);
    box.writeUInt32LE(first, 64 + 24 * i + 16);
  }
  const seal = (key: Key): Uint8Array => {
    key.forEach((number, i) => box.writeInt32LE(number, 12 + 4 * i));
    const seed = xxh64(box.subarray(0, 56));
    box.writeBigUInt64LE(big(xxh64(box.subarray(64), seed)), 56);
    return zstdFrame(box);
  };
  const tall = { bounds: { min: [-128, 0, -128], max: [128, 256 * 20, 128] } };
  const boxes = Array.from({ length: 14 }, (_, by) => {
    const key: Key = [0, 0, by, 0];
    return { key, frame: seal(key) };
  });
  const column = { level: 0, bx: 0, bz: 0 };
  const found = await columnsOf(archiveHost({ facts: tall }, boxes), [column]);
  assert.equal((found.get('0/0/0') as DataError).kind, 'too-large');
  const few = await columnsOf(archiveHost({ facts: tall }, boxes.slice(0, 3)), [column]);
  assert.equal((few.get('0/0/0') as Column).boxes.length, 3);
});

test('200 files with random bytes give errors or columns', async () => {
  const random = randomOf(11);
  const whole = makeArchive(kBoxes, { entriesPerLeaf: 2 });
  for (let i = 0; i < 200; ++i) {
    const bytes =
      i % 4 === 0 ? Uint8Array.from({ length: random(3000) }, () => random(256)) : whole.slice();
    if (i % 4 !== 0) {
      const from = random(bytes.length);
      const end = Math.min(bytes.length, from + 1 + random(40));
      for (let at = from; at < end; ++at) bytes[at] = random(256);
    }
    const found = await columnsOf(hostOf(bytes)).catch((error: unknown) => error);
    assert.ok(found instanceof Map || found instanceof DataError, `file ${i}: ${String(found)}`);
  }
});

/* Scheduling. */

const at = (bx: number, level = 0): ColumnKey => ({ level, bx, bz: 0 });
const columnAt = (key: ColumnKey): Column => ({ ...key, byBegin: 0, boxes: [] });
type Job = {
  readonly names: string[];
  readonly signal: AbortSignal;
  readonly give: (result: Column | { failed: ColumnKey; error: DataError }) => void;
  readonly end: (error?: unknown) => void;
};

/** A source whose requests end when the test says so. Columns with bx / 10 in common are near. */
class FakeSource implements BoxSource {
  readonly facts = { world: {} as BoxSource['facts']['world'], damage: 0 };
  readonly jobs: Job[] = [];
  isNear = (a: ColumnKey, b: ColumnKey): boolean => Math.floor(a.bx / 10) === Math.floor(b.bx / 10);

  async prepare(): Promise<void> {}

  companions(column: ColumnKey, candidates: readonly ColumnKey[]): ColumnKey[] {
    return candidates.filter((candidate) => this.isNear(column, candidate));
  }

  async *columns(
    columns: readonly ColumnKey[],
    signal: AbortSignal,
  ): ReturnType<BoxSource['columns']> {
    const results: ({ column: Column } | { failed: ColumnKey; error: DataError })[] = [];
    let isOver = false;
    let failure: unknown;
    let wake = (): void => undefined;
    const stop = (error: unknown): void => {
      [isOver, failure] = [true, error];
      wake();
    };
    signal.addEventListener('abort', () => stop(signal.reason));
    this.jobs.push({
      names: columns.map(nameOf),
      signal,
      end: (error) => stop(error),
      give: (result) => {
        results.push('failed' in result ? result : { column: result });
        wake();
      },
    });
    for (;;) {
      const next = results.shift();
      if (next !== undefined) yield next;
      else if (isOver && failure !== undefined) throw failure;
      else if (isOver) return;
      else await new Promise<void>((resolve) => (wake = resolve));
    }
  }
}

const whenReady = (): Promise<void> => Promise.resolve();

function scheduling(options?: { maxRequests?: number }) {
  const source = new FakeSource();
  const got: string[] = [];
  const failed: string[] = [];
  const ended: string[] = [];
  const scheduler = new Scheduler(
    source,
    {
      whenReady,
      onColumn: (column) => void got.push(nameOf(column)),
      onFailed: (column, error) => failed.push(`${nameOf(column)} ${error.kind}`),
      onEnded: (error) => ended.push(error.kind),
    },
    options,
  );
  const turn = () => new Promise((resolve) => setImmediate(resolve));
  const names = (): string[][] => source.jobs.map((job) => job.names);
  return { source, scheduler, got, failed, ended, turn, names };
}

test('the most wanted come first, six requests at a time, each with its neighbours', async () => {
  const { source, scheduler, turn, names, got } = scheduling();
  scheduler.want([at(80), at(10), at(20), at(11), at(30), at(40), at(50), at(60), at(12), at(81)]);
  await turn();
  assert.deepEqual(
    names().map(([first]) => first),
    ['0/80/0', '0/10/0', '0/20/0', '0/11/0', '0/30/0', '0/40/0'],
  );
  assert.deepEqual(names().slice(0, 2), [
    ['0/80/0', '0/81/0'],
    ['0/10/0', '0/12/0'],
  ]);
  source.jobs[1]!.give(columnAt(at(12)));
  source.jobs[1]!.give(columnAt(at(10)));
  await turn();
  assert.deepEqual(got, ['0/12/0', '0/10/0']);
  assert.equal(names().length, 6);
  source.jobs[1]!.end();
  await turn();
  assert.deepEqual(names()[6], ['0/50/0']);
  assert.deepEqual(scheduler.stats, { waiting: 8, requests: 6 });
});

test('a new list cancels what it does not name, and requests nothing twice', async () => {
  const { source, scheduler, turn, names, got } = scheduling({ maxRequests: 3 });
  scheduler.want([at(10), at(11), at(20), at(30), at(40)]);
  await turn();
  assert.deepEqual(names(), [['0/10/0'], ['0/11/0'], ['0/20/0']]);
  scheduler.want([at(50), at(20), at(11), at(12), at(20)]);
  await turn();
  assert.deepEqual(
    source.jobs.map(({ signal }) => signal.aborted),
    [true, false, false, false],
  );
  assert.deepEqual(names().slice(3), [['0/50/0']]);
  source.jobs[1]!.give(columnAt(at(11)));
  source.jobs[1]!.end();
  source.jobs[2]!.give(columnAt(at(20)));
  source.jobs[2]!.end();
  await turn();
  assert.deepEqual(got, ['0/11/0', '0/20/0']);
  assert.deepEqual(names().slice(4), [['0/12/0']]);
  // What a request brings along and nothing wants any more is not sent.
  scheduler.want([at(10), at(12), at(13)]);
  await turn();
  scheduler.want([at(12)]);
  source.jobs[4]!.give(columnAt(at(12)));
  await turn();
  assert.deepEqual(got, ['0/11/0', '0/20/0', '0/12/0']);
  scheduler.want([]);
  assert.ok(source.jobs.every(({ signal }, i) => signal.aborted || [1, 2].includes(i)));
  assert.deepEqual(scheduler.stats, { waiting: 0, requests: 0 });
});

test('a failing column ends no other, a failing request its own, a change all', async () => {
  const { source, scheduler, turn, failed, got, ended, names } = scheduling({ maxRequests: 1 });
  scheduler.want([at(10), at(11), at(12), at(20), at(30)]);
  await turn();
  source.jobs[0]!.give({ failed: at(11), error: new DataError('damaged', 'x') });
  source.jobs[0]!.give(columnAt(at(12)));
  source.jobs[0]!.end(new DataError('server', 'x'));
  await turn();
  assert.deepEqual(failed, ['0/11/0 damaged', '0/10/0 server']);
  assert.deepEqual(got, ['0/12/0']);
  assert.deepEqual(names()[1], ['0/20/0']);
  // A source that forgets a column, or has a bug, is no endless loop.
  source.jobs[1]!.end();
  await turn();
  assert.deepEqual(failed[2], '0/20/0 damaged');
  source.jobs[2]!.end(new DataError('changed', 'x'));
  await turn();
  assert.deepEqual(ended, ['changed']);
  scheduler.want([at(70)]);
  await turn();
  assert.equal(names().length, 3);
});

test('neighbours in an archive share a request, and distant ones have their own', async () => {
  const facts = { bounds: { min: [0, 0, 0], max: [64 * 64, 256, 64] }, levels: 7 };
  const boxes = Array.from({ length: 64 }, (_, bx) => {
    const key: Key = [0, bx, 0, 0];
    return { key, voxels: [{ x: bx, y: 0, z: 0, material: 4 }] };
  });
  const requestsFor = async (gapBytes: number, wanted: ColumnKey[]): Promise<number> => {
    const host = archiveHost({ facts, gapBytes }, boxes);
    const source = new ArchiveSource(await host.open(), host.clock);
    await host.clock.finish(source.prepare(wanted[0]!, kOpen));
    const before = host.asked.length;
    let missing = new Set(wanted).size;
    await host.clock.finish(
      new Promise<void>((resolve, reject) => {
        const onColumn = (): void => {
          missing -= 1;
          if (missing === 0) resolve();
        };
        const events = { whenReady, onColumn, onFailed: reject, onEnded: reject };
        new Scheduler(source, events, { maxRequests: 1 }).want(wanted);
      }),
    );
    return host.asked.length - before;
  };
  const all = boxes.map(({ key }) => at(key[1]));
  const air = at(5, 3);
  assert.equal(await requestsFor(0, [...all, air]), 1);
  // About 21 KiB a box: 1 MiB has 50 of them.
  assert.equal(await requestsFor(20_000, all), 2);
  assert.equal(await requestsFor(20_000, [all[30]!, ...all]), 2);
  assert.equal(await requestsFor(20_000, [all[0]!, all[1]!, all[10]!, all[11]!]), 2);
  assert.equal(await requestsFor(40_000, all.slice(0, 9)), 9);
});

test('callers share the request of a leaf, and one caller less does not end it', async () => {
  const host = archiveHost({ gapBytes: 20_000, entriesPerLeaf: 3 });
  const archive = await host.open();
  const before = host.asked.length;
  const first = new AbortController();
  const places = [at(0, 1), at(0, 2), at(0, 1)];
  const waits = places.map((place, i) => archive.column(place, i === 0 ? first.signal : kOpen));
  first.abort(new Error('not any more'));
  await assert.rejects(waits[0]!, /not any more/);
  const [, one, two] = await host.clock.finish(Promise.allSettled(waits));
  assert.ok(one!.status === 'fulfilled' && one!.value.length === 1);
  assert.ok(two!.status === 'fulfilled' && two!.value.length === 1);
  assert.equal(host.asked.length, before + 1);
});

/* Voxel servers. */

type BatchOptions = { readonly statusOf?: (key: Key) => number; readonly cutAfter?: number };

function record(key: Key, code: number, payload: Uint8Array): Buffer {
  const head = Buffer.alloc(24);
  key.forEach((number, i) => head.writeInt32LE(number, 4 * i));
  head.writeUInt32LE(code, 16);
  head.writeUInt32LE(payload.length, 20);
  return Buffer.concat([head, payload]);
}

/** Answers as a voxel server with the boxes of the archive. */
function serverHost(options: BatchOptions = {}): FakeHost {
  const host = new FakeHost();
  const byName = new Map(kBoxes.map((box) => [box.key.join(), box]));
  const recordOf = (key: Key): Buffer => {
    const box = byName.get(key.join());
    const code = options.statusOf?.(key) ?? (box?.hole ? 500 : box === undefined ? 204 : 200);
    if (code === 204) return record(key, code, new Uint8Array(0));
    if (code !== 200) return record(key, code, Buffer.from(`no ${code}`));
    return record(key, code, zstdFrame(boxBytes(key, box?.voxels ?? [])));
  };
  host.handler = (url, init) => {
    if (url.endsWith('/v2/world'))
      return new Response(JSON.stringify(kFacts), { headers: { 'Terravox-Edition': 'e1' } });
    const { boxes } = JSON.parse(String(init.body)) as { boxes: Key[] };
    const records = boxes.map(recordOf);
    const last = record([-1, boxes.length, 0, 0], 0, new Uint8Array(0));
    const whole = Buffer.concat([...records, last]);
    const bytes = whole.subarray(0, options.cutAfter ?? whole.length);
    // In small chunks, so that records lie across them.
    let sent = 0;
    const body = new ReadableStream<Uint8Array>({
      pull(controller) {
        controller.enqueue(new Uint8Array(bytes.subarray(sent, sent + 50)));
        sent += 50;
        if (sent >= bytes.length) controller.close();
      },
    });
    return new Response(body);
  };
  return host;
}

const openServer = (host: FakeHost, token?: string): Promise<ServerSource> => {
  const place = { url: 'http://host/path', ...(token === undefined ? {} : { token }) };
  return host.clock.finish(ServerSource.open(host.http, place, kOpen));
};

test('columns of a voxel server are those of an archive of it', async () => {
  const expected = await columnsOf(archiveHost());
  const host = serverHost();
  const source = await openServer(host, 'secret');
  assert.equal(source.facts.world.title, 'small');
  const found = await collect(host, source, [...kColumns, { level: 0, bx: 99, bz: 0 }]);
  const hole = found.get('0/1/1') as Column;
  assert.deepEqual(hole.boxes, [{ hole: 'no 500' }]);
  expected.set('0/1/1', hole);
  expected.set('0/99/0', { level: 0, bx: 99, bz: 0, byBegin: 0, boxes: [] });
  assert.deepEqual(found, expected);
  assert.deepEqual(
    host.asked.map(({ url }) => url),
    ['http://host/path/v2/world', 'http://host/path/v2/boxes'],
  );
  assert.deepEqual(host.asked[1]!.init.headers, {
    Authorization: 'Bearer secret',
    'Content-Type': 'application/json',
    'Terravox-Edition': 'e1',
  });
  // Two boxes a column, 32 boxes a batch.
  const candidates = Array.from({ length: 40 }, (_, bx) => at(bx));
  assert.equal(source.companions(at(50), candidates).length, 15);
});

test('a batch that is cut short is requested again for what is missing', async () => {
  const host = serverHost();
  const source = await openServer(host);
  const cut = serverHost({ cutAfter: 200 }).handler;
  host.next.push(cut, status(503));
  const found = await collect(host, source, kColumns);
  assert.ok([...found.values()].every((column) => !(column instanceof DataError)));
  const counts = host.asked.slice(1).map(({ init }) => {
    return (JSON.parse(String(init.body)) as { boxes: unknown[] }).boxes.length;
  });
  assert.ok(counts[0]! > counts[1]! && counts[1] === counts[2]);
  host.next.push(cut, cut, cut);
  const failed = await collect(host, source, [at(1), at(0), at(-1)]);
  assert.ok([...failed.values()].some((c) => c instanceof DataError && c.kind === 'cut'));
});

test('a box that a busy server leaves out fails its column, and a change ends all', async () => {
  const host = serverHost({ statusOf: ([, bx]) => (bx === 0 ? 503 : 204) });
  const source = await openServer(host);
  const found = await collect(host, source, [at(0), at(1)]);
  assert.equal((found.get('0/0/0') as DataError).kind, 'server');
  assert.deepEqual((found.get('0/1/0') as Column).boxes, []);
  const other = { headers: { 'Terravox-Edition': 'e2' } };
  for (const handler of [status(412), () => new Response('', other)]) {
    host.next.push(handler);
    assert.equal(await kindOfAsync(collect(host, source, [at(0)])), 'changed');
  }
});

test('replies to a batch that are none are refused', async () => {
  const last = record([-1, 2, 0, 0], 0, new Uint8Array(0));
  const air = (by: number): Buffer => record([0, 0, by, 0], 204, new Uint8Array(0));
  const cases: [string, Uint8Array, DataErrorKind][] = [
    ['nothing', new Uint8Array(0), 'cut'],
    ['a last record of other boxes', record([-1, 3, 0, 0], 0, new Uint8Array(0)), 'damaged'],
    ['a last record too early', Buffer.concat([air(0), last]), 'damaged'],
    ['more boxes', Buffer.concat([air(5), air(6), air(7)]), 'damaged'],
    ['a record of 4 GiB', record([0, 0, 0, 0], 200, bytesOf(1)).fill(255, 20, 24), 'damaged'],
    ['a long reason', record([0, 0, 0, 0], 500, new Uint8Array(70_000)), 'damaged'],
    ['another status', Buffer.concat([record([0, 0, 0, 0], 404, new Uint8Array(0))]), 'damaged'],
    ['no box', record([0, 0, 0, 0], 200, bytesOf(1, 2, 3)), 'damaged'],
  ];
  for (const [name, bytes, kind] of cases) {
    const host = serverHost();
    const source = await openServer(host);
    const reply: Handler = () => new Response(bytes.slice());
    host.next.push(reply, reply, reply);
    const found = await collect(host, source, [at(0)]);
    assert.equal((found.get('0/0/0') as DataError).kind, kind, name);
  }
});

/* The worker. */

function sessionOf(host: FakeHost): { session: Session; sent: FromWorker[]; transfers: number[] } {
  const sent: FromWorker[] = [];
  const transfers: number[] = [];
  const post = (message: FromWorker, transfer: ArrayBuffer[]): void => {
    sent.push(structuredClone(message, { transfer }));
    transfers.push(transfer.length);
  };
  return { session: new Session(post, host.environment, 'http://host/'), sent, transfers };
}

const untilSent = (host: FakeHost, sent: readonly FromWorker[], count: number): Promise<void> =>
  host.clock.finish(
    (async () => {
      while (sent.length < count) await new Promise((resolve) => setImmediate(resolve));
    })(),
  );

test('a session opens a world and sends what is wanted, whatever comes first', async () => {
  const host = archiveHost();
  const { session, sent, transfers } = sessionOf(host);
  session.handle({ type: 'want', generation: 4, columns: [at(0), at(0, 3), at(1)] });
  session.handle({ type: 'open', place: { url: 'a' } });
  session.handle({ type: 'open', place: { url: 'b' } });
  await untilSent(host, sent, 4);
  assert.equal(sent[0]!.type, 'opened');
  const column = sent.find((message) => message.type === 'column' && message.column.bx === 0)!;
  assert.ok(column.type === 'column' && column.generation === 4 && column.bytes > 0);
  assert.ok(transfers.includes(8));
  const failed = sent.find(({ type }) => type === 'failed');
  assert.ok(failed?.type === 'failed' && failed.failure.kind === 'missing');
  session.handle({ type: 'stats' });
  const stats = sent.at(-1)!;
  assert.ok(stats.type === 'stats' && stats.stats.columns === 2 && stats.stats.waiting === 0);
  assert.equal(stats.type === 'stats' && stats.stats.requests, host.asked.length);
});

test('a session says why a world cannot be opened', async () => {
  const open = async (place: Parameters<Session['handle']>[0] & { type: 'open' }) => {
    const host = archiveHost();
    const { session, sent } = sessionOf(host);
    session.handle(place);
    await untilSent(host, sent, 1);
    const [message] = sent;
    return message?.type === 'ended' ? message.failure.kind : message?.type;
  };
  assert.equal(await open({ type: 'open', place: { url: 'b' } }), 'missing');
  assert.equal(await open({ type: 'open', place: { url: 'file:///a' } }), 'missing');
  assert.equal(await open({ type: 'open', place: { server: 'http://[' } }), 'missing');
  assert.equal(await open({ type: 'open', place: { parts: [] } }), 'damaged');
  const bytes = makeArchive(kBoxes).length;
  assert.equal(await open({ type: 'open', place: { parts: [{ url: 'a', bytes }] } }), 'opened');
});

test('a session pauses while the page has not taken what was sent', async () => {
  const host = serverHost();
  const { session, sent } = sessionOf(host);
  session.handle({ type: 'open', place: { server: 'http://host/' } });
  await untilSent(host, sent, 1);
  // As if so much had been sent before.
  session.handle({ type: 'taken', bytes: -(2 ** 30) });
  session.handle({ type: 'want', generation: 1, columns: [at(0), at(1), at(-1)] });
  for (let i = 0; i < 50; ++i) await new Promise((resolve) => setImmediate(resolve));
  assert.equal(sent.length, 1);
  session.handle({ type: 'taken', bytes: 2 ** 30 });
  await untilSent(host, sent, 4);
  session.stop();
});
