import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import type { Browser, BrowserContextOptions, Page } from 'playwright-core';
import { noBrowser, openBrowser, screenshot, until } from './support/browser.js';

/**
 * The tools of a site of `terravox publish`, whose address is TERRAVOX_SITE_TOOLS, as people use
 * them.
 */

const kSite = process.env['TERRAVOX_SITE_TOOLS'] ?? '';
const kWide = { viewport: { width: 1000, height: 700 } } as const;
const kPhone = {
  viewport: { width: 390, height: 844 },
  hasTouch: true,
  isMobile: true,
} as const;
const kTools = ['measure', 'profile', 'section', 'sight', 'layers', 'sun'] as const;
const kMinContrast = 4.5;
const kMinTouchPx = 44;
const kMostTabs = 80;
const kHangsMs = 300_000;

// What the driver says of reading back a pixel.
const isNoise = (message: string): boolean => message.includes('GL Driver Message');

const kCredit = { attribution: 'A survey & its people', licence: 'CC0' } as const;

let browser: Browser | undefined;
/** place.json of the site, with names for its sources. */
let placeFile = {};
before(async () => {
  if (noBrowser !== false) return;
  browser = await openBrowser();
  const response = await fetch(new URL('place.json', kSite));
  placeFile = { ...((await response.json()) as object), ...kCredit };
});
after(async () => browser?.close());

type Opened = { readonly page: Page; readonly end: () => Promise<void> };

/**
 * A page with its first whole picture, of a place whose sources have names; `end` asserts that
 * nothing went wrong in it.
 */
async function open(options: BrowserContextOptions, search = '', link = ''): Promise<Opened> {
  const context = await browser!.newContext(options);
  context.setDefaultTimeout(kHangsMs);
  await context.route('**/place.json', (route) => route.fulfill({ json: placeFile }));
  const page = await context.newPage();
  const errors: string[] = [];
  page.on('console', (message) => {
    const isBad = message.type() === 'error' || message.type() === 'warning';
    if (isBad && !isNoise(message.text())) errors.push(message.text());
  });
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('request', (request) => {
    const { protocol, origin } = new URL(request.url());
    const isOwn = ['data:', 'blob:'].includes(protocol) || origin === new URL(kSite).origin;
    if (!isOwn) errors.push(`a request to ${request.url()}`);
  });
  await page.goto(kSite + search + link);
  await page.evaluate(() => window.terravox.ready);
  const end = async (): Promise<void> => {
    assert.deepEqual(errors, []);
    await context.unrouteAll({ behavior: 'ignoreErrors' });
    await context.close();
  };
  return { page, end };
}

/** Presses Tab until the focus is there. */
async function tabTo(page: Page, selector: string, key = 'Tab'): Promise<void> {
  for (let i = 0; i < kMostTabs; ++i) {
    if (await page.evaluate((s) => document.activeElement?.matches(s) === true, selector)) return;
    await page.keyboard.press(key);
  }
  throw new Error(`${kMostTabs} times ${key} do not lead to ${selector}`);
}

const opener = (tool: string): string => `#tool-buttons [aria-controls='tool-${tool}']`;

/** The button of a tool with this text, as a selector that matches() knows, by its number. */
async function findButton(page: Page, tool: string, text: string): Promise<string> {
  const found = await page.evaluate(
    ([id, name]) =>
      [...document.querySelectorAll(`#tool-${id} button`)].findIndex((b) => b.textContent === name),
    [tool, text] as const,
  );
  assert.ok(found >= 0, `${tool} has no button ${text}`);
  return `#tool-${tool} .buttons button:nth-of-type(${found + 1})`;
}

const linkHas = (page: Page, pattern: RegExp): Promise<void> =>
  until(`the link matches ${String(pattern)}`, () => pattern.test(page.url()));

/**
 * Turns the view by a little, once the link holds what it is to keep, and goes to the picture. By
 * the link: how far keys turn depends on how long the machine takes.
 */
async function lookAside(page: Page, byDeg: number, kept: RegExp): Promise<void> {
  await linkHas(page, kept);
  const next = new URL(page.url()).hash.replace(
    /&look=([\d.]+)/,
    (_, heading: string) => `&look=${(Number(heading) + byDeg + 360) % 360}`,
  );
  await page.evaluate((hash) => (location.hash = hash), next);
  await tabTo(page, '#picture', 'Shift+Tab');
}

