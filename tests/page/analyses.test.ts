import assert from 'node:assert/strict';
import { test } from 'node:test';
import { toCaption } from '../../voxelserver/serve/page/src/analysis-form.js';
import {
  colourlessText,
  readStyle,
  valueText,
  type BandStyle,
} from '../../voxelserver/serve/page/src/band-styles.js';
import { toColour, paint, chooseScale } from '../../voxelserver/serve/page/src/colour-scale.js';
import {
  toBody,
  countCells,
  makeFileName,
  readJob,
  resolutionFor,
  type Analysis,
  type Wish,
} from '../../voxelserver/serve/page/src/jobs.js';
import { openRaster } from '../../voxelserver/serve/page/src/raster.js';
import { kNoData, makeRaster } from './support/make-raster.js';
import { makeShare } from './support/test-bytes.js';

/** Metadata of bands as the server's rasters have them. */
const kBands: Readonly<Record<string, Readonly<Record<string, string>>>> = {
  dsm: { title: 'Height of the surface', ramp: 'heights' },
  ndsm: { title: 'Height above the ground', ramp: 'much', low: '0' },
  aspect: { title: 'Aspect', ramp: 'around', low: '0', high: '360' },
  svf: { title: 'Sky-view factor', ramp: 'much', low: '0', high: '1' },
  openness: { title: 'Openness', ramp: 'much', low: '0', high: '90' },
  sun_hours: { title: 'Hours of direct sun', ramp: 'warm', low: '0' },
  first_sun: { title: 'First sun, clock time', ramp: 'much', form: 'clock' },
  kwh_m2: { title: 'Energy of sun and sky', ramp: 'warm', low: '0' },
  seen: { title: 'Observers', ramp: 'much', low: '0', words: 'not seen|seen' },
  hole: { title: 'Holes', ramp: 'much', low: '0', high: '1', words: 'read|not read' },
};

function styleOf(band: string): BandStyle {
  const items = Object.entries(kBands[band]!).map(([name, text]) => [`terravox_${name}`, text]);
  return readStyle(Object.fromEntries(items) as Record<string, string>)!;
}

test('a band is drawn as its raster says, or not at all', () => {
  assert.deepEqual(styleOf('seen'), {
    title: 'Observers',
    ramp: 'much',
    low: 0,
    words: ['not seen', 'seen'],
  });
  assert.deepEqual(styleOf('first_sun'), {
    title: 'First sun, clock time',
    ramp: 'much',
    isClock: true,
  });
  const cases: readonly [string, Record<string, string>][] = [
    ['no title', { DESCRIPTION: 'red' }],
    ['no colours', { terravox_title: 'Red' }],
    ['colours of classes', { terravox_title: 'Material', terravox_ramp: 'materials' }],
    ['colours of another one', { terravox_title: 'Red', terravox_ramp: 'toString' }],
  ];
  for (const [name, about] of cases) assert.equal(readStyle(about), undefined, name);
});

test('a raster is read: place, bands, values of each', async () => {
  const [width, height] = [37, 21];
  const next = makeShare(width);
  const values = (scale: number): number[] =>
    Array.from({ length: width * height }, () =>
      next() < 0.1 ? kNoData : Math.fround((next() - 0.5) * scale),
    );
  const bands = [
    { name: 'sun_hours', unit: 'h', about: kBands['sun_hours']!, values: values(30) },
    { name: 'first_sun', unit: 'h', about: kBands['first_sun']!, values: values(1e6) },
    { name: 'red', unit: '', values: values(1) },
  ];
  const made = { width, height, tile: 16, bands, west: 462400, north: 101600, cell: 0.5 };
  const raster = await openRaster(new Blob([new Uint8Array(makeRaster(made))]));
  assert.deepEqual(raster.extent, [462400, 101600 - 21 / 2, 462400 + 37 / 2, 101600]);
  assert.deepEqual(
    raster.bands.map(({ name, unit, style }) => [name, unit, style?.title]),
    bands.map(({ name, unit, about }) => [name, unit, about?.['title']]),
  );
  assert.deepEqual([raster.width, raster.height, raster.noData], [width, height, kNoData]);
  for (const [i, band] of bands.entries()) {
    assert.deepEqual([...(await raster.readBand(i))], band.values, band.name);
  }
});

test('what is no raster is refused', async () => {
  for (const text of ['', 'MM', 'II*\0\xff\xff\xff\x7f', '<html>']) {
    await assert.rejects(openRaster(new Blob([text])), Error, text);
  }
});

