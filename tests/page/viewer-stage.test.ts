import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createServer, type IncomingMessage, type Server, type ServerResponse } from 'node:http';
import { createRequire } from 'node:module';
import type { AddressInfo } from 'node:net';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import type { StageStats } from '../../voxelserver/serve/page/src/viewer/stage.js';
import { noBrowser, openBrowser, openPage } from './support/browser.js';
import { fullBoxFrame } from './support/full-box.js';
import { makeArchive, type Key, type TestBox } from './support/make-archive.js';

declare const TERRAVOX_ROOT: string;
declare const TERRAVOX_PAGE_DIST: string;

/** A stage in a browser: what fails for good, and pools that are too small for a view. */

const kSide = 16; // level-0 columns each way
const kLevels = 5;
const kFacts = {
  bounds: { min: [0, 0, 0], max: [64 * kSide, 256, 64 * kSide] },
  levels: kLevels,
  voxel_m: 1,
  crs_units_per_voxel: 1,
};
/** From above the middle, almost straight down; so narrow that every column has to be fine. */
const kView = { position: [512, 1200, 540], headingDeg: 0, pitchDeg: -88, fovDeg: 5 } as const;
const kMiB = 2 ** 20;
/** Of pools with one layer each: 256 rows of attributes, one of which each box takes. */
const kSmallestPools = kMiB;
const kManyPools = 64 * kMiB;

/** A floor in every column of every level. */
function floor(): TestBox[] {
  return Array.from({ length: kLevels }, (_, level) => {
    const side = kSide >> level;
    return Array.from({ length: side * side }, (_, i): TestBox => {
      const key: Key = [level, i % side, 0, Math.floor(i / side)];
      const voxels = Array.from({ length: 64 }, (_, v) => {
        return { x: (v % 8) * 8, y: 3, z: Math.floor(v / 8) * 8, material: 4 };
      });
      return { key, voxels };
    });
  }).flat();
}

/** @param gapBytes between two boxes: above 64 KiB no request for the index brings a box */
function makeArchiveBuffer(
  boxes: readonly TestBox[],
  gapBytes = 30_000,
  facts: object = kFacts,
): Buffer {
  return Buffer.from(makeArchive(boxes, { facts: { ...facts }, gapBytes }));
}

/** A page with a stage, its scripts, and an archive, some of whose ranges may fail. */
class StageHost {
  readonly archive: Buffer;
  /** Status of a request for these bytes; 0: as usual. */
  fails: (first: number, last: number) => number = () => 0;
  /** Replies to requests for these bytes wait for it. */
  until: (first: number, last: number) => Promise<void> | undefined = () => undefined;
  readonly #script: string;
  readonly #server: Server;

  constructor(script: string, archive = makeArchiveBuffer(floor())) {
    this.archive = archive;
    this.#script = script;
    this.#server = createServer((request, reply) => this.#answer(request, reply));
  }

  async open(): Promise<this> {
    await new Promise<void>((resolve) => this.#server.listen(0, '127.0.0.1', resolve));
    return this;
  }

  close(): void {
    this.#server.closeAllConnections();
    this.#server.close();
  }

  get url(): string {
    return `http://127.0.0.1:${(this.#server.address() as AddressInfo).port}/`;
  }

  #answer(request: IncomingMessage, reply: ServerResponse): void {
    const send = (type: string, text: string | Buffer): void =>
      void reply.writeHead(200, { 'Content-Type': type }).end(text);
    switch (request.url ?? '') {
      case '/':
        return send(
          'text/html',
          '<!doctype html><canvas></canvas><script src="stage.js"></script>',
        );
      case '/stage.js':
        return send('text/javascript', this.#script);
      case '/worker.js':
        return send('text/javascript', readFileSync(join(TERRAVOX_PAGE_DIST, 'worker.js')));
      case '/place.tvx':
        return void this.#sendRange(request.headers.range ?? '', reply);
      default:
        return void reply.writeHead(404).end();
    }
  }

  async #sendRange(range: string, reply: ServerResponse): Promise<void> {
    const [, from, to] = /bytes=(\d+)-(\d+)/.exec(range)!;
    const [first, last] = [Number(from), Math.min(Number(to), this.archive.length - 1)];
    await this.until(first, last);
    const status = this.fails(first, last);
    if (status !== 0) return void reply.writeHead(status).end();
    reply.writeHead(206, {
      'Content-Range': `bytes ${first}-${last}/${this.archive.length}`,
      ETag: '"one"',
    });
    reply.end(this.archive.subarray(first, last + 1));
  }
}