/** Names and values of a list of facts. */
const readShownFacts = (page: Page, selector: string): Promise<Record<string, string>> =>
  page.evaluate(
    (s) =>
      Object.fromEntries(
        [...document.querySelectorAll(`${s} > div`)].map((row) => [
          row.children[0]!.textContent,
          row.children[1]!.textContent,
        ]),
      ) as Record<string, string>,
    selector,
  );

test('every tool can be used by keys alone', { skip: noBrowser }, async () => {
  const { page, end } = await open(kWide);
  const press = (key: string): Promise<void> => page.keyboard.press(key);

  // Measuring: a point by the button, one by Enter on the picture.
  await tabTo(page, opener('measure'));
  await press('Enter');
  await tabTo(page, await findButton(page, 'measure', 'Add middle of picture'));
  await press('Enter');
  await lookAside(page, 3, /&measure=/);
  await press('Enter');
  await lookAside(page, 3, /&measure=[^_&]+_[^_&]+&/);
  await press('Enter');
  await linkHas(page, /&measure=[-\d.,]+_[-\d.,]+_[-\d.,]+&tool=measure$/);
  await tabTo(page, '#tool-measure input');
  await press('Space');
  const measures = await readShownFacts(page, '#measures');
  assert.equal(measures['Points'], '3');
  assert.match(measures['Slope distance']!, /^[\d.]+ k?m$/);
  assert.match(measures['Horizontal area']!, /^[\d.]+ (m²|ha|km²)$/);
  assert.ok(parseFloat(measures['Slope distance']!) >= parseFloat(measures['Horizontal']!));
  await screenshot(page, 'tools-measure');
  await tabTo(page, await findButton(page, 'measure', 'Undo point'), 'Shift+Tab');
  await press('Enter');
  assert.equal((await readShownFacts(page, '#measures'))['Points'], '2');
  await press('Escape');
  assert.equal(await page.locator('#tool-measure').isVisible(), false);
  assert.ok(await page.evaluate((s) => document.activeElement?.matches(s), opener('measure')));

  // Without a tool, the facts of the point in the middle.
  await tabTo(page, '#picture', 'Shift+Tab');
  await press('Enter');
  await tabTo(page, '#close');
  await press('Enter');
  assert.equal(await page.locator('#place').isVisible(), false);
  assert.ok(await page.evaluate(() => document.activeElement?.id === 'picture'));

  // A profile, and along its chart.
  await tabTo(page, opener('profile'));
  await press('Enter');
  await tabTo(page, await findButton(page, 'profile', 'Add middle of picture'));
  await press('Enter');
  await lookAside(page, -6, /&profile=/);
  await press('Enter');
  await page.locator('.plot svg .surface').first().waitFor({ state: 'attached' });
  await tabTo(page, '.plot');
  const words = (): Promise<string | null> => page.locator('.plot').getAttribute('aria-valuetext');
  const first = await words();
  assert.match(first!, /^at 0\.0 m: -?[\d.]+ k?m high$/);
  await press('End');
  assert.notEqual(await words(), first);
  assert.equal(await page.locator('.readout').textContent(), await words());
  await screenshot(page, 'tools-profile');
  const csv = page.waitForEvent('download');
  await tabTo(page, '#tool-profile div p button');
  await press('Enter');
  const table = readFileSync(await (await csv).path(), 'utf8')
    .trimEnd()
    .split('\r\n');
  assert.equal(table[0], 'easting,northing,distance_m,height_m,level_m');
  assert.ok(table.length > 2);
  for (const row of table.slice(1)) assert.match(row, /^[-\d.]+,[-\d.]+,[\d.]+,[-\d.]*,[\d.]*$/);
  await press('Escape');

  // A section plane: its kind, azimuth, position, the other side.
  await tabTo(page, opener('section'), 'Shift+Tab');
  await press('Enter');
  await tabTo(page, '#tool-section select');
  await press('ArrowDown');
  await linkHas(page, /&section=v,[\d.]+,[-\d.]+,0&tool=section$/);
  const plane = page.url();
  await tabTo(page, '#tool-section input');
  await press('ArrowRight');
  await until('the slider turns the plane', () => page.url() !== plane);
  await tabTo(page, await findButton(page, 'section', 'Flip'));
  await press('Enter');
  await linkHas(page, /&section=v,[\d.]+,[-\d.]+,1&/);
  await screenshot(page, 'tools-section');
  await tabTo(page, '#tool-section select', 'Shift+Tab');
  await press('ArrowUp');
  await until('there is no plane', () => !page.url().includes('section=v'));
  await press('Escape');

  // A line of sight.
  await tabTo(page, opener('sight'));
  await press('Enter');
  await tabTo(page, await findButton(page, 'sight', 'Set middle of picture'));
  await press('Enter');
  await linkHas(page, /&observer=[-\d.]+,[-\d.]+,[-\d.]+,1\.7&/);
  await lookAside(page, 3, /&observer=/);
  await press('Enter');
  await linkHas(page, /&target=/);
  assert.match((await page.locator('#sight').textContent())!, /^The observer (sees|does not see)/);
  await screenshot(page, 'tools-sight');
  await tabTo(page, await findButton(page, 'sight', 'Clear'));
  await press('Enter');
  await press('Escape');

  // Layers with their legends, and a range of heights.
  await tabTo(page, opener('layers'));
  await press('Enter');
  await tabTo(page, '#tool-layers select');
  await press('ArrowDown');
  await linkHas(page, /&layer=height&tool=layers$/);
  await tabTo(page, '#tool-layers input');
  await page.keyboard.type('7');
  await press('Tab');
  await linkHas(page, /&range=[-\d.]+,[-\d.]+&/);
  await screenshot(page, 'tools-layers');
  await tabTo(page, '#tool-layers select', 'Shift+Tab');
  await press('ArrowDown');
  await linkHas(page, /&layer=material&/);
  assert.ok((await page.locator('.legend li').count()) > 1);
  for (let i = 0; i < 2; ++i) await press('ArrowUp');
  await press('Escape');

  // The sun's path.
  await tabTo(page, opener('sun'));
  await press('Enter');
  await linkHas(page, /&sun=1&tool=sun$/);
  assert.match((await readShownFacts(page, '#sun-facts'))['Sunrise']!, /^\d\d:\d\d, azimuth \d+°$/);
  await tabTo(page, await findButton(page, 'sun', 'Turn to the sun'));
  await press('Enter');
  await screenshot(page, 'tools-sun');
  await end();
});

