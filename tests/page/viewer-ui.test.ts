import assert from 'node:assert/strict';
import { copyFileSync, mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import type { Vec3 } from '../../voxelserver/serve/page/src/vec3.js';
import {
  fromLink,
  kMaxPoints,
  pointsWord,
  readPoint,
  readPoints,
  toLink,
  parseWords,
} from '../../voxelserver/serve/page/src/viewer/ui/link.js';
import {
  toCamera,
  fitted,
  type Viewpoint,
} from '../../voxelserver/serve/page/src/viewer/ui/navigation.js';
import {
  lengthDecimals,
  numberText,
} from '../../voxelserver/serve/page/src/viewer/ui/number-text.js';
import { embedCode, readOptions } from '../../voxelserver/serve/page/src/viewer/ui/options.js';
import { coveredShare } from '../../voxelserver/serve/page/src/viewer/ui/panel.js';
import {
  className,
  kLanguages,
  kTextKeys,
  chooseLanguage,
  materialName,
  text,
  type Say,
  type TextKey,
} from '../../voxelserver/serve/page/src/viewer/ui/texts.js';
import { noBrowser, openBrowser, openPage, screenshot, untilText } from './support/browser.js';
import { makeShare } from './support/test-bytes.js';

declare const TERRAVOX_PAGE_DIST: string;

const english: Say = (key: TextKey, ...values: readonly string[]) => text('en', key, ...values);

const kView: Viewpoint = { position: [10, 20, -30], headingDeg: 40, pitchDeg: -10, fovDeg: 42 };

// --- Texts

test('every text is there in every language, with the same values', () => {
  const values = ['1', '2', '3'];
  const named = (language: (typeof kLanguages)[number], key: TextKey): string[] =>
    [...text(language, key, '¤1', '¤2').matchAll(/¤\d/g)].map(([v]) => v).sort();
  for (const key of kTextKeys) {
    for (const language of kLanguages) {
      assert.notEqual(text(language, key, ...values).trim(), '', `${language}: ${key}`);
      assert.deepEqual(named(language, key), named('en', key), `${language}: ${key}`);
    }
  }
});

test('Slovene has a form for one, two, a few and many', () => {
  const said = [1, 2, 3, 4, 5, 101, 102].map((n) => text('sl', 'refining', String(n)));
  assert.deepEqual(said, [
    'Ostrim: manjka še 1 stolpec',
    'Ostrim: manjkata še 2 stolpca',
    'Ostrim: manjkajo še 3 stolpci',
    'Ostrim: manjkajo še 4 stolpci',
    'Ostrim: manjka še 5 stolpcev',
    'Ostrim: manjka še 101 stolpec',
    'Ostrim: manjkata še 102 stolpca',
  ]);
  assert.equal(text('en', 'refining', '1'), 'Refining: 1 column to come');
  assert.equal(text('en', 'refining', '2'), 'Refining: 2 columns to come');
});

test('names that no table knows are shown as they are', () => {
  assert.equal(className(english, 2), 'Ground');
  assert.equal(className(english, 64), 'Class 64');
  assert.equal(materialName(english, 'grey_roof'), 'grey roof');
  assert.equal(materialName(english, 'minecraft_stone'), 'minecraft stone');
  assert.equal(chooseLanguage(['de-AT', 'sl-SI', 'en']), 'sl');
});

// --- Numbers

test('measures have the digits that the voxels justify', () => {
  const cases: readonly (readonly [number, number])[] = [
    [10, 0],
    [1, 1],
    [0.5, 1],
    [0.25, 1],
    [0.05, 2],
    [0.001, 3],
  ];
  for (const [voxelM, decimals] of cases) {
    assert.equal(lengthDecimals(voxelM), decimals, `voxels of ${voxelM} m`);
  }
  const numbers = numberText('en', 0.5);
  assert.equal(numbers.length(12.34), '12.3 m');
  assert.equal(numbers.length(-0.01), '0.0 m');
  assert.equal(numbers.length(12_345.6), '12.346 km');
  assert.equal(numbers.area(50), '50.0 m²');
  assert.equal(numbers.area(5000.4), '5000 m²');
  assert.equal(numbers.area(12_345), '1.23 ha');
  assert.equal(numbers.area(2_345_678), '2.346 km²');
  assert.equal(numberText('sl', 0.5).length(12.34), '12,3 m');
});

// --- Links

const kState = { view: kView, timeMs: Date.UTC(2026, 5, 21, 15, 30) };

test('a link carries the words of tools, and old links have none', () => {
  const points: readonly Vec3[] = [
    [1.25, 2, -3],
    [462_080, 640.5, -101_080],
  ];
  const link = toLink(kState, { measure: pointsWord(points), sun: '1' });
  assert.deepEqual(fromLink(link, { ...kState, timeMs: 0 }), kState);
  assert.deepEqual(readPoints(parseWords(link).get('measure')), points);
  assert.equal(parseWords(link).get('sun'), '1');
  assert.match(link, /^#[\w=&.,-]+$/, 'nothing that an address would have to escape');
  assert.deepEqual([...parseWords(toLink(kState))], []);
});

test('points of a link are bounded in number and place', () => {
  const many = (count: number): string =>
    pointsWord(Array.from({ length: count }, () => [1, 2, 3]));
  assert.equal(readPoints(many(kMaxPoints)).length, kMaxPoints);
  for (const bad of [
    many(kMaxPoints + 1),
    '',
    '_',
    '1,2',
    '1,2,3_4,5',
    '1,2,x',
    '1,2,3e40',
    'NaN,1,2',
  ]) {
    assert.deepEqual(readPoints(bad), [], bad.slice(0, 40));
  }
  assert.deepEqual(readPoints(null), []);
  assert.equal(readPoint('1,2,3,4'), undefined);
});

// --- Options and embedding

test('the address chooses how an embedded page looks', () => {
  const plain = readOptions('', ['sl-SI']);
  assert.deepEqual(plain, {
    isEmbedded: false,
    panel: undefined,
    hasControls: true,
    language: 'sl',
    theme: undefined,
  });
  const all = readOptions('?embed=1&panel=open&controls=none&lang=en&theme=dark', ['sl-SI']);
  assert.deepEqual(all, {
    isEmbedded: true,
    panel: 'open',
    hasControls: false,
    language: 'en',
    theme: 'dark',
  });
  assert.equal(readOptions('?panel=closed', []).panel, 'closed');
  const strange = readOptions('?embed=yes&panel=x&controls=&lang=xx&theme=<b>&a=1', ['sl']);
  assert.deepEqual(strange, plain);
});

test('the embed code holds the view, and no title can leave its attribute', () => {
  const code = embedCode(
    'https://a.example/place/?embed=0&x=1#old',
    toLink(kState, { sun: '1' }),
    'A "castle" <b> & lake',
  );
  assert.match(code, /^<iframe src="https:\/\/a\.example\/place\/\?embed=1#at=/);
  assert.match(code, /&amp;sun=1" title="A &quot;castle&quot; &lt;b&gt; &amp; lake" /);
  assert.equal(code.match(/[<>]/g)!.length, 4);
});

test('a whole place fits beside a panel, in any direction', () => {
  const random = makeShare(7);
  const between = (low: number, high: number): number => low + (high - low) * random();
  for (let i = 0; i < 200; ++i) {
    const view: Viewpoint = {
      position: [0, 0, 0],
      headingDeg: between(0, 360),
      pitchDeg: between(-89, 60),
      fovDeg: between(10, 100),
    };
    const min: Vec3 = [between(-1e5, 1e5), between(-500, 3000), between(-1e5, 1e5)];
    const max: Vec3 = [
      min[0] + between(1, 5000),
      min[1] + between(1, 900),
      min[2] + between(1, 5000),
    ];
    const covered = between(0, 0.6);
    const aspect = between(0.4, 3);
    const found = fitted(view, { min, max }, aspect, covered);
    assert.deepEqual({ ...found, position: view.position }, view);
    const { forward, right, up } = toCamera(found);
    const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const half = Math.hypot(...right) ** 2;
    let [touches, isInside] = [false, true];
    for (let corner = 0; corner < 8; ++corner) {
      const d = [0, 1, 2].map(
        (a) => (((corner >> a) & 1) === 0 ? min : max)[a]! - found.position[a]!,
      ) as unknown as Vec3;
      const depth = dot(d, forward);
      const x = dot(d, right) / half / depth / aspect;
      const y = dot(d, up) / half / depth;
      const shares = [((x + 1) / 2 - covered) / (1 - covered), (y + 1) / 2];
      isInside &&= depth > 0 && shares.every((v) => v > 0.04 - 1e-6 && v < 0.96 + 1e-6);
      touches ||= shares.some((v) => v < 0.04 + 1e-6 || v > 0.96 - 1e-6);
    }
    assert.ok(isInside && touches, `${i}: ${JSON.stringify({ view, min, max, covered, aspect })}`);
  }
});

test('a panel covers the left of the picture, unless it lies below or leaves little', () => {
  const wide = { left: 0, top: 0, right: 1280, bottom: 800 };
  assert.equal(coveredShare(wide, { left: 10, top: 10, right: 320, bottom: 700 }), 0.25);
  assert.equal(coveredShare(wide, { left: 0, top: 800, right: 1280, bottom: 1200 }), 0);
  assert.equal(coveredShare(wide, { left: 0, top: 0, right: 0, bottom: 0 }), 0);
  assert.equal(coveredShare(wide, { left: 0, top: 0, right: 1000, bottom: 700 }), 0);
});

test(
  'a page that is opened from a disk says how to see its place',
  { skip: noBrowser },
  async () => {
    const folder = mkdtempSync(join(tmpdir(), 'terravox site '));
    const browser = await openBrowser();
    try {
      mkdirSync(join(folder, 'viewer'));
      copyFileSync(join(TERRAVOX_PAGE_DIST, 'viewer.html'), join(folder, 'index.html'));
      for (const name of ['viewer.js', 'worker.js', 'viewer.css']) {
        copyFileSync(join(TERRAVOX_PAGE_DIST, name), join(folder, 'viewer', name));
      }
      const { page, errors } = await openPage(
        browser,
        pathToFileURL(join(folder, 'index.html')).href,
      );
      const said = await untilText(page, '#status', /disk/);
      assert.match(said, /terravox view FOLDER/);
      assert.ok(await page.locator('#status').isVisible());
      assert.ok(!(await page.locator('#from-disk').isVisible()), 'it is said once');
      assert.ok(!(await page.locator('#panel').isVisible()), 'there is nothing to choose');
      await screenshot(page, 'from-disk');
      assert.deepEqual(errors, []);
    } finally {
      await browser.close();
      rmSync(folder, { recursive: true });
    }
  },
);
