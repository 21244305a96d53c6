import { FakeHost } from './fake-host.js';
import { boxBytes, kFacts, zstdFrame, type Key } from './make-archive.js';
import { kBoxes } from './small-archive.js';

export type BatchOptions = {
  readonly chooseStatus?: (key: Key) => number;
  readonly cutAfter?: number;
};

export function record(key: Key, code: number, payload: Uint8Array): Buffer {
  const head = Buffer.alloc(24);
  key.forEach((number, i) => head.writeInt32LE(number, 4 * i));
  head.writeUInt32LE(code, 16);
  head.writeUInt32LE(payload.length, 20);
  return Buffer.concat([head, payload]);
}

/** Answers as a voxel server with the boxes of the archive. */
export function serverHost(options: BatchOptions = {}): FakeHost {
  const host = new FakeHost();
  const byName = new Map(kBoxes.map((box) => [box.key.join(), box]));
  const makeRecord = (key: Key): Buffer => {
    const box = byName.get(key.join());
    const usual = box === undefined ? 204 : 200;
    const code = options.chooseStatus?.(key) ?? (box?.hole ? 500 : usual);
    if (code === 204) return record(key, code, new Uint8Array(0));
    if (code !== 200) return record(key, code, Buffer.from(`no ${code}`));
    return record(key, code, zstdFrame(boxBytes(key, box?.voxels ?? [])));
  };
  host.handler = (url, init) => {
    if (url.endsWith('/v2/world')) {
      return new Response(JSON.stringify(kFacts), { headers: { 'Terravox-Edition': 'e1' } });
    }
    const { boxes } = JSON.parse(init.body as string) as { boxes: Key[] };
    const records = boxes.map(makeRecord);
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
