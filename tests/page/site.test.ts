import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { test } from 'node:test';
import { noBrowser, openBrowser, openPage } from './support/browser.js';

/** A site of `terravox publish`, whose address is TERRAVOX_SITE: tests/e2e/publish_test.py. */

const kSite = process.env['TERRAVOX_SITE'] ?? '';
const kPicture = process.env['TERRAVOX_SITE_PICTURE'] ?? '';
const kHits = process.env['TERRAVOX_SITE_HITS'] ?? '';
const [kWidth, kHeight] = (process.env['TERRAVOX_SITE_SIZE'] ?? '400x300').split('x').map(Number);
const kSamples = 6; // leaves let rays through at random

// What the driver says of reading back a pixel.
const isNoise = (message: string): boolean => message.includes('GL Driver Message');

test('a site shows its place, and asks nobody but its host', { skip: noBrowser }, async () => {
  const browser = await openBrowser();
  try {
    const viewport = { width: kWidth!, height: kHeight! };
    const { page, errors, foreign } = await openPage(browser, kSite, { viewport }, 1);
    await page.evaluate(() => window.terravox.ready);
    await page.waitForFunction(
      (samples) => {
        const stats = window.terravox.stats();
        return stats.isComplete && stats.samples >= samples;
      },
      kSamples,
      { polling: 200 },
    );
    const picture = await page.evaluate(() => document.querySelector('canvas')!.toDataURL('image/jpeg', 0.95));
    writeFileSync(kPicture, Buffer.from(picture.split(',')[1]!, 'base64'));
    const hits = await page.evaluate(() => {
      const { voxels, details } = window.terravox.firstHits()!;
      return { voxels: [...voxels], details: [...details] };
    });
    writeFileSync(kHits, JSON.stringify(hits));
    assert.equal(await page.title(), 'A & B · Terravox');
    assert.equal(await page.locator('#status').textContent(), '');

    // A click on the ground, above the panel, tells what is there.
    await page.mouse.click(kWidth! / 2, kHeight! * 0.4);
    await page.locator('#place').waitFor({ state: 'visible' });
    assert.match(await page.locator('#facts').innerText(), /Easting\s+46\d{4}/);

    // Flying by keys changes the view, and the link follows.
    await page.locator('canvas').focus();
    const before = page.url();
    await page.keyboard.press('ArrowLeft', { delay: 300 });
    await page.waitForFunction((url) => location.href !== url, before);
    assert.match(page.url(), /#at=[-\d.,]+&look=[-\d.,]+&time=\d+$/);

    // Whoever opens the link sees the same place.
    const link = page.url();
    const other = await openPage(browser, link, { viewport }, 1);
    await other.page.evaluate(() => window.terravox.ready);
    await other.page.waitForTimeout(500);
    assert.equal(other.page.url(), link);

    for (const seen of [errors, other.errors])
      assert.deepEqual(seen.filter((message) => !isNoise(message)), []);
    assert.deepEqual([...foreign, ...other.foreign], []);
  } finally {
    await browser.close();
  }
});
