// Opens a site in chromium and measures: node drive.mjs '{"url": ..., "width": ..., "height": ...,
// "first": true, "passes_s": seconds, "flight": {...}, "shot": PNG}'. Prints one line of JSON.
// TERRAVOX_CHROMIUM names the browser, TERRAVOX_CHROMIUM_FLAGS its flags, by blanks, and with
// TERRAVOX_BENCH_VISIBLE=1 it has a window.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const page_ = join(here, '../../../voxelserver/page/package.json');
const { chromium } = createRequire(page_)('playwright-core');
const job = JSON.parse(process.argv[2]);
const kHangs_ms = 600_000;
const kSettle_s = job.settle_s ?? 60;
const given = (process.env.TERRAVOX_CHROMIUM_FLAGS ?? '').split(' ').filter((flag) => flag !== '');
const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

const browser = await chromium.launch({
  executablePath: process.env.TERRAVOX_CHROMIUM ?? '/usr/bin/chromium',
  headless: process.env.TERRAVOX_BENCH_VISIBLE !== '1',
  args: [...(process.getuid?.() === 0 ? ['--no-sandbox'] : []), ...given],
});
try {
  const viewport = { width: job.width, height: job.height };
  const context = await browser.newContext({ viewport });
  context.setDefaultTimeout(kHangs_ms);
  const page = await context.newPage();
  const errors = [];
  page.on('pageerror', (error) => errors.push(error.message));
  await page.addInitScript(readFileSync(join(here, 'watch_graphics.js'), 'utf8'));
  await page.goto(job.url);
  await page.evaluate(() => window.terravox.ready);
  const stats = () => page.evaluate(() => window.terravox.stats());
  let now = await stats();
  while (now.first === undefined) {
    await wait(20);
    now = await stats();
  }
  const out = { first: now.first, pool_bytes: now.poolBytes };
  if (job.passes_s !== undefined) Object.assign(out, await passes(page, stats, job.passes_s));
  if (job.flight !== undefined) out.flight = await flight(page, stats, job.flight);
  const watched = await page.evaluate(() => ({ ...window.watched, passes: undefined }));
  out.renderer = watched.renderer;
  out.texture_bytes = watched.textureBytes;
  out.errors = errors;
  if (job.shot !== undefined) await page.screenshot({ path: job.shot });
  console.log(JSON.stringify(out));
} finally {
  await browser.close();
}

/** Waits for the finest picture. @return whether it stands before time is over */
async function settle(stats) {
  const until = Date.now() + kSettle_s * 1000;
  for (;;) {
    const { isComplete } = await stats();
    if (isComplete || Date.now() > until) return isComplete;
    await wait(200);
  }
}

/** Passes while the camera turns, and while it stands; the first without timing, which slows. */
async function passes(page, stats, seconds) {
  const isComplete = await settle(stats);
  const rate = async (key, what) => {
    await page.locator('canvas').focus();
    if (key !== undefined) await page.keyboard.down(key);
    await wait(500);
    const before = [what(await stats()), Date.now()];
    await wait(seconds * 1000);
    const after = [what(await stats()), Date.now()];
    if (key !== undefined) await page.keyboard.up(key);
    return (1000 * (after[0] - before[0])) / (after[1] - before[1]);
  };
  const timed = async (key) => {
    await page.evaluate(() => {
      window.watched.passes = [];
      window.watched.isTiming = true;
    });
    if (key !== undefined) await page.keyboard.down(key);
    await wait(seconds * 1000);
    if (key !== undefined) await page.keyboard.up(key);
    return page.evaluate(() => {
      window.watched.isTiming = false;
      return window.watched.passes;
    });
  };
  const frames_per_s = await rate('ArrowLeft', (s) => s.frames);
  const moving = await timed('ArrowRight');
  await wait(1000);
  const still = await timed(undefined);
  const sum = (list, i) => list.reduce((total, item) => total + item[i], 0);
  const pixels = job.width * job.height;
  // The median: other programs may stop a pass for a while.
  const msOf = (list) => {
    const rates = list.map(([count, ms]) => ms / count).sort((a, b) => a - b);
    return pixels * rates[Math.floor(rates.length / 2)];
  };
  return {
    is_complete: isComplete,
    frames_per_s,
    moving_pixels: sum(moving, 0) / moving.length,
    moving_ms: msOf(moving),
    still_ms: msOf(still),
    rays_per_s: (1000 * pixels) / msOf(still),
  };
}

