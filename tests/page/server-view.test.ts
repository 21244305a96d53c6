import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';
import {
  noBrowser,
  openBrowser,
  openPage,
  screenshot,
  untilText,
  type WatchedPage,
} from './support/browser.js';

/**
 * The viewer of a real voxel server, at TERRAVOX_VIEWED, next to a site of the same world, at
 * TERRAVOX_VIEWED_SITE: tests/e2e/server_view_test.py. TERRAVOX_VIEWED_TOKEN: of the server, if
 * any.
 */

const kServer = process.env['TERRAVOX_VIEWED'] ?? '';
const kSite = process.env['TERRAVOX_VIEWED_SITE'] ?? '';
const kToken = process.env['TERRAVOX_VIEWED_TOKEN'] ?? '';
const kViewport = { width: 400, height: 300 };
const kAlike = 0.999;
const kLinkMs = 1000; // the address has followed the view by then

// What the driver says of reading back a pixel, and the browser of replies that ask for a token.
const isNoise = (message: string): boolean =>
  message.includes('GL Driver Message') || / 401 /.test(message);

async function whole(page: Page): Promise<void> {
  await page.waitForFunction(() => window.terravox !== undefined);
  await page.evaluate(() => window.terravox.ready);
  await page.waitForFunction(() => window.terravox.stats().isComplete, undefined, { polling: 200 });
}

const readHits = (page: Page): Promise<number[]> =>
  page.evaluate(() => [...window.terravox.firstHits()!.voxels]);

async function giveToken(page: Page): Promise<void> {
  const ask = page.locator('dialog#token');
  await untilText(page, '#token-title', /requires a token/);
  await screenshot(page, 'server-view-token');
  for (const wrong of ['not this one', 'žeton']) {
    await ask.locator('input').fill(wrong);
    await ask.locator('input').press('Enter');
    await untilText(page, '#token-title', /does not take this token/);
  }
  await page.keyboard.press('Escape');
  assert.ok(await ask.isVisible(), 'there is nothing behind it');
  await ask.locator('input').fill(kToken);
  await ask.locator('button').click();
  await ask.waitFor({ state: 'detached' });
}

function compare(server: readonly number[], site: readonly number[]): void {
  const pixels = kViewport.width * kViewport.height;
  let alike = 0;
  let solid = 0;
  for (let i = 0; i < 4 * pixels; i += 4) {
    if ([0, 1, 2, 3].every((k) => server[i + k] === site[i + k])) ++alike;
    if ((server[i + 3]! & (1 << 13)) !== 0) ++solid;
  }
  assert.ok(solid > pixels / 5, `${solid} of ${pixels} pixels show the world`);
  assert.ok(alike >= kAlike * pixels, `${alike} of ${pixels} pixels are alike`);
}

test('a voxel server shows its world as a site of it does', { skip: noBrowser }, async () => {
  const browser = await openBrowser();
  try {
    const opened: WatchedPage[] = [];
    const open = async (url: string): Promise<Page> => {
      const watched = await openPage(browser, url, { viewport: kViewport }, 1);
      opened.push(watched);
      return watched.page;
    };
    const server = await open(`${kServer}/view`);
    if (kToken !== '') await giveToken(server);
    await whole(server);
    assert.match(server.url(), /\/view\/(#|$)/);
    await server.waitForTimeout(kLinkMs);
    await screenshot(server, 'server-view');

    // Both at the rounded numbers of a link.
    const link = new URL(server.url()).hash;
    assert.match(link, /^#at=/);
    await server.evaluate((hash) => (location.hash = `${hash}&`), link);
    await server.waitForTimeout(kLinkMs);
    await whole(server);
    const site = await open(`${kSite}${link}`);
    await whole(site);
    compare(await readHits(server), await readHits(site));

    await server.locator('#picture').click();
    await untilText(server, '#facts', /LiDAR square[A-Z]+_\d+_\d+/);
    await server.keyboard.press('Escape');

    // To the map at this place, where the tab's token is known, and back by the place's link. In so
    // small a window the panel begins folded.
    await server.locator('#fold').click();
    await server.locator('#map-link').click();
    await untilText(server, '#status', /^The server is up\.$/);
    assert.match(server.url(), /#e=46\d{4}.*&n=10\d{4}/);
    await untilText(server, '#place', /On top[a-z_ ]+, \d/);
    await screenshot(server, 'server-view-map');
    await server.locator('#view-link').click();
    await whole(server);
    assert.match(server.url(), /\/view\/#at=46/);

    for (const { errors, foreign } of opened) {
      assert.deepEqual(
        errors.filter((message) => !isNoise(message)),
        [],
      );
      assert.deepEqual(foreign, []);
    }
  } finally {
    await browser.close();
  }
});