test('colours go from the least to the most, and leave out what has no value', () => {
  const values = Float32Array.of(2, kNoData, 4, NaN, 3);
  const scale = chooseScale(values, kNoData)!;
  assert.deepEqual(scale, { min: 2, max: 4 });
  assert.equal(chooseScale(Float32Array.of(kNoData), kNoData), undefined);
  const rgba = new Uint8ClampedArray(20);
  paint(values, kNoData, scale, 'warm', rgba);
  assert.deepEqual(
    [...rgba].filter((_, i) => i % 4 === 3),
    [255, 0, 255, 0, 255],
  );
  assert.notDeepEqual(toColour(2, scale, 'warm'), toColour(4, scale, 'warm'));
  assert.deepEqual(toColour(-100, scale, 'warm'), toColour(2, scale, 'warm'));
});

test('a scale has a length, and values that are all alike have the colour of the least', () => {
  const cases: readonly [string, number, number, number][] = [
    ['sun_hours', 0, 0, 1],
    ['dsm', 5, 5, 6],
    ['dsm', -4000, -4000, -3996],
    ['ndsm', -2, 0, 1],
    ['seen', 0, 0, 1],
    ['seen', 1, 0, 1],
    ['hole', 1, 0, 1],
  ];
  for (const [band, value, min, max] of cases) {
    const style = styleOf(band);
    const scale = chooseScale(Float32Array.of(value, kNoData, value), kNoData, style)!;
    assert.deepEqual(scale, { min, max }, band);
    const end = value === 1 ? max : min;
    assert.deepEqual(toColour(value, scale, style.ramp), toColour(end, scale, style.ramp), band);
  }
  assert.notDeepEqual(
    toColour(0, { min: 0, max: 1 }, 'warm'),
    toColour(1, { min: 0, max: 1 }, 'warm'),
  );
});

test('the ends that values give leave out the outermost hundredths, such as one mast', () => {
  const values = Float32Array.from({ length: 1000 }, (_, i) => (i % 200) / 10);
  values.set([300, -50, kNoData, NaN, Infinity], 100);
  const ends = (band: string): number[] => {
    const { min, max } = chooseScale(values, kNoData, styleOf(band))!;
    return [min, max].map((end) => Math.round(end * 10) / 10);
  };
  assert.deepEqual(ends('dsm'), [0.1, 19.8]);
  assert.deepEqual(ends('ndsm'), [0, 19.8]);
  assert.deepEqual(ends('openness'), [0, 90]);
  const scale = chooseScale(values, kNoData)!;
  assert.deepEqual(toColour(300, scale, 'heights'), toColour(scale.max, scale, 'heights'));
  const rarelySunny = Float32Array.from({ length: 1000 }, (_, i) => (i < 5 ? 10 : 0));
  assert.deepEqual(chooseScale(rarelySunny, kNoData, styleOf('sun_hours')), { min: 0, max: 1 });
});

test('a band that has ends by nature has these, and directions close a circle', () => {
  const aspect = styleOf('aspect');
  const scale = chooseScale(Float32Array.of(10, 350), kNoData, aspect)!;
  assert.deepEqual(scale, { min: 0, max: 360 });
  assert.deepEqual(toColour(0, scale, aspect.ramp), toColour(360, scale, aspect.ramp));
  const energy = chooseScale(Float32Array.of(900, 1200), kNoData, styleOf('kwh_m2'));
  assert.deepEqual(energy, { min: 0, max: 1200 });
  assert.equal(chooseScale(Float32Array.of(kNoData), kNoData, aspect), undefined);
});

test('values are written as their band is read', () => {
  const cases: readonly [string, string, number, number, string][] = [
    ['kwh_m2', 'kWh/m2', 1234.567, 2563, '1235 kWh/m2'],
    ['kwh_m2', 'kWh/m2', 1234.567e-3, 9.5, '1.23 kWh/m2'],
    ['aspect', 'degree', 181.2, 360, '181°'],
    ['svf', '', 0.98765, 1, '0.99'],
    ['ndsm', 'm', -0.001, 1, '0.00 m'],
    ['ndsm', 'm', -0.3, 100, '0 m'],
    ['ndsm', 'm', -0.3, 1, '-0.30 m'],
    ['first_sun', 'h', 4 + 10 / 60, 20, '04:10'],
    ['first_sun', 'h', 19.9999, 20, '20:00'],
    ['seen', '', 1, 1, 'seen'],
    ['seen', '', 0, 1, 'not seen'],
    ['dsm', 'm', 12.345, 50, '12.3 m'],
  ];
  for (const [band, unit, value, max, text] of cases) {
    assert.equal(valueText(value, unit, styleOf(band), { min: 0, max }), text, band);
  }
});