/** Flies along curves above a square, and samples memory after collecting garbage. */
async function flight(page, stats, { seconds, every_s, centre, reach, height, speed }) {
  // From then on everything is flown through at the finest detail.
  await settle(stats);
  const session = await page.context().newCDPSession(page);
  await session.send('HeapProfiler.enable');
  const worker = await workerOf(session);
  await page.evaluate(
    ({ centre, reach, height, speed }) => {
      const started = performance.now();
      const at = (s) => [
        centre[0] + reach * Math.sin((speed * s) / reach),
        centre[1] + reach * Math.sin((0.71 * speed * s) / reach + 1),
      ];
      const move = () => {
        const s = (performance.now() - started) / 1000;
        const [x, z] = at(s);
        const [nextX, nextZ] = at(s + 0.5);
        const heading = ((Math.atan2(nextX - x, -(nextZ - z)) * 180) / Math.PI + 360) % 360;
        const place = `${x.toFixed(2)},${height},${z.toFixed(2)}`;
        history.replaceState(null, '', `#at=${place}&look=${heading.toFixed(2)},-12,42`);
        window.dispatchEvent(new HashChangeEvent('hashchange'));
      };
      window.flying = setInterval(move, 50);
    },
    { centre, reach, height, speed },
  );
  const samples = [];
  const end = Date.now() + seconds * 1000;
  const start = Date.now();
  while (Date.now() < end) {
    await wait(every_s * 1000);
    await session.send('HeapProfiler.collectGarbage');
    await worker.send('HeapProfiler.collectGarbage');
    const heap = await session.send('Runtime.getHeapUsage');
    const other = await worker.send('Runtime.getHeapUsage');
    const watched = await page.evaluate(() => ({ ...window.watched, passes: undefined }));
    const now = await stats();
    samples.push({
      s: (Date.now() - start) / 1000,
      page_bytes: heap.usedSize + (heap.backingStorageSize ?? 0),
      page_used_bytes: heap.usedSize,
      worker_bytes: other.usedSize + (other.backingStorageSize ?? 0),
      worker_used_bytes: other.usedSize,
      texture_bytes: watched.textureBytes,
      live: watched.live,
      made: watched.made,
      pool_bytes: now.poolBytes,
      fill: now.poolFill,
      columns: now.columns,
      requests: now.requests,
      bytes: now.bytes,
      frames: now.frames,
      detail: now.detail,
    });
  }
  await page.evaluate(() => clearInterval(window.flying));
  return samples;
}

/** A session of the worker's own. */
async function workerOf(session) {
  const attached = new Promise((resolve) => session.once('Target.attachedToTarget', resolve));
  await session.send('Target.setAutoAttach', {
    autoAttach: true,
    waitForDebuggerOnStart: false,
    flatten: false,
  });
  const { sessionId } = await attached;
  const replies = new Map();
  session.on('Target.receivedMessageFromTarget', ({ message }) => {
    const { id, result } = JSON.parse(message);
    replies.get(id)?.(result);
    replies.delete(id);
  });
  let last = 0;
  return {
    send: (method, params = {}) =>
      new Promise((resolve) => {
        const id = ++last;
        replies.set(id, resolve);
        const message = JSON.stringify({ id, method, params });
        void session.send('Target.sendMessageToTarget', { sessionId, message });
      }),
  };
}