/** Pixels that are drawn over the picture. */
const drawnOver = (page: Page): Promise<number> =>
  page.evaluate(() => {
    const canvas = document.querySelector<HTMLCanvasElement>('#overlay');
    if (canvas === null) return 0;
    const copy = document.createElement('canvas');
    copy.width = canvas.width;
    copy.height = canvas.height;
    const context = copy.getContext('2d', { willReadFrequently: true })!;
    context.drawImage(canvas, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    return data.filter((v, i) => i % 4 === 3 && v > 0).length;
  });

test('a link brings back what was seen, and a wrong one nothing', { skip: noBrowser }, async () => {
  const made = await open(kWide);
  assert.equal(await drawnOver(made.page), 0);
  await made.page.click(opener('measure'));
  await made.page.mouse.click(600, 450);
  await made.page.mouse.click(750, 520);
  await linkHas(made.page, /&measure=[-\d.,]+_[-\d.,]+&/);
  await made.page.locator('summary').click();
  await made.page.locator('#textures').uncheck();
  await linkHas(made.page, /&textures=0&measure=/);
  await made.page.click(opener('layers'));
  await made.page.locator('#tool-layers select').selectOption('height');
  await linkHas(made.page, /&layer=height&tool=layers$/);
  const link = made.page.url();
  const over = await drawnOver(made.page);
  assert.ok(over > 100, String(over));

  // The picture as a file has the points, and the names of the sources.
  const saved = made.page.waitForEvent('download');
  await made.page.locator('#save').click();
  const png = readFileSync(await (await saved).path()).toString('base64');
  const colours = await made.page.evaluate(async (data) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = document.createElement('canvas');
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext('2d', { willReadFrequently: true })!;
    context.drawImage(image, 0, 0);
    const count = (
      x: number,
      y: number,
      isIt: (r: number, g: number, b: number) => boolean,
    ): number => {
      const { data: p } = context.getImageData(x, y, image.width - x, image.height - y);
      let found = 0;
      for (let i = 0; i < p.length; i += 4) if (isIt(p[i]!, p[i + 1]!, p[i + 2]!)) ++found;
      return found;
    };
    return {
      points: count(0, 0, (r, g, b) => r > 250 && Math.abs(g - 225) < 4 && Math.abs(b - 77) < 4),
      credit: count(image.width - 60, image.height - 18, (r, g, b) => r + g + b > 720),
    };
  }, png);
  assert.ok(colours.points > 50, `${colours.points} pixels of points`);
  assert.ok(colours.credit > 20, `${colours.credit} pixels of the credit`);
  await made.end();

  const followed = await open(kWide, '', new URL(link).hash);
  await until('it is drawn', async () => (await drawnOver(followed.page)) > 100);
  assert.equal(followed.page.url(), link);
  assert.equal(await followed.page.locator('#textures').isChecked(), false);
  assert.equal(await followed.page.locator('#tool-layers').isVisible(), true);
  // In the same page: an old link has no tools.
  const old = new URL(link).hash.replace(/&textures.*/, '');
  await followed.page.evaluate((hash) => (location.hash = hash), old);
  await until(
    'the tools are as at the beginning',
    async () => (await drawnOver(followed.page)) === 0,
  );
  assert.equal(new URL(followed.page.url()).hash, old);
  await followed.end();

  const words = 'measure=1,2&profile=x_y&section=v,9,9&layer=zz&range=9,1&observer=1&sun=<b>&a=5';
  const strange = `${old}&${words}`;
  const stranger = await open(kWide, '', strange);
  await until('only what is known stays', () => new URL(stranger.page.url()).hash === old);
  await stranger.end();
});

