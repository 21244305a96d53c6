import { readFileSync } from 'node:fs';
import { createServer, type IncomingMessage, type Server, type ServerResponse } from 'node:http';
import type { AddressInfo } from 'node:net';
import { join } from 'node:path';
import {
  boxFrame,
  kLevels,
  kMax,
  kMin,
  squaresJson,
  tilePng,
  worldJson,
  type SquareRow,
} from './fake-world.js';
import { kNoData, makeRaster } from './make-raster.js';

declare const TERRAVOX_PAGE_DIST: string;

const kTypes: Readonly<Record<string, string>> = {
  'index.html': 'text/html; charset=utf-8',
  'app.js': 'text/javascript; charset=utf-8',
  'app.css': 'text/css; charset=utf-8',
  'licences.txt': 'text/plain; charset=utf-8',
};

/** A voxel server in small: the routes that the page uses, and switches for what may go wrong. */
export class FakeServer {
  token = '';
  /** Where a proxy would put it. */
  prefix = '/';
  title = 'Synthetic hills';
  busy = false;
  squares: SquareRow[] = [
    { name: 'TM_462_101', state: 'prepared' },
    { name: 'TM_463_101', state: 'fetched' },
    { name: 'TM_462_100', state: 'wanted' },
    {
      name: 'TM_463_100',
      state: 'failed',
      error: 'read TM_463_100.laz: the file ends in the header',
    },
  ];
  stepName = 'point load';
  /** Whether it makes analyses, and how the next one goes. */
  hasJobs = true;
  /** Whether its world has a latitude and a longitude. */
  isOnEarth = true;
  jobFails = '';
  /** The data of jobs have holes. */
  jobHoles = false;
  /** The rasters of jobs cannot be read. */
  rasterFails = false;
  /** Looks at a job until it is done. */
  jobLooks = 3;
  readonly jobs = new Map<string, { readonly body: Record<string, unknown>; looks: number }>();
  /** Boxes made so far: tiles of the coarse zooms are whole once it is above 10. */
  made = 3;
  readonly requestPaths: string[] = [];
  #requests = 0;
  #started = Date.now();
  #server: Server | undefined;
  #closed = false;
  #port = 0;

  get url(): string {
    return `http://127.0.0.1:${this.#port}${this.prefix}`;
  }

