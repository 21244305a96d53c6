import { existsSync, mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { chromium, type Browser, type BrowserContextOptions, type Page } from 'playwright-core';

const kChromium = process.env['TERRAVOX_CHROMIUM'] ?? '/usr/bin/chromium';
/**
 * What ends a test that hangs: a loaded machine may need minutes for what takes a moment elsewhere.
 */
const kHangs_ms = 300_000;
/**
 * How many times as fast as real time the waits of a page pass: those between its polls are
 * seconds.
 */
const kSpeed = 10;
const kScreenshots = process.env['TERRAVOX_SCREENSHOTS'] ?? '';

/** Why there is no browser to test with, or false. */
export const noBrowser = existsSync(kChromium)
  ? false
  : `no ${kChromium}: install chromium, or name one with TERRAVOX_CHROMIUM`;

export const openBrowser = (): Promise<Browser> =>
  chromium.launch({
    executablePath: kChromium,
    headless: true,
    args: process.getuid?.() === 0 ? ['--no-sandbox'] : [],
  });

/** A page that keeps what must not happen: errors, and requests to anyone but the server. */
export type WatchedPage = {
  readonly page: Page;
  readonly errors: string[];
  readonly foreign: string[];
  readonly paths: string[];
};

/**
 * @param speed of waits of a second and more: 1 where the test looks for what stays for such a
 * while alone
 */
export async function openPage(
  browser: Browser,
  url: string,
  options: BrowserContextOptions = {},
  speed = kSpeed,
): Promise<WatchedPage> {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, ...options });
  context.setDefaultTimeout(kHangs_ms);
  const page = await context.newPage();
  await page.addInitScript((times) => {
    const wait = window.setTimeout.bind(window);
    // Shorter waits separate clicks from double clicks, or animate; longer ones end requests.
    const isPoll = (ms: number): boolean => ms >= 1000 && ms <= 10_000;
    const quick = (run: () => void, ms = 0): number => wait(run, isPoll(ms) ? ms / times : ms);
    window.setTimeout = quick as typeof window.setTimeout;
  }, speed);
  const watched: WatchedPage = { page, errors: [], foreign: [], paths: [] };
  page.on('console', (message) => {
    if (message.type() === 'error' || message.type() === 'warning') {
      watched.errors.push(message.text());
    }
  });
  page.on('pageerror', (error) => watched.errors.push(String(error)));
  page.on('dialog', (dialog) => {
    watched.errors.push(`a dialog: ${dialog.message()}`);
    void dialog.dismiss();
  });
  page.on('request', (request) => {
    const requested = new URL(request.url());
    if (['data:', 'blob:'].includes(requested.protocol)) return;
    if (requested.origin === new URL(url).origin) {
      watched.paths.push(requested.pathname.slice(new URL(url).pathname.length));
    } else watched.foreign.push(request.url());
  });
  await page.goto(url);
  return watched;
}

export async function screenshot(page: Page, name: string): Promise<void> {
  if (kScreenshots === '') return;
  mkdirSync(kScreenshots, { recursive: true });
  await page.screenshot({ path: join(kScreenshots, `${name}.png`) });
}

export const readShownText = async (page: Page, selector: string): Promise<string> =>
  (await page.locator(selector).textContent()) ?? '';

/**
 * Waits until an element's text matches. @throws Error of the browser driver after its time limit,
 * with both
 */
export async function untilText(page: Page, selector: string, pattern: RegExp): Promise<string> {
  await page
    .waitForFunction(
      ([s, p]) => new RegExp(p!, 's').test(document.querySelector(s!)?.textContent ?? ''),
      [selector, pattern.source],
    )
    .catch(async () => {
      throw new Error(
        `${selector} shows "${await readShownText(page, selector)}"; expected ${String(pattern)}`,
      );
    });
  return readShownText(page, selector);
}

/** How many of the map's pixels have each colour, 0xrrggbb. */
const mapColours = (page: Page): Promise<readonly (readonly [number, number])[]> =>
  page.evaluate(() => {
    const seen = new Map<number, number>();
    for (const canvas of document.querySelectorAll('#map canvas')) {
      if (!(canvas instanceof HTMLCanvasElement) || canvas.width === 0) continue;
      // Read from a copy: reading the map's own canvas often makes the browser warn, and slow it
      // down.
      const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', {
        willReadFrequently: true,
      });
      copy?.drawImage(canvas, 0, 0);
      const pixels = copy?.getImageData(0, 0, canvas.width, canvas.height).data;
      if (!pixels) continue;
      for (let i = 0; i < pixels.length; i += 4) {
        const colour = (pixels[i]! << 16) | (pixels[i + 1]! << 8) | pixels[i + 2]!;
        if (pixels[i + 3] === 255) seen.set(colour, (seen.get(colour) ?? 0) + 1);
      }
    }
    return [...seen];
  });

/** How many colours the map shows: 1 is an empty map. */
export const coloursOnMap = async (page: Page): Promise<number> => (await mapColours(page)).length;

/** @param colours #rrggbb */
export async function pixelsOnMap(page: Page, colours: readonly string[]): Promise<number> {
  const wanted = new Set(colours.map((colour) => parseInt(colour.slice(1), 16)));
  return (await mapColours(page)).reduce(
    (sum, [colour, count]) => sum + (wanted.has(colour) ? count : 0),
    0,
  );
}

export async function until(what: string, holds: () => boolean | Promise<boolean>): Promise<void> {
  for (
    const end = Date.now() + kHangs_ms;
    Date.now() < end;
    await new Promise((resolve) => setTimeout(resolve, 100))
  ) {
    if (await holds()) return;
  }
  throw new Error(`waited in vain: ${what}`);
}