/** Texts whose contrast is too low over black or over white, and the number of those looked at. */
const lowContrast = (page: Page, min: number): Promise<{ seen: number; low: string[] }> =>
  page.evaluate((least) => {
    type Rgba = readonly [number, number, number, number];
    const read = (text: string): Rgba => {
      const v = text.match(/[\d.]+/g)!.map(Number);
      return [v[0]!, v[1]!, v[2]!, v[3] ?? 1];
    };
    const over = (top: Rgba, below: Rgba): Rgba => {
      const mix = (i: 0 | 1 | 2): number => top[i] * top[3] + below[i] * (1 - top[3]);
      return [mix(0), mix(1), mix(2), 1];
    };
    const luminance = ([r, g, b]: Rgba): number => {
      const linear = [r, g, b].map((v) => {
        const s = v / 255;
        return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
      });
      return 0.2126 * linear[0]! + 0.7152 * linear[1]! + 0.0722 * linear[2]!;
    };
    const contrast = (a: Rgba, b: Rgba): number => {
      const [high, low] = [luminance(a), luminance(b)].sort((x, y) => y - x);
      return (high! + 0.05) / (low! + 0.05);
    };
    const behind = (start: Element, picture: Rgba): Rgba => {
      const layers: Rgba[] = [];
      for (let at: Element | null = start; at !== null; at = at.parentElement) {
        layers.push(read(getComputedStyle(at).backgroundColor));
        // The picture lies under the panel and the attribution.
        if (at.matches('main, #attribution')) break;
      }
      return layers.reverse().reduce((below, top) => over(top, below), picture);
    };
    const low: string[] = [];
    let seen = 0;
    for (const target of document.querySelectorAll('body *')) {
      const hasText = [...target.childNodes].some(
        (node) => node.nodeType === Node.TEXT_NODE && node.textContent!.trim() !== '',
      );
      const isField = target.matches('input:not([type=range], [type=checkbox])');
      if ((!hasText && !isField) || !target.checkVisibility() || target.matches('option')) continue;
      ++seen;
      const style = getComputedStyle(target);
      const colours = [style[target instanceof SVGElement ? 'fill' : 'color']];
      if (isField) colours.push(getComputedStyle(target, '::placeholder').color);
      for (const colour of colours) {
        for (const shade of [0, 255]) {
          const ratio = contrast(read(colour), behind(target, [shade, shade, shade, 1]));
          if (ratio < least) {
            low.push(`${target.tagName} "${target.textContent.slice(0, 30)}": ${ratio.toFixed(2)}`);
          }
        }
      }
    }
    return { seen, low };
  }, min);

/** Roles that people act on, and their names as assistive technology hears them. */
async function listNames(page: Page): Promise<(readonly [string, string])[]> {
  const session = await page.context().newCDPSession(page);
  const { nodes } = await session.send('Accessibility.getFullAXTree');
  const roles =
    /^(button|(text|search|combo|check)box|slider|spinbutton|link|application|Date|InputTime)$/;
  return nodes
    .filter((node) => node.ignored !== true && roles.test(String(node.role?.value)))
    .map((node) => [String(node.role!.value), String(node.name?.value ?? '')] as const);
}