test('what has no colour is said where it may be a value', () => {
  const cases: readonly [string, boolean, string][] = [
    ['dsm', false, ''],
    ['dsm', true, 'Some data could not be read: cells without colour have no value.'],
    ['seen', false, 'Cells without colour are: not seen.'],
    [
      'seen',
      true,
      'Some data could not be read: cells without colour have no value, or are: not seen.',
    ],
  ];
  for (const [band, hasHoles, text] of cases) {
    assert.equal(colourlessText(styleOf(band), hasHoles), text, band);
  }
});

const kNothing = { hasSurface: false, hasDays: false, hasObserver: false };
const sun: Analysis = {
  kind: 'sun',
  title: 'Hours of sun',
  hasSurface: true,
  hasDays: true,
  hasObserver: false,
};
const energy = { ...sun, kind: 'energy', title: 'Energy of the sun' };
const terrain = { ...kNothing, kind: 'terrain', title: 'Terrain: heights, slopes' };
const sight = { ...kNothing, kind: 'sight', title: 'Sight', hasSurface: true, hasObserver: true };

const wish: Wish = {
  analysis: sun,
  extent: [10, 20, 30, 50],
  resolutionM: 2,
  surface: 'ground',
  from: '2026-06-21',
  to: '2026-06-21',
  clockOffsetH: 1,
  observer: [12, 22, 1.6],
};

test('what is asked for has the form of the interface', () => {
  const placed = { isPlaced: true, unitsPerVoxel: 0.5 };
  const body = { area: [10, 20, 30, 50], resolution_m: 2 };
  assert.deepEqual(toBody(wish, placed), {
    kind: 'sun',
    ...body,
    surface: 'ground',
    date: '2026-06-21',
  });
  assert.deepEqual(toBody({ ...wish, analysis: energy, to: '2026-06-30' }, placed), {
    kind: 'energy',
    ...body,
    surface: 'ground',
    from: '2026-06-21',
    to: '2026-06-30',
    step_min: 30,
  });
  assert.deepEqual(toBody({ ...wish, analysis: terrain }, placed), { kind: 'terrain', ...body });
  assert.deepEqual(toBody({ ...wish, analysis: sight }, placed), {
    kind: 'sight',
    ...body,
    surface: 'ground',
    observers: [[12, 22, 1.6]],
    target_m: 1.6,
  });
  // In voxels, whose z is to the south.
  const inVoxels = toBody({ ...wish, analysis: sight }, { isPlaced: false, unitsPerVoxel: 2 });
  assert.deepEqual(inVoxels['area'], [5, -25, 15, -10]);
  assert.deepEqual(inVoxels['observers'], [[6, -11, 1.6]]);
});

test('a result says what it is of, and its file is named so', () => {
  assert.equal(
    toCaption(wish),
    'Hours of sun · ground below them · 21 Jun 2026 · cells of 2 m. ' +
      'The sky has no clouds: this is an upper limit. Clock times are those of UTC+1.',
  );
  const year: Wish = {
    ...wish,
    analysis: energy,
    surface: 'top',
    from: '2026-01-01',
    to: '2026-12-31',
  };
  assert.equal(
    toCaption(year),
    'Energy of the sun · roofs and crowns · 1 Jan 2026 to 31 Dec 2026 · cells of 2 m. ' +
      'The sky has no clouds: this is an upper limit.',
  );
  assert.equal(
    toCaption({ ...wish, analysis: terrain }),
    'Terrain: heights, slopes · cells of 2 m.',
  );
  assert.match(toCaption({ ...wish, clockOffsetH: -5 }), /UTC-5\.$/);
  assert.equal(makeFileName(wish), 'terravox-sun-2026-06-21.tif');
  assert.equal(makeFileName(year), 'terravox-energy-2026-01-01-2026-12-31.tif');
  assert.equal(makeFileName({ ...wish, analysis: sight }), 'terravox-sight.tif');
});

test('cells are as large as they must be', () => {
  assert.deepEqual(countCells([0, 0, 100, 50], 2, 0.5), [25, 13]);
  assert.equal(resolutionFor([0, 0, 100, 50], 0.5, 1, 1e6), 0.5);
  assert.equal(resolutionFor([0, 0, 1000, 1000], 0.5, 1, 1e5), 4);
});

test('a job that is none is refused', () => {
  const id = '0123456789abcdef0123456789abcdef';
  assert.deepEqual(readJob({ id, state: 'done', progress: 7, holes: true }), {
    id,
    state: 'done',
    progress: 1,
    before: 0,
    message: '',
    hasHoles: true,
  });
  for (const bad of [undefined, {}, { id: '../x', state: 'done' }, { id, state: 'odd' }]) {
    assert.throws(() => readJob(bad), /read the job/);
  }
});
