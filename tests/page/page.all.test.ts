// What a user does with the page, in a real browser. With TERRAVOX_URL the page of that server,
// else that of a small fake server.
import assert from 'node:assert/strict';
import { after, before, describe, test } from 'node:test';
import type { Browser, Page } from 'playwright-core';
import {
  coloursOnMap,
  noBrowser,
  openBrowser,
  openPage,
  pixelsOnMap,
  screenshot,
  readShownText,
  until,
  untilText,
  type WatchedPage,
} from './support/browser.js';
import { FakeServer } from './support/fake-server.js';

const kRealUrl = process.env['TERRAVOX_URL'];
/** A test of answers that no real server is made to give. */
const testOfFake = (name: string, run: () => Promise<void>): void => {
  if (kRealUrl === undefined) void test(name, run);
};

/**
 * Ref: W3C, Web Content Accessibility Guidelines 2.2, "relative luminance" and "contrast ratio".
 */
function measureContrast(a: string, b: string): number {
  const luminance = (hex: string): number => {
    assert.match(hex, /^#[0-9a-f]{6}$/i);
    const [r, g, bl] = [1, 3, 5]
      .map((i) => parseInt(hex.slice(i, i + 2), 16) / 255)
      .map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r! + 0.7152 * g! + 0.0722 * bl!;
  };
  const [dark, light] = [luminance(a), luminance(b)].sort((x, y) => x - y);
  return (light! + 0.05) / (dark! + 0.05);
}

describe('the page of the voxel server', { skip: noBrowser }, () => {
  const fake = new FakeServer();
  let browser: Browser;
  let url: string;
  before(async () => {
    browser = await openBrowser();
    url = kRealUrl === undefined ? (await fake.open()).url : new URL('.', kRealUrl).href;
  });
  after(async () => {
    await browser?.close();
    fake.close();
  });

  async function openMap(options = {}, speed?: number): Promise<WatchedPage> {
    const watched = await openPage(browser, url, options, speed);
    await untilText(watched.page, '#status', /^The server is up/);
    await until('the map is drawn', async () => (await coloursOnMap(watched.page)) > 5);
    return watched;
  }
  async function closeClean({ page, errors, foreign }: WatchedPage): Promise<void> {
    assert.deepEqual(errors, [], 'errors in the console');
    assert.deepEqual(foreign, [], 'requests to other hosts');
    await page.context().close();
  }
  const position = (page: Page): Promise<string> => readShownText(page, '#position');
  const untilMoved = (page: Page, from: string): Promise<void> =>
    until(`the map left ${from}`, async () => (await position(page)) !== from);

  test('it shows the world, its tiles, squares and statistics', async () => {
    const watched = await openMap();
    const { page } = watched;
    assert.ok(watched.paths.some((path) => /^map\/\d+\/-?\d+\/-?\d+\.png$/.test(path)));
    assert.notEqual(await readShownText(page, '#title'), '');
    await untilText(page, '#squares', /in all/);
    await untilText(page, '#server', /Running for.*Memory/);
    await untilText(page, '#server', /Requests\d+, [\d.]+ a second/);
    assert.match(await position(page), /^Middle: -?\d+\.?\d*, -?\d+\.?\d*/);
    assert.match(await readShownText(page, '.ol-scale-line'), /\d+ (m|km)/);
    await screenshot(page, 'light-1280');
    await closeClean(watched);
  });

  test('keys and mouse move and zoom the map', async () => {
    const watched = await openMap();
    const { page } = watched;
    await page.locator('#map').focus();
    const scale = (): Promise<string> => readShownText(page, '.ol-scale-line');
    for (const key of ['ArrowRight', 'ArrowUp']) {
      const before = await position(page);
      await page.keyboard.press(key);
      await untilMoved(page, before);
    }
    const before = await scale();
    await page.keyboard.press('+');
    await page.keyboard.press('+');
    await until('plus zooms', async () => (await scale()) !== before);
    const box = (await page.locator('#map').boundingBox())!;
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    // The map may still be zooming, and reports its middle once more at the end.
    await until('the place under the mouse is shown', async () => {
      await page.mouse.move(x + 1, y);
      await page.mouse.move(x, y);
      return !/^Middle/.test(await position(page));
    });
    const zoomed = await scale();
    await until('the wheel zooms', async () => {
      await page.mouse.wheel(0, 600);
      return (await scale()) !== zoomed;
    });
    const tiles = watched.paths.length;
    await page.mouse.down();
    await page.mouse.move(x - 150, y - 100, { steps: 5 });
    await page.mouse.up();
    await until('dragging requests more tiles', () => watched.paths.length > tiles);
    await page.locator('.ol-zoom-in').click();
    await closeClean(watched);
  });

  test('Enter shows what is in the middle, with a command that renders it', async () => {
    // The button shows 'Copied' for a while.
    const watched = await openMap({ permissions: ['clipboard-read', 'clipboard-write'] }, 1);
    const { page } = watched;
    await untilText(page, '#squares', /in all/);
    await page.locator('#map').focus();
    await page.keyboard.press('Enter');
    await until(
      'there is a command',
      async () => (await page.locator('#command').inputValue()) !== '',
    );
    const command = await page.locator('#command').inputValue();
    const number = '-?\\d+\\.?\\d*';
    const place = `${number},${number},${number}`;
    assert.match(
      command,
      new RegExp(
        `^\\./terravox render ${url.replace(/\/$/, '')} ` +
          `--camera-target=${place} --camera-position=${place} -o [\\w.-]+\\.png$`,
      ),
    );
    assert.match(await readShownText(page, '#place dl'), /On top.*m/);
    if (kRealUrl === undefined) {
      assert.match(
        await readShownText(page, '#place dl'),
        /EPSG:3794.*Latitude, longitude46\.\d+, 14\.\d+.*grass, \d+\.00 m, #50783c.*CC BY 4\.0/,
      );
      assert.match(await readShownText(page, '#place-summary'), /^\d+\.\d,\d+\.\d: square TM_46/);
    }
    await page.getByRole('button', { name: 'Copy command' }).click();
    await untilText(page, '.command', /Copied/);
    assert.equal(await page.evaluate(() => navigator.clipboard.readText()), command);
    await closeClean(watched);
  });

  testOfFake('a click shows the square beneath, and one outside the world shows that', async () => {
    const watched = await openMap();
    const { page } = watched;
    await untilText(page, '#squares', /4 in all: 1 wanted, 1 fetched, 1 prepared, 1 failed/);
    const box = (await page.locator('#map').boundingBox())!;
    await page.mouse.click(box.x + box.width / 2 + 120, box.y + box.height / 2 + 120);
    await untilText(page, '#place', /SquareTM_463_100Statefailed.*the file ends in the header/);
    await page.mouse.click(box.x + 3, box.y + box.height / 2);
    await untilText(page, '#place-summary', /in no LiDAR square/);
    await untilText(page, '#place', /only air here/);
    await page.getByRole('button', { name: 'TM_462_101' }).click();
    await untilText(page, '#place', /SquareTM_462_101Stateprepared/);
    await untilText(page, '.command .note', /south-west/);
    await screenshot(page, 'light-1280-place');
    await closeClean(watched);
  });

  test('layers are switched by keyboard, and boxes shown by level', async () => {
    const watched = await openMap();
    const { page } = watched;
    await page.getByLabel('Kept boxes').focus();
    await page.keyboard.press('Space');
    await untilText(page, '#layers', /\d+ in memory, \d+ on disk/);
    await screenshot(page, 'light-1280-boxes');
    const text = await readShownText(page, '#layers');
    await page.getByLabel('Level of the boxes').selectOption('1');
    await until('level 1 is requested', () => watched.paths.includes('v2/cached/1'));
    if (kRealUrl === undefined) {
      await until('other numbers', async () => (await readShownText(page, '#layers')) !== text);
    }
    for (const name of ['Top view', 'LiDAR squares', 'Kept boxes']) {
      await page.getByLabel(name).uncheck();
    }
    await until('nothing is drawn any more', async () => (await coloursOnMap(page)) <= 5);
    await page.getByLabel('Top view').check();
    await until('the top view is back', async () => (await coloursOnMap(page)) > 5);
    await closeClean(watched);
  });

  test('coordinates are found, and wrong ones explained', async () => {
    const watched = await openMap();
    const { page } = watched;
    const [e, n] = /(-?\d+\.?\d*), (-?\d+\.?\d*)/
      .exec(await position(page))!
      .slice(1)
      .map(Number);
    await page.getByLabel('Go to').fill(`${e! + 30}, ${n! - 20}`);
    await page.keyboard.press('Enter');
    await untilText(page, '#position', new RegExp(`Middle: ${Math.floor(e! + 30)}`));
    await page.getByLabel('Go to').fill('somewhere');
    await page.keyboard.press('Enter');
    await untilText(page, '#search-error', /no number/);
    assert.equal(await page.getByLabel('Go to').getAttribute('aria-invalid'), 'true');
    await closeClean(watched);
  });

  test('a link leads to its place', async () => {
    const first = await openMap();
    const [e, n] = /(-?\d+\.?\d*), (-?\d+\.?\d*)/
      .exec(await position(first.page))!
      .slice(1)
      .map(Number);
    await closeClean(first);
    const watched = await openPage(browser, `${url}#e=${e! + 40}&n=${n! - 30}&r=0.25`);
    await untilText(watched.page, '#place-summary', new RegExp(`^${Math.floor(e! + 40)}`));
    await untilText(watched.page, '#position', new RegExp(`^Middle: ${Math.floor(e! + 40)}`));
    await closeClean(watched);
  });

  testOfFake('it works behind a proxy that adds a path', async () => {
    const behind = new FakeServer();
    behind.prefix = '/some/where/';
    await behind.open();
    const watched = await openPage(browser, behind.url);
    await until('the map is drawn', async () => (await coloursOnMap(watched.page)) > 5);
    await untilText(watched.page, '#squares', /4 in all/);
    assert.ok(
      behind.requestPaths.every((path) => path.startsWith(behind.prefix)),
      behind.requestPaths.join(' '),
    );
    await closeClean(watched);
    behind.close();
  });

  for (const colorScheme of ['light', 'dark'] as const) {
    test(`colours contrast with their background: ${colorScheme}`, async () => {
      const watched = await openMap({ colorScheme });
      const value = (name: string): Promise<string> =>
        watched.page.evaluate(
          (n) => getComputedStyle(document.documentElement).getPropertyValue(n).trim(),
          name,
        );
      const contrast = async (a: string, b: string): Promise<number> =>
        measureContrast(await value(a), await value(b));
      // WCAG 2.2: 4.5 for text, 3 for lines and signs.
      for (const back of ['--back', '--panel']) {
        const inks = ['--text', '--faint', '--accent', '--error'];
        const signs = ['--wanted', '--fetched', '--prepared', '--failed', '--memory', '--disk'];
        for (const ink of inks) assert.ok((await contrast(ink, back)) >= 4.5, `${ink} on ${back}`);
        for (const sign of signs) {
          assert.ok((await contrast(sign, back)) >= 3, `${sign} on ${back}`);
        }
      }
      await closeClean(watched);
    });
  }

  testOfFake('unfinished tiles are requested again when boxes were made', async () => {
    fake.made = 3;
    const watched = await openMap();
    const { page } = watched;
    await page.locator('#map').focus();
    // A key that comes while the map still zooms may change nothing: the nearest step is where it
    // goes.
    await until('coarse tiles are asked for', async () => {
      await page.keyboard.press('-');
      return /not made yet/.test(await readShownText(page, '#layers'));
    });
    await screenshot(page, 'light-1280-unfinished');
    fake.made = 11;
    await until(
      'the hint is gone',
      async () => !/not made yet/.test(await readShownText(page, '#layers')),
    );
    await closeClean(watched);
    fake.made = 3;
  });

  test('an analysis of what the map shows becomes a layer, with legend and values', async () => {
    const watched = await openMap();
    const { page } = watched;
    await page.getByLabel('First day').fill('2026-06-21');
    await page.getByLabel('Last day').fill('2026-06-21');
    await page.getByLabel('Edge of a cell').fill('4');
    await untilText(page, '#analysis-cells', /^About \d+ × \d+ cells\.$/);
    await page.getByRole('button', { name: 'Compute what the map shows' }).click();
    await page.locator('#analysis-result').waitFor({ state: 'visible' });
    await untilText(page, '#analysis-result .ends', /^([\d.]+ h){3}$/);
    await untilText(page, '#analysis-state', /^$/);
    assert.match(
      await readShownText(page, '#analysis-caption'),
      /^Hours of sun · roofs and crowns · 21 Jun 2026 · cells of 4 m\..*no clouds.*UTC\+\d+\.$/,
    );
    await page.locator('#map').hover();
    await until('the value under the pointer is shown', async () => {
      await page.mouse.move(400 + Math.random() * 100, 400);
      return /^Here: [\d.]+ h$/.test(await readShownText(page, '#analysis-value'));
    });
    await page.locator('#analysis-result').scrollIntoViewIfNeeded();
    await screenshot(page, 'light-1280-analysis');
    // The form is of the next analysis, and the value is that of the band without any movement.
    await page.getByLabel('First day').fill('2026-06-20');
    assert.match(await readShownText(page, '#analysis-caption'), /21 Jun 2026/);
    await page
      .getByLabel('Shown', { exact: true })
      .selectOption({ label: 'First sun, clock time' });
    await untilText(page, '#analysis-result .ends', /^(\d\d:\d\d){3}$/);
    await untilText(page, '#analysis-value', /^Here: (\d\d:\d\d|no value)$/);
    await page.getByLabel('Opacity').fill('30');
    const download = page.waitForEvent('download');
    await page.getByRole('button', { name: 'Download GeoTIFF' }).click();
    assert.equal((await download).suggestedFilename(), 'terravox-sun-2026-06-21.tif');
    await page.getByRole('button', { name: 'Remove' }).click();
    await page.locator('#analysis-result').waitFor({ state: 'hidden' });
    if (kRealUrl === undefined) await until('the job is deleted', () => fake.jobs.size === 0);
    await closeClean(watched);
  });

  testOfFake(
    'an analysis lies below the frames of squares, and has the colours of its legend',
    async () => {
      const watched = await openMap();
      const { page } = watched;
      await untilText(page, '#squares', /in all/);
      // Of the states of squares: --wanted, --fetched, --prepared, --failed.
      const frames = ['#5f6873', '#0b5cad', '#1a7334', '#b3261e'];
      let before = 0;
      await until('frames are drawn', async () => (before = await pixelsOnMap(page, frames)) > 100);
      await page.getByRole('button', { name: 'Compute what the map shows' }).click();
      // The end of the scale for sun: no other layer has this colour.
      await until('the result is drawn', async () => (await pixelsOnMap(page, ['#fcffa4'])) > 100);
      const after = await pixelsOnMap(page, frames);
      assert.ok(after > 0.9 * before, `${after} pixels of frames instead of ${before}`);
      await closeClean(watched);
      fake.jobs.clear();
    },
  );

  testOfFake('no choice of an analysis is cut off', async () => {
    fake.isOnEarth = true;
    const watched = await openMap();
    const { page } = watched;
    await page.getByRole('button', { name: 'Compute what the map shows' }).click();
    await page.locator('#analysis-result').waitFor({ state: 'visible' });
    const cut = await page.evaluate(() => {
      const context = new OffscreenCanvas(1, 1).getContext('2d')!;
      const arrowPx = 24;
      return [
        ...document.querySelectorAll<HTMLSelectElement>(
          '#analysis-form select, #analysis-result select',
        ),
      ].flatMap((select) => {
        context.font = getComputedStyle(select).font;
        const roomPx = select.clientWidth - arrowPx;
        return select.clientWidth === 0
          ? []
          : [...select.options]
              .filter(({ text }) => context.measureText(text).width > roomPx)
              .map(({ text }) => text);
      });
    });
    assert.deepEqual(cut, []);
    await closeClean(watched);
    fake.jobs.clear();
  });

  testOfFake('an analysis may be stopped, and a failed one says why', async () => {
    const watched = await openMap();
    const { page } = watched;
    fake.jobLooks = 1e9;
    await page.getByRole('button', { name: 'Compute what the map shows' }).click();
    await untilText(page, '#analysis-state', /^Computing: 0 %$/);
    assert.ok(await page.getByRole('button', { name: 'Compute' }).isDisabled());
    await page.getByRole('button', { name: 'Stop' }).click();
    await until('the job is deleted', () => fake.jobs.size === 0);
    await untilText(page, '#analysis-state', /^$/);
    fake.jobLooks = 2;
    fake.jobFails = 'no such day';
    await page.getByRole('button', { name: 'Compute what the map shows' }).click();
    await untilText(page, '#analysis-state', /^The analysis failed: no such day$/);
    fake.jobFails = '';
    await page.getByLabel('Analysis', { exact: true }).selectOption('sight');
    await page.getByRole('button', { name: 'Compute what the map shows' }).click();
    await untilText(page, '#analysis-state', /^Click the map where somebody stands/);
    await page.getByLabel('Analysis', { exact: true }).selectOption('sun');
    await page.getByLabel('First day').fill('2026-06-22');
    await page.getByLabel('Last day').fill('2026-06-21');
    await page.getByRole('button', { name: 'Compute what the map shows' }).click();
    assert.equal(await page.locator('#analysis-to:invalid').count(), 1);
    // Days that are not of the analysis do not matter.
    await page.getByLabel('Analysis', { exact: true }).selectOption('terrain');
    await page.getByRole('button', { name: 'Compute what the map shows' }).click();
    await page.locator('#analysis-result').waitFor({ state: 'visible' });
    fake.jobLooks = 3;
    await closeClean(watched);
  });

  testOfFake('where the sun is not known, it is not offered', async () => {
    fake.isOnEarth = false;
    const watched = await openMap();
    await until(
      'kinds are offered',
      async () => (await watched.page.locator('#analysis-kind option').count()) > 0,
    );
    const kinds = await watched.page
      .locator('#analysis-kind option')
      .evaluateAll((options) => options.map((option) => (option as HTMLOptionElement).value));
    assert.deepEqual(kinds, ['terrain', 'sky', 'sight', 'clearance']);
    await closeClean(watched);
    fake.isOnEarth = true;
  });

  testOfFake('a server without analyses says how they are turned on', async () => {
    fake.hasJobs = false;
    const watched = await openMap();
    await untilText(watched.page, '#analysis-state', /terravox serve --jobs 1/);
    assert.equal(await watched.page.locator('#analysis-form').isVisible(), false);
    await closeClean(watched);
    fake.hasJobs = true;
  });

  for (const [name, options] of [
    ['dark-1280', { colorScheme: 'dark' }],
    ['light-390', { viewport: { width: 390, height: 800 } }],
    ['dark-390', { colorScheme: 'dark', viewport: { width: 390, height: 800 } }],
  ] as const) {
    test(`nothing is cut off at the side: ${name}`, async () => {
      const watched = await openMap(options);
      const { page } = watched;
      await page.locator('#map').focus();
      await page.keyboard.press('Enter');
      await until(
        'there is a command',
        async () => (await page.locator('#command').inputValue()) !== '',
      );
      const [inner, wanted] = await page.evaluate(() => [
        document.documentElement.clientWidth,
        document.documentElement.scrollWidth,
      ]);
      assert.ok(wanted <= inner, `${wanted} pixels wide in a window of ${inner}`);
      const [height, all] = await page.evaluate(() => [
        document.documentElement.clientHeight,
        document.documentElement.scrollHeight,
      ]);
      if (inner > 800) {
        assert.ok(
          all <= height,
          `${all} pixels high in a window of ${height}: only the panel should scroll`,
        );
      }
      await page.evaluate(() => window.scrollTo(0, 0));
      await screenshot(page, name);
      await page.locator('#place-title').evaluate((title) => title.scrollIntoView());
      await screenshot(page, `${name}-facts`);
      await closeClean(watched);
    });
  }
});