test('texts are legible, inputs have names, the language is one', { skip: noBrowser }, async () => {
  const { page, end } = await open(kWide, '?lang=sl');
  await page.locator('summary').click();
  // Something of everything: points, a profile, the facts of a point, a message.
  await page.click(opener('profile'));
  await page.mouse.click(600, 400);
  await page.mouse.click(760, 430);
  await page.locator('.plot svg .surface').first().waitFor({ state: 'attached' });
  await page.fill('#search-text', 'x');
  await page.press('#search-text', 'Enter');
  assert.equal(await page.getAttribute('html', 'lang'), 'sl');
  for (const theme of ['light', 'dark'] as const) {
    await page.emulateMedia({ colorScheme: theme });
    for (const tool of [...kTools, undefined]) {
      if (tool !== undefined) await page.click(opener(tool));
      else {
        await page.keyboard.press('Escape');
        await page.mouse.click(600, 450);
        await page.locator('#place').waitFor({ state: 'visible' });
      }
      if (tool === 'layers') await page.locator('#tool-layers select').selectOption('material');
      const { seen, low } = await lowContrast(page, kMinContrast);
      assert.ok(seen > 20, `${seen} texts`);
      assert.deepEqual(low, [], `${theme}, ${tool}`);
      await screenshot(page, `tools-${tool ?? 'facts'}-${theme}`);
      if (theme === 'dark') continue;
      const names = await listNames(page);
      assert.ok(names.length > 15, `${names.length} inputs`);
      assert.deepEqual(
        names.filter(([, name]) => name.trim() === ''),
        [],
        tool,
      );
    }
    await page.locator('#close').click();
  }
  const shown = await page.locator('body').innerText();
  for (const word of ['Tools', 'Measure', 'Sun', 'Save', 'Picture', 'Height']) {
    assert.ok(!shown.includes(word), `English in the Slovene page: ${word}`);
  }
  await end();
});

test('light and dark follow the system, or the address', { skip: noBrowser }, async () => {
  const { page, end } = await open({ ...kWide, colorScheme: 'dark', reducedMotion: 'reduce' });
  const scheme = (): Promise<string> =>
    page.evaluate(() => getComputedStyle(document.documentElement).colorScheme);
  assert.equal(await scheme(), 'dark');
  await page.emulateMedia({ colorScheme: 'light' });
  assert.equal(await scheme(), 'light');
  const moving = await page.evaluate(() => document.getAnimations().length);
  assert.equal(moving, 0);
  await end();
});

test('what goes wrong is said in the language of the page', { skip: noBrowser }, async () => {
  const context = await browser!.newContext({ locale: 'sl-SI' });
  const page = await context.newPage();
  await page.route('**/place.tvx', (route) => route.fulfill({ status: 404 }));
  await page.goto(kSite);
  await until('it is said', async () => (await page.locator('#status.trouble').count()) === 1);
  const said = (await page.locator('#status').textContent())!;
  assert.match(said, /^Na strežniku manjka datoteka tega kraja\./);
  assert.match((await page.locator('#status small[lang=en]').textContent())!, /404/);
  // The panel works all the same.
  await page.click('#fold');
  assert.equal(await page.locator('#panel').isVisible(), false);
  assert.equal(await page.locator('#status').isVisible(), true);
  await context.close();
});

/** What lies on top in the middle of an element. */
const isOnTop = (page: Page, selector: string): Promise<boolean> =>
  page.evaluate((s) => {
    const box = document.querySelector(s)!.getBoundingClientRect();
    const seen = document.elementFromPoint(box.left + box.width / 2, box.top + box.height / 2);
    return seen?.matches(s) === true;
  }, selector);

