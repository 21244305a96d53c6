// Opens a site and shows views of it: node site_views.mjs JOB. JOB is a file of JSON: "url",
// "width", "height", "folder", and "views", each with a "name", a "link" (the part of the address
// from # on) and "light" where one sample of its light is wanted. Writes to the folder, row by row
// from the upper left corner:
//   NAME.hits     x, y, z and bits of each pixel, four 32-bit numbers (see FirstHits)
//   NAME.light    red, green, blue and the number of samples, four 32-bit floats
//   NAME.png      the canvas
// The light is that of the centre of each pixel, of a point-like sun, with leaves without holes:
// nothing is left to chance. "trustsAll": certificates of no known authority will do.
// Exit code 3: there is no browser.
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const page_ = join(dirname(fileURLToPath(import.meta.url)), '../../voxelserver/serve/page/package.json');
const { chromium } = createRequire(page_)('playwright-core');
const job = JSON.parse(readFileSync(process.argv[2], 'utf8'));
const executablePath = process.env.TERRAVOX_CHROMIUM ?? '/usr/bin/chromium';
const kHangs_ms = 600_000;
if (!existsSync(executablePath)) {
  console.log(`no ${executablePath}`);
  process.exit(3);
}

/** In the page, before its own scripts: keeps the first sample of each whole picture. */
function keepFirstSample() {
  const gl2 = WebGL2RenderingContext.prototype;
  const wrap = (name, around) => {
    const plain = gl2[name];
    gl2[name] = function (...args) {
      return around.call(this, plain, args);
    };
  };
  const fixed = new Map(); // uniforms: location -> value
  window.kept = { isWanted: false, light: undefined };
  wrap('getUniformLocation', function (plain, args) {
    const location = plain.apply(this, args);
    if (['uSoftSun', 'uCutOuts'].includes(args[1])) fixed.set(location, 0);
    return location;
  });
  wrap('uniform1i', function (plain, [location, value]) {
    return plain.call(this, location, window.kept.isWanted ? (fixed.get(location) ?? value) : value);
  });
  wrap('drawArrays', function (plain, args) {
    const result = plain.apply(this, args);
    const { kept } = window;
    // Only passes draw with a scissor box; the last band of one lies at the top.
    if (!kept.isWanted || kept.light !== undefined || !this.isEnabled(this.SCISSOR_TEST)) return result;
    const [, y, width, height] = this.getParameter(this.SCISSOR_BOX);
    const { canvas } = this;
    const isWhole = width === canvas.width && y + height === canvas.height;
    if (!isWhole || this.getParameter(this.VIEWPORT)[3] !== canvas.height) return result;
    if (!window.terravox.stats().isComplete) return result;
    const light = new Float32Array(canvas.width * canvas.height * 4);
    this.readPixels(0, 0, canvas.width, canvas.height, this.RGBA, this.FLOAT, light);
    // Later samples are not those of the centres of pixels.
    if (light[3] === 1) kept.light = light;
    return result;
  });
}

const browser = await chromium.launch({
  executablePath,
  headless: true,
  args: [
    ...(process.getuid?.() === 0 ? ['--no-sandbox'] : []),
    ...(job.trustsAll === true ? ['--ignore-certificate-errors'] : []),
  ],
});
try {
  const viewport = { width: job.width, height: job.height };
  const context = await browser.newContext({ viewport });
  context.setDefaultTimeout(kHangs_ms);
  const page = await context.newPage();
  page.on('pageerror', (error) => {
    throw error;
  });
  await page.addInitScript(keepFirstSample);
  await page.goto(job.url + job.views[0].link);
  await page.evaluate(() => window.terravox.ready);
  for (const view of job.views) {
    await page.evaluate(
      ([link, isWanted]) => {
        history.replaceState(null, '', link);
        window.dispatchEvent(new HashChangeEvent('hashchange'));
        // What is traced from now on is of this view: passes of the one before are dropped.
        window.kept.isWanted = isWanted;
        window.kept.light = undefined;
        window.shownAt = performance.now();
      },
      [view.link, view.light === true],
    );
    // A plan for the view may take a moment.
    await page.waitForFunction(
      (light) => {
        const isPlanned = performance.now() - window.shownAt > 500;
        const { isComplete, samples } = window.terravox.stats();
        return isPlanned && isComplete && samples > 0 && (!light || window.kept.light !== undefined);
      },
      view.light === true,
      { polling: 100 },
    );
    const write = (ending, text) =>
      writeFileSync(join(job.folder, `${view.name}.${ending}`), Buffer.from(text, 'base64'));
    const base64 = (name) =>
      page.evaluate((what) => {
        const rows = (values, height) => {
          const row = values.length / height;
          const flipped = values.slice();
          for (let y = 0; y < height; ++y)
            flipped.set(values.subarray((height - 1 - y) * row, (height - y) * row), y * row);
          return flipped;
        };
        const canvas = document.querySelector('canvas');
        const values =
          what === 'hits'
            ? window.terravox.firstHits().voxels
            : rows(window.kept.light, canvas.height);
        const bytes = new Uint8Array(values.buffer, values.byteOffset, values.byteLength);
        let text = '';
        for (let at = 0; at < bytes.length; at += 32_768)
          text += String.fromCharCode(...bytes.subarray(at, at + 32_768));
        return btoa(text);
      }, name);
    write('hits', await base64('hits'));
    if (view.light === true) write('light', await base64('light'));
    const picture = await page.evaluate(() => document.querySelector('canvas').toDataURL('image/png'));
    write('png', picture.split(',')[1]);
  }
} finally {
  await browser.close();
}