  async open(): Promise<this> {
    this.#started = Date.now();
    this.#closed = false;
    if (this.#server !== undefined) {
      this.#server.ref();
      return this;
    }
    const server = createServer((request, reply) => this.#answer(request, reply));
    this.#server = server;
    server.on('connection', (socket) => {
      if (this.#closed) socket.destroy();
    });
    await new Promise<void>((resolve) => server.listen(this.#port, '127.0.0.1', resolve));
    this.#port = (server.address() as AddressInfo).port;
    return this;
  }

  /**
   * Answers no request from now on. The port stays reserved, so that no other program takes it
   * before the server opens again.
   */
  close(): void {
    this.#closed = true;
    this.#server?.closeAllConnections();
    this.#server?.unref();
  }

  #answer(request: IncomingMessage, reply: ServerResponse): void {
    this.requestPaths.push(request.url ?? '');
    if (request.url?.startsWith(this.prefix) !== true) {
      return problem(reply, 404, 'not below the prefix');
    }
    const path = request.url.slice(this.prefix.length);
    ++this.#requests;
    const below = path.startsWith('page/') ? path.slice(5) : undefined;
    const asset = path === '' ? 'index.html' : below;
    if (asset !== undefined && asset in kTypes) {
      const scripts =
        "default-src 'none'; script-src 'self'; style-src 'self'; " +
        "connect-src 'self'; img-src 'self' blob: data:; ";
      reply.setHeader(
        'Content-Security-Policy',
        `${scripts}frame-ancestors 'none'; base-uri 'none'; form-action 'none'`,
      );
      return void reply
        .setHeader('Content-Type', kTypes[asset]!)
        .end(readFileSync(join(TERRAVOX_PAGE_DIST, asset)));
    }
    if (this.token !== '' && request.headers.authorization !== `Bearer ${this.token}`) {
      reply.setHeader('WWW-Authenticate', 'Bearer');
      return problem(reply, 401, 'no or another token');
    }
    if (this.busy) return problem(reply, 503, 'many boxes are being made');
    if (path.startsWith('v2/jobs')) return this.#job(request, reply, path.split('/'));
    const tile = /^map\/(\d+)\/(-?\d+)\/(-?\d+)\.png$/.exec(path);
    if (tile) return this.#tile(reply, Number(tile[1]), Number(tile[2]), Number(tile[3]));
    const box = /^v2\/boxes\/0\/(-?\d+)\/(-?\d+)\/(-?\d+)$/.exec(path);
    if (box) return sendBox(reply, boxFrame(Number(box[1]), Number(box[2]), Number(box[3])));
    const cached = /^v2\/cached\/(\d+)$/.exec(path);
    const json = cached ? this.#cached(Number(cached[1])) : this.#json(path);
    if (json === undefined) return problem(reply, 404, `nothing at ${path}`);
    reply
      .setHeader('Content-Type', 'application/json')
      .setHeader('Cache-Control', 'no-store')
      .end(JSON.stringify(json));
  }

  #job(request: IncomingMessage, reply: ServerResponse, [, , id, file]: readonly string[]): void {
    const send = (status: number, json: unknown): void => {
      reply.statusCode = status;
      reply.setHeader('Content-Type', 'application/json').end(JSON.stringify(json));
    };
    if (!this.hasJobs) return problem(reply, 404, 'this server makes no analyses');
    if (id === undefined) {
      const parts: Buffer[] = [];
      request.on('data', (part: Buffer) => parts.push(part));
      return void request.on('end', () => {
        const made = String(this.jobs.size).padStart(32, '0');
        this.jobs.set(made, {
          body: JSON.parse(Buffer.concat(parts).toString()) as Record<string, unknown>,
          looks: 0,
        });
        send(201, { id: made, kind: 'sun', state: 'waiting', progress: 0, before: 1 });
      });
    }
    const job = this.jobs.get(id);
    if (job === undefined) return problem(reply, 404, 'no such job');
    if (request.method === 'DELETE') {
      this.jobs.delete(id);
      return void reply.writeHead(204).end();
    }
    if (file !== undefined && this.rasterFails) return problem(reply, 500, 'no such disk');
    if (file !== undefined) {
      return sendRange(request, reply, jobRaster(job.body['area'] as number[]));
    }
    job.looks += 1;
    const isOver = job.looks >= this.jobLooks;
    const end = this.jobFails === '' ? 'done' : 'failed';
    const state = isOver ? end : 'running';
    send(200, {
      id,
      kind: 'sun',
      state,
      progress: Math.min(1, job.looks / this.jobLooks),
      message: this.jobFails,
      holes: this.jobHoles,
    });
  }

  #tile(reply: ServerResponse, zoom: number, x: number, y: number): void {
    if (zoom >= kLevels) return problem(reply, 404, `zoom ${zoom}`);
    const whole = zoom >= kLevels - 3 || this.made > 10;
    if (!whole) reply.setHeader('Terravox-Complete', 'no').setHeader('Cache-Control', 'no-store');
    reply.setHeader('Content-Type', 'image/png').end(tilePng(zoom, x, y, whole));
  }

  #cached(level: number): unknown {
    const side = 64 * 2 ** level;
    const keys = (from: number, to: number): number[][] => {
      const out: number[][] = [];
      for (let bz = Math.floor(kMin[2] / side); bz < kMax[2] / side; ++bz) {
        for (let bx = Math.floor(kMin[0] / side); bx < kMax[0] / side; ++bx) {
          const turn = (((bx + 2 * bz) % 5) + 5) % 5;
          if (turn >= from && turn < to) out.push([bx, 1, bz]);
        }
      }
      return out;
    };
    return { level, changes: this.made, memory: keys(0, 2), disk: keys(1, 4), truncated: false };
  }