test('a phone shows the place above the panel, for fingers', { skip: noBrowser }, async () => {
  const { page, end } = await open(kPhone);
  assert.equal(await page.locator('#panel').isVisible(), false);
  assert.ok(await isOnTop(page, '#attribution'));
  await page.tap('#fold');
  assert.equal(await page.locator('#panel').isVisible(), true);
  assert.ok(await isOnTop(page, '#attribution'));
  const [picture, sheet] = await Promise.all(
    ['#picture', 'main'].map((s) => page.locator(s).boundingBox()),
  );
  assert.ok(picture!.y + picture!.height <= sheet!.y + 0.5, 'the sheet covers the picture');
  assert.ok(picture!.height >= 0.45 * kPhone.viewport.height, `${picture!.height} px`);
  await page.locator('summary').tap();
  for (const tool of kTools) {
    await page.locator(opener(tool)).tap();
    await page.locator(`#tool-${tool}`).waitFor({ state: 'visible' });
    const small = await page.evaluate((least) => {
      const targets = 'button, select, summary, a, input, .plot';
      return [...document.querySelectorAll(targets)]
        .filter((target) => target.checkVisibility())
        .map((target) => target.closest('label') ?? target)
        .map((target) => ({ target, height: target.getBoundingClientRect().height }))
        .filter(({ height }) => height < least - 0.01)
        .map(({ target, height }) => `${target.textContent}: ${height}`);
    }, kMinTouchPx);
    assert.deepEqual(small, [], tool);
    await screenshot(page, `tools-${tool}-phone`);
  }
  // Nothing is wider than the window.
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth));
  await page.locator(opener('sun')).tap();
  await page.touchscreen.tap(195, 330);
  await page.locator('#place').waitFor({ state: 'visible' });
  await screenshot(page, 'tools-facts-phone');
  await end();
});

test('two fingers turn the view around what lies between them', { skip: noBrowser }, async () => {
  const { page, end } = await open(kPhone);
  const look = async (): Promise<readonly number[]> => {
    await page.waitForFunction(() => location.hash.includes('look='));
    return /look=([-\d.,]+)/.exec(new URL(page.url()).hash)![1]!.split(',').map(Number);
  };
  const client = await page.context().newCDPSession(page);
  const touch = (type: 'touchStart' | 'touchMove' | 'touchEnd', ...at: [number, number][]) =>
    client.send('Input.dispatchTouchEvent', {
      type,
      touchPoints: at.map(([x, y], id) => ({ x, y, id })),
    });
  const [heading, pitch] = await look();
  await touch('touchStart', [145, 200], [245, 200]);
  const kSteps = 9;
  for (let i = 1; i <= kSteps; ++i) {
    const angle = (Math.PI / 2) * (i / kSteps);
    const [x, y] = [50 * Math.cos(angle), 50 * Math.sin(angle)];
    await touch('touchMove', [195 - x, 200 - y], [195 + x, 200 + y]);
  }
  await touch('touchEnd');
  // The address follows when the picture has stood still for a moment.
  await until('the address has turned', async () => {
    const turned = (heading! - (await look())[0]! + 360) % 360;
    return turned > 60 && turned < 100;
  });
  assert.equal((await look())[1], pitch);
  await end();
});

test('an embedded page hides its panel, and never its sources', { skip: noBrowser }, async () => {
  const frame = {
    viewport: { width: 640, height: 400 },
    permissions: ['clipboard-read', 'clipboard-write'],
  };
  const { page, end } = await open(frame, '?embed=1&controls=none&theme=dark');
  assert.equal(await page.locator('#panel').isVisible(), false);
  assert.ok(await isOnTop(page, '#attribution'));
  assert.equal(
    await page.evaluate(() => getComputedStyle(document.documentElement).colorScheme),
    'dark',
  );
  await screenshot(page, 'embed');
  const before = page.url();
  await page.mouse.move(400, 200);
  await page.mouse.down();
  await page.mouse.move(300, 240, { steps: 4 });
  await page.mouse.up();
  await page.mouse.wheel(0, -300);
  await page.locator('#picture').focus();
  await page.keyboard.press('ArrowLeft', { delay: 200 });
  await page.waitForTimeout(900);
  assert.equal(
    page.url().replace(/.*#/, ''),
    before.replace(/.*#/, ''),
    'nothing moves the picture',
  );
  await page.click('#fold');
  assert.equal(await page.locator('#panel').isVisible(), true);
  assert.ok(await isOnTop(page, '#attribution'));
  await page.locator('#embed').click();
  await page.waitForFunction(() => document.querySelector('#embed')!.textContent === 'Code copied');
  const code = await page.evaluate(() => navigator.clipboard.readText());
  assert.match(
    code,
    /^<iframe src="http[^"]*\?embed=1#at=[^"]*" title="[^"]+" width="\d+" height="\d+"/,
  );
  const own = page.context().waitForEvent('page');
  await page.locator('#own-page').click();
  const opened = await own;
  await opened.waitForURL(/#at=/);
  assert.equal(new URL(opened.url()).search, '');
  await end();
});
