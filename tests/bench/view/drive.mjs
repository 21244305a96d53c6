// Opens a site in chromium and measures: node drive.mjs '{"url": ..., "width": ..., "height": ...,
// "passes_s": seconds, "settle_s": seconds}'. Prints one line of JSON.
// TERRAVOX_CHROMIUM names the browser, TERRAVOX_CHROMIUM_FLAGS its flags, by blanks, and with
// TERRAVOX_BENCH_VISIBLE=1 it has a window.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const page_ = join(here, '../../../voxelserver/serve/page/package.json');
const { chromium } = createRequire(page_)('playwright-core');
const job = JSON.parse(process.argv[2]);
const kHangs_ms = 600_000;
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
  Object.assign(out, await passes(page, stats, job.passes_s));
  const watched = await page.evaluate(() => ({ ...window.watched, passes: undefined }));
  out.renderer = watched.renderer;
  out.texture_bytes = watched.textureBytes;
  out.errors = errors;
  console.log(JSON.stringify(out));
} finally {
  await browser.close();
}

/** Waits for the finest picture. @return whether it stands before time is over */
async function settle(stats) {
  const until = Date.now() + job.settle_s * 1000;
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
  const computeMedianMs = (list) => {
    const rates = list.map(([count, ms]) => ms / count).sort((a, b) => a - b);
    return pixels * rates[Math.floor(rates.length / 2)];
  };
  return {
    is_complete: isComplete,
    frames_per_s,
    moving_pixels: sum(moving, 0) / moving.length,
    moving_ms: computeMedianMs(moving),
    still_ms: computeMedianMs(still),
    rays_per_s: (1000 * pixels) / computeMedianMs(still),
  };
}
