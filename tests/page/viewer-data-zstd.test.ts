import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { DataErrorKind } from '../../voxelserver/serve/page/src/http/errors.js';
import { unpack } from '../../voxelserver/serve/page/src/viewer/data/zstd.js';
import { catchKind } from './support/data-errors.js';
import { zstdBlock, zstdFrame, makeZstdFrame } from './support/make-archive.js';
import { toBytes, makeRandom, skewed } from './support/test-bytes.js';

const kWords = ['rock ', 'grass ', 'water ', 'roof ', 'tower of glass '];

const lines = (count: number): Uint8Array => {
  const random = makeRandom(1);
  const text = Array.from({ length: count }, () => kWords[random(65536) % 5]).join('');
  return new TextEncoder().encode(text);
};

// Nearly periodic in several ways at once, so that the third last offset is used again, too.
const records = (count: number): Uint8Array => {
  const record = (i: number): number[] => [
    i % 7,
    ((i * i) >> 3) & 3,
    0,
    0,
    i % 3,
    9,
    9,
    9,
    ((i * i) >> 5) & 1,
  ];
  return toBytes(...Array.from({ length: count }, (_, i) => record(i)).flat());
};

// Of the zstd program (1.5.4): sequences with tables that are new, then repeated, and a checksum;
// literals with a Huffman code that is new, then repeated; literals in four streams; all three
// repeated offsets.
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
  offsets: [
    'KLUv/WDQAR0EADLKDohTMhIQAKUQTYvpcGCEvqAL6YEUL4pNugyWjqCisVK' +
      '8IEmgeKoriAKMW6mGkDOjB87MFWdm35nRdWZ+P6iB',
    'SM33/wywVyodEVhJLqCMBfczIeCgQkioBEciCR3dqZDqLNlRfe614DKFOSYyFE6xYY4JPPFPnuq+gCQ+KYF3kFQB',
  ],
};

const decodeFrame = (lines: readonly string[]): Uint8Array =>
  new Uint8Array(Buffer.from(lines.join(''), 'base64'));

test('frames unpack to their content, whatever their blocks are', () => {
  const runs = new Uint8Array(300_000).fill(7, 1000, 290_000);
  for (const content of [new Uint8Array(0), toBytes(9), skewed(5000), runs]) {
    assert.deepEqual(unpack(zstdFrame(content), content.length), content);
  }
  assert.deepEqual(unpack(decodeFrame(kFrames.repeated), 4000), lines(260));
  assert.deepEqual(unpack(decodeFrame(kFrames.treeless), 4000), skewed(700));
  assert.deepEqual(unpack(decodeFrame(kFrames.streams), 4000), skewed(700));
  assert.deepEqual(unpack(decodeFrame(kFrames.offsets), 4000), records(80));
});

test('a frame must declare the size that it has, which is checked before memory is taken', () => {
  const content = skewed(100);
  const frame = zstdFrame(content);
  const raw = (size: number): Uint8Array => zstdBlock('raw', size, content.subarray(0, size));
  const magic = [0x28, 0xb5, 0x2f, 0xfd];
  const cases: [string, DataErrorKind, Uint8Array][] = [
    ['another magic number', 'damaged', frame.map((byte, i) => (i === 0 ? 0 : byte))],
    ['a size above the limit', 'too-large', makeZstdFrame(1001, [raw(100)])],
    ['4 GiB', 'too-large', makeZstdFrame(0xffffffff, [zstdBlock('rle', 100, toBytes(1))])],
    ['fewer bytes than declared', 'damaged', makeZstdFrame(101, [raw(100)])],
    ['more bytes than declared', 'damaged', makeZstdFrame(99, [raw(100)])],
    [
      'an RLE block beyond the end',
      'damaged',
      makeZstdFrame(9, [zstdBlock('rle', 10, toBytes(1))]),
    ],
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
  for (const [name, kind, bytes] of cases) {
    assert.equal(
      catchKind(() => unpack(bytes, 1000)),
      kind,
      name,
    );
  }
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
      makeZstdFrame(1000, [body('compressed', 9, 7, 255, 255, 31, 0x54, 35, 0, 52, 255)]),
    ],
    [
      'Huffman weights of states that take no bits',
      makeZstdFrame(1000, [
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
      makeZstdFrame(
        1,
        Array.from({ length: 100_000 }, () => body('raw')),
      ),
    ],
  ];
  for (const [name, frame] of bombs) {
    const start = performance.now();
    assert.equal(
      catchKind(() => unpack(frame, 1 << 20)),
      'damaged',
      name,
    );
    assert.ok(performance.now() - start < 1000, name);
  }
});

test('a changed byte of a frame gives an error or bytes of the declared size, and soon', () => {
  const random = makeRandom(7);
  for (const frame of Object.values(kFrames).map(decodeFrame)) {
    for (let at = 0; at < frame.length; ++at) {
      for (const change of [1 << random(8), 1 + random(255)]) {
        const changed = frame.map((byte, i) => (i === at ? byte ^ change : byte));
        const kind = catchKind(() => assert.ok(unpack(changed, 100_000).length <= 100_000));
        assert.ok(['none', 'damaged', 'too-large'].includes(kind));
      }
    }
  }
});
