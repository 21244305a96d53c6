import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { test } from 'node:test';
import type { Vec3 } from '../../voxelserver/serve/page/src/vec3.js';
import { fromLink } from '../../voxelserver/serve/page/src/viewer/ui/link.js';
import { toCamera, lookingAt } from '../../voxelserver/serve/page/src/viewer/ui/navigation.js';
import { readPlaceFile } from '../../voxelserver/serve/page/src/viewer/ui/place-file.js';
import {
  noBrowser,
  openBrowser,
  openPage,
  screenshot,
  until,
  untilText,
} from './support/browser.js';
import { dot, isNoise, plus } from './support/site.js';

/** A site of `terravox publish`, whose address is TERRAVOX_SITE: tests/e2e/publish_test.py. */

const kSite = process.env['TERRAVOX_SITE'] ?? '';
const kPicture = process.env['TERRAVOX_SITE_PICTURE'] ?? '';
const kHits = process.env['TERRAVOX_SITE_HITS'] ?? '';
const [kWidth, kHeight] = (process.env['TERRAVOX_SITE_SIZE'] ?? '400x300').split('x').map(Number);
const kSamples = 6; // leaves let rays through at random

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
    const picture = await page.evaluate(() =>
      document.querySelector('canvas')!.toDataURL('image/jpeg', 0.95),
    );
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
    // The name comes with a list that is fetched only now.
    await untilText(page, '#facts', /LiDAR square[A-Z]+_\d+_\d+/);

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

    for (const seen of [errors, other.errors]) {
      assert.deepEqual(
        seen.filter((message) => !isNoise(message)),
        [],
      );
    }
    assert.deepEqual([...foreign, ...other.foreign], []);
  } finally {
    await browser.close();
  }
});

test(
  'the view of the whole place lies beside the panel, whatever the shape of the window is',
  { skip: noBrowser },
  async () => {
    const browser = await openBrowser();
    try {
      const place = readPlaceFile(await (await fetch(new URL('place.json', kSite))).json());
      const whole = place.views.findIndex(({ name }) => name === 'Whole place');
      const { min, max } = place.views[whole]!.frame!;
      const corners = Array.from(
        { length: 8 },
        (_, i) => [0, 1, 2].map((a) => (((i >> a) & 1) === 0 ? min : max)[a]!) as unknown as Vec3,
      );
      // What counts is where things lie: few pixels show that, too.
      const options = { viewport: { width: 1000, height: 500 }, deviceScaleFactor: 0.25 };
      const { page } = await openPage(browser, kSite, options, 1);
      await page.evaluate(() => window.terravox.ready);
      await page.locator('#views').selectOption(String(whole));
      const { position, target } = place.views[whole]!;
      const direction = lookingAt({ position, headingDeg: 0, pitchDeg: 0, fovDeg: 40 }, target);
      for (const [width, height] of [
        [1000, 500],
        [700, 420],
        [400, 700],
        [1000, 500],
      ] as const) {
        await page.setViewportSize({ width, height });
        // The address follows the view.
        await until(`${width} x ${height}: all corners are seen`, async () => {
          const { link, picture, panel } = await page.evaluate(() => {
            const rectangle = (selector: string) =>
              document.querySelector(selector)!.getBoundingClientRect().toJSON() as DOMRect;
            return {
              link: location.hash,
              picture: rectangle('#picture'),
              panel: rectangle('#controls'),
            };
          });
          const { view } = fromLink(link, { view: direction, timeMs: 0 });
          const { forward, right, up } = toCamera(view);
          const scale = picture.height / 2 / dot(up, up);
          return corners.every((corner) => {
            const d = plus(corner, view.position, -1);
            const depth = dot(d, forward);
            const x = picture.left + picture.width / 2 + (scale * dot(d, right)) / depth;
            const y = picture.top + picture.height / 2 - (scale * dot(d, up)) / depth;
            const [isInPicture, isInPanel] = [picture, panel].map(
              (r) => x > r.left && x < r.right && y > r.top && y < r.bottom,
            );
            return depth > 0 && isInPicture && !isInPanel;
          });
        });
        await screenshot(page, `whole-place-${width}x${height}`);
      }
    } finally {
      await browser.close();
    }
  },
);