async function bundle(): Promise<string> {
  const page = join(TERRAVOX_PAGE_DIST, '..');
  const { build } = createRequire(join(page, 'package.json'))('esbuild') as {
    build: (options: object) => Promise<{ outputFiles: { text: string }[] }>;
  };
  const built = await build({
    entryPoints: [join(TERRAVOX_ROOT, 'tests/page/support/stage-page.ts')],
    bundle: true,
    write: false,
    loader: { '.glsl': 'text' },
    format: 'iife',
    logLevel: 'warning',
  });
  return built.outputFiles[0]!.text;
}

describe('a stage', { skip: noBrowser }, () => {
  let browser: Browser;
  let script: string;
  before(async () => {
    [browser, script] = await Promise.all([openBrowser(), bundle()]);
  });
  after(() => browser?.close());

  async function start(
    host: StageHost,
    poolBytes: number,
    from: object = kView,
    more: object = {},
  ): Promise<Page> {
    const { page } = await openPage(browser, host.url, {}, 1);
    const place = { url: `${host.url}place.tvx` };
    await page.evaluate(
      (job) => window.startStage(job as Parameters<typeof window.startStage>[0]),
      { place, view: from, poolBytes, ...more },
    );
    return page;
  }

  async function onHost(
    archive: Buffer | undefined,
    tell: (host: StageHost) => Promise<void>,
  ): Promise<void> {
    const host = await new StageHost(script, archive).open();
    try {
      await tell(host);
    } finally {
      for (const context of browser.contexts()) await context.close();
      host.close();
    }
  }

  /** What a page does by itself it does within some frames. */
  const passFrames = (page: Page): Promise<void> =>
    page.evaluate(
      () =>
        new Promise<void>((resolve) => {
          let left = 60;
          const next = (): void => {
            left -= 1;
            if (left > 0) requestAnimationFrame(next);
            else resolve();
          };
          next();
        }),
    );

  const untilComplete = (page: Page): Promise<unknown> =>
    page.waitForFunction(
      () => {
        const { isComplete, samples } = window.stage.stats();
        return isComplete && samples > 0;
      },
      undefined,
      { polling: 100 },
    );

  /** Level of each pixel that shows a voxel. */
  const readLevels = (page: Page): Promise<number[]> =>
    page.evaluate(() =>
      [...window.stage.hits()]
        .filter((_, i) => i % 4 === 3)
        .filter((bits) => (bits & (1 << 13)) !== 0)
        .map((bits) => (bits >> 4) & 31),
    );

  test('pools that are too small for a view make its voxels coarser until it fits', () =>
    onHost(undefined, async (host) => {
      const large = await start(host, kManyPools);
      await untilComplete(large);
      const fine = await large.evaluate(() => window.stage.stats());
      assert.equal(fine.detail, 1);
      assert.ok(fine.columns > 256, `${fine.columns}`);
      const small = await start(host, kSmallestPools);
      await untilComplete(small);
      const coarse = await small.evaluate(() => window.stage.stats());
      assert.ok(coarse.detail > 1, `${coarse.detail}`);
      assert.ok(coarse.columns <= 256 && coarse.poolFill <= 1, JSON.stringify(coarse));
      const [here, there] = [await readLevels(large), await readLevels(small)];
      // There is no hole in it.
      assert.ok(here.length > 0 && there.length === here.length);
      for (const page of [large, small]) {
        assert.deepEqual(await page.evaluate(() => window.stage.ended), []);
      }
    }));

  test('a still picture rests when it has samples enough, until the view changes', () =>
    onHost(makeArchiveBuffer(floor(), 0), async (host) => {
      const kEnough = 256;
      const stats = (page: Page): Promise<StageStats> => page.evaluate(() => window.stage.stats());
      const page = await start(host, kManyPools, kView, { side: 16 });
      await untilComplete(page);
      await page.waitForFunction((n) => window.stage.stats().samples >= n, kEnough, {
        polling: 100,
      });
      await passFrames(page); // the last frame counts when it is drawn
      const resting = await stats(page);
      await passFrames(page);
      const later = await stats(page);
      assert.deepEqual([later.samples, later.frames], [kEnough, resting.frames]);
      assert.ok((await readLevels(page)).length > 0);
      const turned = { ...kView, headingDeg: 30 };
      const left = await page.evaluate((view) => {
        window.stage.setView(view);
        return window.stage.stats().samples;
      }, turned);
      assert.equal(left, 0);
      await page.waitForFunction((n) => window.stage.stats().frames > n, resting.frames, {
        polling: 100,
      });
    }));

  test('the sky stands before the first column does, and is no whole picture', () =>
    onHost(makeArchiveBuffer(floor(), 70_000), async (host) => {
      let release: () => void = () => undefined;
      const released = new Promise<void>((resolve) => (release = resolve));
      // The header is at the beginning, the index at the end.
      const isOfBoxes = (first: number, last: number): boolean =>
        first > 0 && last < host.archive.length - 1;
      host.until = (first, last) => (isOfBoxes(first, last) ? released : undefined);
      const page = await start(host, kManyPools);
      await page.waitForFunction(() => window.stage.stats().samples > 0, undefined, {
        polling: 100,
      });
      const [red, green, blue] = await page.evaluate(() => window.stage.colour());
      assert.ok(red! > 0 && green! > 0 && blue! > 0, `${red}, ${green}, ${blue}`);
      const { columns, waiting } = await page.evaluate(() => window.stage.stats());
      assert.equal(columns, 0);
      assert.ok(waiting > 0);
      assert.equal(await page.evaluate(() => window.stage.isReady()), false);
      release();
      await untilComplete(page);
      assert.ok((await readLevels(page)).length > 0);
      assert.ok(await page.evaluate(() => window.stage.isReady()));
    }));

  test('the largest boxes that there are have room, too', async () => {
    const bounds = { min: [0, 0, 0], max: [64, 256, 128] };
    const keys: readonly Key[] = [
      [0, 0, 0, 0],
      [0, 0, 0, 1],
    ];
    const boxes = keys.map((key): TestBox => ({ key, frame: fullBoxFrame(key, 4) }));
    const facts = { ...kFacts, bounds, levels: 2 };
    const coarse: TestBox = { key: [1, 0, 0, 0], voxels: [{ x: 3, y: 3, z: 3, material: 4 }] };
    const host = await new StageHost(
      script,
      makeArchiveBuffer([...boxes, coarse], 0, facts),
    ).open();
    try {
      const view = { ...kView, position: [32, 1200, 64], pitchDeg: -89 } as const;
      const page = await start(host, kManyPools, view);
      await untilComplete(page);
      const hits = await page.evaluate(() =>
        [...window.stage.hits()].filter((_, i) => i % 4 === 3),
      );
      const isSolid = (bits: number): boolean => (bits & (1 << 13)) !== 0;
      const isHole = (bits: number): boolean => (bits & (1 << 12)) !== 0;
      assert.ok(hits.filter(isSolid).length > hits.length / 4);
      assert.equal(hits.filter(isHole).length, 0);
      assert.ok(hits.filter(isSolid).every((bits) => ((bits >> 4) & 31) === 0));
    } finally {
      for (const context of browser.contexts()) await context.close();
      host.close();
    }
  });

  test('a column that cannot be read is asked for twice, and is a hole then', () =>
    onHost(undefined, async (host) => {
      // The middle of the file: boxes of the finest level.
      const [from, to] = [host.archive.length * 0.3, host.archive.length * 0.32];
      let failed = 0;
      host.fails = (first, last) => {
        const isBad = first < to && last > from;
        failed += Number(isBad);
        return isBad ? 404 : 0;
      };
      const page = await start(host, kManyPools);
      await untilComplete(page);
      const { failures, ended, isReady } = await page.evaluate(() => ({
        ...window.stage,
        isReady: window.stage.isReady(),
        stats: undefined,
        hits: undefined,
      }));
      assert.deepEqual(ended, []);
      assert.ok(isReady);
      assert.ok(failures.length >= 2 && failures.every((kind) => kind === 'missing'));
      assert.ok(failed >= 2, `${failed}`);
      // All else is there, and nothing is wanted any more.
      assert.ok((await readLevels(page)).length > 0);
      assert.equal((await page.evaluate(() => window.stage.stats())).waiting, 0);
    }));

  test('a place that is not there ends the stage with the reason', () =>
    onHost(undefined, async (host) => {
      host.fails = () => 404;
      const page = await start(host, kManyPools);
      await page.waitForFunction(() => window.stage.ended.length > 0, undefined, { polling: 100 });
      const ended = await page.evaluate(() => window.stage.ended);
      assert.match(ended[0]!, /^missing: .*status 404/);
      assert.equal(await page.evaluate(() => window.stage.isReady()), false);
    }));
});
