// Errors: a token, a server that is away or busy, malicious texts. Needs a server that does so: the
// fake one.
import assert from 'node:assert/strict';
import { after, before, beforeEach, describe, test } from 'node:test';
import type { Browser } from 'playwright-core';
import {
  coloursOnMap,
  noBrowser,
  openBrowser,
  openPage,
  screenshot,
  readShownText,
  until,
  untilText,
} from './support/browser.js';
import { FakeServer } from './support/fake-server.js';

// The browser itself logs to its console that a request failed: that is no error of the page.
const ownErrors = (errors: readonly string[]): string[] =>
  errors.filter((text) => !/Failed to load resource/.test(text));

describe('the page in trouble', { skip: noBrowser }, () => {
  let fake: FakeServer;
  let browser: Browser;
  before(async () => void (browser = await openBrowser()));
  after(() => browser?.close());
  beforeEach(async (context) => {
    fake = await new FakeServer().open();
    if ('after' in context) context.after(() => fake.close());
  });

  test('the page asks for a token, reports a wrong one, sends the right one with all', async () => {
    fake.token = 'right';
    const { page, errors } = await openPage(browser, fake.url);
    await untilText(page, '#status', /requires a token/);
    await screenshot(page, 'token');
    assert.equal(await page.evaluate(() => document.activeElement?.id), 'token-text');
    await page.keyboard.type('wrong');
    await page.keyboard.press('Enter');
    await untilText(page, '#status', /does not take this token/);
    await page.getByLabel('Token', { exact: true }).fill('right');
    await page.getByRole('button', { name: 'Use it' }).click();
    await untilText(page, '#status', /is up/);
    await until('tiles are drawn', async () => (await coloursOnMap(page)) > 5);
    assert.equal(await page.locator('#token').isVisible(), false);
    await page.reload();
    await untilText(page, '#status', /is up/);
    fake.token = 'another';
    await untilText(page, '#status', /requires a token/);
    await page.getByLabel('Token', { exact: true }).fill('another');
    await page.keyboard.press('Enter');
    await untilText(page, '#status', /is up/);
    assert.deepEqual(ownErrors(errors), []);
    await page.context().close();
  });

  test('the page reports a server that goes away, and finds it again', async () => {
    const { page, errors } = await openPage(browser, fake.url);
    await until('the map is drawn', async () => (await coloursOnMap(page)) > 5);
    fake.close();
    await untilText(page, '#status', /does not answer/);
    await screenshot(page, 'gone');
    assert.ok((await coloursOnMap(page)) > 5, 'what was drawn stays');
    fake.squares = fake.squares.slice(0, 1);
    await fake.open();
    await untilText(page, '#status', /is up/);
    await untilText(page, '#squares', /1 in all/);
    await until('the map is drawn again', async () => (await coloursOnMap(page)) > 5);
    assert.deepEqual(ownErrors(errors), []);
    await page.context().close();
  });

  test('another world in its place starts the page anew', async () => {
    const { page } = await openPage(browser, fake.url);
    await untilText(page, '#title', /Synthetic hills/);
    fake.close();
    await untilText(page, '#status', /does not answer/);
    fake.title = 'Other hills';
    await fake.open();
    await untilText(page, '#title', /Other hills/);
    await page.context().close();
  });

  test('the page reports a busy server, and finds it again', async () => {
    const { page, errors } = await openPage(browser, fake.url);
    await untilText(page, '#status', /is up/);
    fake.busy = true;
    await untilText(page, '#status', /too busy/);
    await page.locator('#map').focus();
    await page.keyboard.press('Enter');
    await untilText(page, '.command .note', /could not be loaded/);
    fake.busy = false;
    await untilText(page, '#status', /is up/);
    assert.deepEqual(ownErrors(errors), []);
    await page.context().close();
  });

  test('a result that cannot be read leaves no other on the map', async () => {
    fake.jobHoles = true;
    const { page, errors } = await openPage(browser, fake.url);
    const holes = 'Some data could not be read: cells without colour have no value';
    const note = '#analysis-result .note';
    const choose = (label: string): Promise<unknown> =>
      page.getByLabel('Shown', { exact: true }).selectOption({ label });
    const compute = page.getByRole('button', { name: 'Compute what the map shows' });
    await compute.click();
    await untilText(page, '#analysis-result .ends', /h$/);
    await untilText(page, note, new RegExp(`^${holes}\\.$`));
    fake.rasterFails = true;
    await compute.click();
    await untilText(page, '#analysis-state', /no such disk/);
    assert.equal(await page.locator('#analysis-result').isVisible(), false);
    fake.rasterFails = false;
    await compute.click();
    await untilText(page, '#analysis-result .ends', /h$/);
    await choose('Data that could not be read');
    await untilText(page, note, new RegExp(`^${holes}, or are: read\\.$`));
    await untilText(page, '#analysis-result .ends', /^could not be read$/);
    assert.deepEqual(ownErrors(errors), []);
    await page.context().close();
  });

  test('malicious texts stay texts', async () => {
    const harm = '<img src=x onerror="alert(1)"><script>alert(2)</script>';
    fake.title = `T ${harm}`;
    fake.stepName = `S ${harm}`;
    fake.squares = [
      { name: `N ${harm}`, state: 'failed', licence: `L ${harm}`, error: `E ${harm}` },
    ];
    const { page, errors, foreign } = await openPage(browser, fake.url);
    await untilText(page, '#squares', /N <img/);
    await untilText(page, '#steps', /S <img/);
    await page.getByRole('button', { name: harm }).click();
    await untilText(page, '#place', /L <img/);
    assert.equal(await readShownText(page, '#title'), `T ${harm}`);
    await until(
      'there is a command',
      async () => (await page.locator('#command').inputValue()) !== '',
    );
    assert.match(
      await page.locator('#command').inputValue(),
      /-o N-img-src-x-onerror-alert-1-script-alert-2-script\.png$/,
    );
    assert.equal(
      await page.evaluate(
        () => document.querySelectorAll('img, main script, header script').length,
      ),
      0,
    );
    assert.deepEqual([errors, foreign], [[], []]);
    await page.context().close();
  });
});