  #json(path: string): unknown {
    if (path === 'v2/world') {
      return this.isOnEarth
        ? worldJson(this.title)
        : { ...(worldJson(this.title) as object), centre: undefined };
    }
    if (path === 'v2/squares') return squaresJson(this.squares);
    if (/^v2\/columns\/0\//.test(path)) {
      return { by_begin: 0, by_end: 3, min_y: kMin[1], max_y: kMax[1] };
    }
    if (path === 'v2/stats') return this.#stats();
    return undefined;
  }

  #stats(): unknown {
    const cache = {
      hits: 812,
      misses: 64,
      waits: 2,
      evictions: 1,
      bytes: 48_123_456,
      entries: 64,
      limit_bytes: 2 ** 30,
    };
    const steps = [
      [this.stepName, 2.31, 4],
      ['k-d trees (all)', 0.42, 4],
      ['building fill', 0.0634, 12],
      ['ground fill', 0.183, 12],
      ['serialization', 0.000912, 24],
    ] as const;
    return {
      version: '0.1.0',
      uptime_s: (Date.now() - this.#started) / 1000,
      stages: steps.map(([name, seconds, count]) => ({ name, seconds, count })),
      requests: { boxes: { 200: this.#requests, 503: 2 }, map: { 200: 31 } },
      replies: { count: this.#requests, bytes: 9_876_543 },
      cache,
      disk: { ...cache, writes: 12, limit_bytes: 20 * 2 ** 30 },
      making: {
        running: 2,
        waiting: 5,
        ahead_waiting: 17,
        made: this.made,
        made_ahead: 4,
        failed: 1,
      },
      jobs: this.hasJobs
        ? { analyses: kAnalyses, max_cells: 4_000_000, max_minutes: 30, waiting: 0, running: 0 }
        : null,
      memory: { rss_bytes: 512 * 2 ** 20, limit_bytes: 4 * 2 ** 30 },
      prepare: { done: 1, total: 4, failed: 1 },
    };
  }
}

function sendBox(reply: ServerResponse, box: Uint8Array | undefined): void {
  reply.statusCode = box === undefined ? 204 : 200;
  if (box !== undefined) reply.setHeader('Content-Type', 'application/vnd.terravox.box');
  reply.end(box);
}

const kAnalyses = [
  ['terrain', 'Terrain: heights, slopes', []],
  ['sky', 'How much sky is seen', ['surface']],
  ['sun', 'Hours of sun', ['surface', 'days']],
  ['sight', 'Seen from a place', ['surface', 'observers']],
  ['clearance', 'Free height', []],
].map(([kind, title, members]) => ({
  kind,
  title,
  ...Object.fromEntries((members as string[]).map((member) => [member, true])),
}));

/** Hours of sun that grow to the east, with a gap. */
function jobRaster([west, , east, north]: readonly number[]): Buffer {
  const side = 40;
  const values = Array.from({ length: side * side }, (_, i) =>
    i % side < 4 ? kNoData : (i % side) / 4,
  );
  const bands = [
    {
      name: 'sun_hours',
      unit: 'h',
      about: { title: 'Hours of direct sun', ramp: 'warm', low: '0' },
      values,
    },
    {
      name: 'first_sun',
      unit: 'h',
      about: { title: 'First sun, clock time', ramp: 'much', form: 'clock' },
      values: values.map(() => 5),
    },
    {
      name: 'hole',
      unit: '',
      about: {
        title: 'Data that could not be read',
        ramp: 'much',
        low: '0',
        high: '1',
        words: 'read|could not be read',
      },
      values: values.map(() => 0),
    },
  ];
  return makeRaster({
    width: side,
    height: side,
    tile: 16,
    bands,
    west: west!,
    north: north!,
    cell: (east! - west!) / side,
  });
}

function sendRange(request: IncomingMessage, reply: ServerResponse, file: Buffer): void {
  const [, from, to] = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? '') ?? [];
  reply.setHeader('Content-Type', 'image/tiff');
  if (from === undefined) return void reply.end(file);
  reply.writeHead(206).end(file.subarray(Number(from), Number(to) + 1));
}

function problem(reply: ServerResponse, status: number, detail: string): void {
  reply.statusCode = status;
  reply
    .setHeader('Content-Type', 'application/problem+json')
    .end(JSON.stringify({ title: 'Trouble', status, detail }));
}
