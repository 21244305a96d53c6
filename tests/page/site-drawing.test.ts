import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  readAppearance,
  type Appearance,
} from '../../voxelserver/serve/page/src/viewer/draw/appearance.js';
import type { Camera } from '../../voxelserver/serve/page/src/viewer/draw/look.js';
import type { Vec3 } from '../../voxelserver/serve/page/src/vec3.js';
import {
  heightColour,
  kLayerColours,
  makeLegend,
  type Layer,
} from '../../voxelserver/serve/page/src/viewer/draw/layers.js';
import type { CastRay, Look } from '../../voxelserver/serve/page/src/viewer/draw/renderer.js';
import type { Pick } from '../../voxelserver/serve/page/src/viewer/stage.js';
import { toCamera, lookingAt } from '../../voxelserver/serve/page/src/viewer/ui/navigation.js';
import { readPlaceFile } from '../../voxelserver/serve/page/src/viewer/ui/place-file.js';
import { noBrowser, openBrowser, openPage, type WatchedPage } from './support/browser.js';
import { dot, isNoise, plus } from './support/site.js';

/**
 * What the tools for analyses draw, on a site whose address is TERRAVOX_SITE_DRAWING:
 * tests/e2e/publish_test.py.
 */

const kSite = process.env['TERRAVOX_SITE_DRAWING'] ?? '';

// The tools for analyses: a small picture, so that each of them is drawn in a moment.
const kSmall = { width: 160, height: 120 };
const kPixels = kSmall.width * kSmall.height;
const kMaxRays = 4096;

const unit = (v: Vec3): Vec3 => plus([0, 0, 0], v, 1 / Math.hypot(...v));
const toNormal = (face: number): Vec3 =>
  [0, 1, 2].map((a) => (face >> 1 === a ? (face & 1) * 2 - 1 : 0)) as unknown as Vec3;

type Seen = {
  readonly voxel: Vec3;
  readonly bits: number;
  readonly face: number;
  readonly level: number;
  readonly point: Vec3;
  readonly material: number;
  readonly lidarClass: number;
};

/** A page that shows a view, and what a test asks of it. */
class Tools {
  readonly #page: WatchedPage['page'];
  readonly camera: Camera;
  readonly appearance: Appearance;

  constructor({ page }: WatchedPage, camera: Camera, appearance: Appearance) {
    this.#page = page;
    this.camera = camera;
    this.appearance = appearance;
  }

  /** Waits for a whole picture: the first sample may be a coarse one. */
  async settled(): Promise<void> {
    await this.#page.waitForFunction(
      () => {
        const stats = window.terravox.stats();
        return stats.isComplete && stats.waiting === 0 && stats.samples >= 2;
      },
      undefined,
      { polling: 100 },
    );
  }

  async show(look: Partial<Look>): Promise<void> {
    await this.#page.evaluate((wanted) => window.terravox.setLook(wanted), look);
    // A plan for what an observer needs may be due.
    await this.#page.waitForTimeout(300);
    await this.settled();
  }

  samples(): Promise<number> {
    return this.#page.evaluate(() => window.terravox.stats().samples);
  }

  /** By pixel; undefined: sky. */
  async hits(): Promise<(Seen | undefined)[]> {
    const { voxels, details } = await this.#page.evaluate(() => {
      const read = window.terravox.firstHits()!;
      return { voxels: [...read.voxels], details: [...read.details] };
    });
    const floats = new Float32Array(new Int32Array(details).buffer);
    return Array.from({ length: kPixels }, (_, i) => {
      const bits = voxels[4 * i + 3]!;
      if ((bits & (1 << 13)) === 0) return undefined;
      return {
        voxel: [voxels[4 * i]!, voxels[4 * i + 1]!, voxels[4 * i + 2]!],
        bits,
        face: bits & 7,
        level: (bits >> 4) & 31,
        point: plus(this.camera.position, this.pixelDirection(i), floats[4 * i]),
        material: (details[4 * i + 1]! >>> 24) & 63,
        lidarClass: details[4 * i + 2]!,
      };
    });
  }

  /** Of the ray through the middle of a pixel. */
  pixelDirection(i: number): Vec3 {
    const { width, height } = kSmall;
    const { forward, right, up } = this.camera;
    const across = (2 * ((i % width) + 0.5) - width) / height;
    const upward = (height - 2 * (Math.floor(i / width) + 0.5)) / height;
    return unit(plus(plus(forward, right, across), up, upward));
  }

  async cast(rays: readonly CastRay[]): Promise<(Pick | undefined)[]> {
    const out: (Pick | undefined)[] = [];
    for (let i = 0; i < rays.length; i += kMaxRays) {
      out.push(...(await this.castAtOnce(rays.slice(i, i + kMaxRays))));
    }
    return out;
  }

  async castAtOnce(rays: readonly CastRay[]): Promise<(Pick | undefined)[]> {
    const hits = await this.#page.evaluate(
      (part) => window.terravox.cast(part).map((hit) => hit ?? null),
      rays,
    );
    return hits.map((hit) => hit ?? undefined);
  }

  /** Red, green, blue, opacity of each pixel. */
  async picture(): Promise<Uint8Array> {
    const bytes = await this.#page.evaluate(() => {
      const canvas = document.querySelector('canvas')!;
      const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d')!;
      copy.drawImage(canvas, 0, 0);
      return [...copy.getImageData(0, 0, canvas.width, canvas.height).data];
    });
    return new Uint8Array(bytes);
  }

  async loseAndRestoreContext(): Promise<void> {
    await this.#page.evaluate(async () => {
      const context = document
        .querySelector('canvas')!
        .getContext('webgl2')!
        .getExtension('WEBGL_lose_context')!;
      context.loseContext();
      await new Promise((resolve) => setTimeout(resolve, 100));
      context.restoreContext();
      await new Promise((resolve) => setTimeout(resolve, 500));
    });
    await this.settled();
  }
}

async function openTools(
  browser: Awaited<ReturnType<typeof openBrowser>>,
): Promise<[Tools, WatchedPage]> {
  const load = async (name: string): Promise<Response> => fetch(new URL(name, kSite));
  const first = readPlaceFile(await (await load('place.json')).json()).views[0]!;
  const exact = lookingAt(
    { position: first.position, headingDeg: 0, pitchDeg: 0, fovDeg: first.fovDeg },
    first.target,
  );
  const round = (v: number): number => Number(v.toFixed(2));
  const view = {
    position: first.position.map(round) as unknown as Vec3,
    headingDeg: round(exact.headingDeg),
    pitchDeg: round(exact.pitchDeg),
    fovDeg: round(exact.fovDeg),
  };
  const look = [view.headingDeg, view.pitchDeg, view.fovDeg];
  const link = `${kSite}#at=${view.position.join(',')}&look=${look.join(',')}`;
  const watched = await openPage(browser, link, { viewport: kSmall }, 1);
  await watched.page.evaluate(() => window.terravox.ready);
  const packed = await (await load('appearance.bin')).arrayBuffer();
  const appearance = await readAppearance(new Uint8Array(packed));
  const tools = new Tools(watched, toCamera(view), appearance);
  await tools.settled();
  return [tools, watched];
}

const share = (of: readonly boolean[]): number => of.filter(Boolean).length / of.length;

/** Pixels whose neighbours show the same kind, so that samples away from their middle do, too. */
function inner(hits: readonly (Seen | undefined)[], toKind: (hit: Seen) => number): number[] {
  const kind = hits.map((hit) => (hit === undefined ? -1 : toKind(hit)));
  const out: number[] = [];
  for (let y = 1; y < kSmall.height - 1; ++y) {
    for (let x = 1; x < kSmall.width - 1; ++x) {
      const i = y * kSmall.width + x;
      const around = [-1, 0, 1].flatMap((dy) =>
        [-1, 0, 1].map((dx) => kind[i + dy * kSmall.width + dx]),
      );
      if (kind[i]! >= 0 && around.every((other) => other === kind[i])) out.push(i);
    }
  }
  return out;
}

const linear = (byte: number): number =>
  byte <= 10 ? byte / 255 / 12.92 : ((byte / 255 + 0.055) / 1.055) ** 2.4;
const sRgb = (c: number): number =>
  255 * (c <= 0.0031308 ? c * 12.92 : 1.055 * c ** (1 / 2.4) - 0.055);

/** Whether a pixel is a shade of a colour: neither hue nor saturation differ. */
function isSameHue(pixel: readonly number[], colour: readonly number[]): boolean {
  const brightest = colour.indexOf(Math.max(...colour));
  const shade = linear(pixel[brightest]!) / linear(colour[brightest]!);
  return (
    shade > 0.15 &&
    shade < 1.05 &&
    colour.every((c, a) => Math.abs(sRgb(linear(c) * shade) - pixel[a]!) <= 4)
  );
}

async function castMeetsPicture(tools: Tools): Promise<void> {
  const hits = await tools.hits();
  const before = await tools.samples();
  const origin = tools.camera.position;
  const rays = hits.map((_, i) => ({ origin, direction: tools.pixelDirection(i), maxT: 1e6 }));
  const met = await tools.cast(rays);
  const same = met.map((hit, i) => {
    const seen = hits[i];
    if (hit === undefined || seen === undefined) return hit === undefined && seen === undefined;
    return (
      hit.voxel.join() === seen.voxel.join() &&
      hit.level === seen.level &&
      hit.face === seen.face &&
      hit.material === seen.material &&
      hit.isInSun === (((seen.bits >> 14) & 1) === 1)
    );
  });
  // A direction may be rounded otherwise than on the graphics processor.
  assert.ok(share(same) >= 0.9995, `the same: ${share(same)}`);
  assert.ok(hits.filter((hit) => hit !== undefined).length > kPixels / 10);
  assert.ok((await tools.samples()) >= before, 'the picture was begun anew');

  // Not beyond their length.
  const cut = rays.map((ray, i) => ({
    ...ray,
    maxT: (met[i]?.distance ?? 1) * (i % 2 === 0 ? 0.999 : 1.001),
  }));
  const reached = await tools.cast(cut);
  for (const [i, hit] of reached.entries()) {
    assert.equal(hit !== undefined, i % 2 === 1 && met[i] !== undefined, `ray ${i}`);
  }
  // Straight down onto what is seen from above.
  const tops = hits.filter((hit) => hit?.face === 3 && hit.level === 0).slice(0, 500) as Seen[];
  const down = await tools.cast(
    tops.map(({ point }) => ({
      origin: plus(point, [0, 0.25, 0]),
      direction: [0, -1, 0],
      maxT: 1,
    })),
  );
  for (const [i, hit] of down.entries()) {
    assert.ok(Math.abs(hit!.point[1] - (tops[i]!.voxel[1] + 1)) < 1e-3);
    assert.equal(hit!.face, 3);
  }
  await assert.rejects(
    tools.castAtOnce(rays.slice(0, kMaxRays + 1)),
    /4097 of them; allowed: 0 to 4096/,
  );
}

async function sectionCuts(tools: Tools): Promise<void> {
  const plain = await tools.hits();
  const middle = plain[Math.floor(kSmall.height * 0.6) * kSmall.width + kSmall.width / 2]!;
  const towards = unit(plus(tools.camera.position, middle.point, -1));
  const oblique = unit([towards[0], 0.3, towards[2]]);
  const straight: Vec3 =
    Math.abs(towards[0]) > Math.abs(towards[2])
      ? [Math.sign(towards[0]), 0, 0]
      : [0, 0, Math.sign(towards[2])];
  for (const [normal, offset] of [
    [oblique, dot(oblique, middle.point)],
    // Along faces of voxels, where rounding would show.
    [straight, Math.round(dot(straight, middle.point))],
  ] as const) {
    await tools.show({ section: { normal, offset } });
    const hits = await tools.hits();
    const solid = hits.filter((hit) => hit !== undefined);
    assert.ok(solid.length > kPixels / 20, `${solid.length} hits`);
    for (const hit of solid) {
      assert.ok(dot(normal, hit.point) <= offset + 1e-2, `${hit.point.join()} is cut away`);
    }
    // What is solid where a ray meets the plane is the cut face, without gaps.
    const starts = hits.map((_, i): CastRay => {
      const direction = tools.pixelDirection(i);
      const t = (offset - 1 / 128 - dot(normal, tools.camera.position)) / dot(normal, direction);
      return {
        origin: plus(tools.camera.position, direction, t > 0 ? t : -1e6),
        direction,
        maxT: 1e-3,
      };
    });
    const inside = await tools.cast(starts);
    const isCap = hits.map((hit) => ((hit?.bits ?? 0) & (1 << 16)) !== 0);
    assert.ok(isCap.filter(Boolean).length > 100, 'there is a cut face');
    const same = isCap.map((cap, i) => cap === (inside[i]?.face === -1));
    assert.ok(share(same) >= 0.999, `the cut face is whole: ${share(same)}`);
    const alike = inside.filter(
      (hit, i) =>
        isCap[i] &&
        hit?.material === hits[i]!.material &&
        hit.voxel.join() === hits[i]!.voxel.join(),
    );
    assert.ok(
      alike.length >= 0.999 * isCap.filter(Boolean).length,
      `it shows its voxels: ${alike.length} of ${isCap.filter(Boolean).length}`,
    );
  }
  await tools.show({});
  assert.deepEqual(await tools.hits(), plain);
}

async function layersMatchLegends(tools: Tools): Promise<void> {
  const hits = await tools.hits();
  const heights = hits.filter((hit) => hit !== undefined).map((hit) => hit.point[1]);
  const heightRange = [Math.floor(Math.min(...heights)), Math.ceil(Math.max(...heights))] as const;
  const toKind: Record<Exclude<Layer, 'none'>, (hit: Seen) => number> = {
    height: (hit) => (hit.face === 3 ? (hit.voxel[1] + 1) * 2 ** hit.level : -1),
    material: (hit) => hit.material,
    class: (hit) => hit.lidarClass,
    level: (hit) => hit.level,
  };
  const toColour = (layer: Layer, kind: number, levels: number): readonly number[] => {
    if (layer === 'height') {
      const at = (kind - heightRange[0]) / (heightRange[1] - heightRange[0]);
      return heightColour(Math.round(at * (kLayerColours - 1)) / (kLayerColours - 1));
    }
    const legend = makeLegend(layer, tools.appearance, 1, levels);
    const keys: Partial<Record<Layer, string | number | undefined>> = {
      material: tools.appearance.materials[kind]?.name,
      class: kind,
      level: 2 ** kind,
    };
    return legend.find((entry) => entry.of === keys[layer])?.colour ?? [0, 0, 0];
  };
  /** Share of the pixels whose colour is the legend's of a world with so many levels. */
  const rightShare = async (layer: Exclude<Layer, 'none'>, levels: number): Promise<number> => {
    const picture = await tools.picture();
    const places = inner(hits, toKind[layer]);
    assert.ok(places.length > kPixels / 50, `${layer}: ${places.length} pixels`);
    return share(
      places.map((i) =>
        isSameHue(
          [...picture.subarray(4 * i, 4 * i + 3)],
          toColour(layer, toKind[layer](hits[i]!), levels),
        ),
      ),
    );
  };
  let levels = 1; // which the page does not tell
  // Samples lie around the middle of a pixel, where hits are read, and may meet smaller things; how
  // many have been summed depends on the machine.
  const kAlike = 0.9;
  for (const layer of ['height', 'material', 'class', 'level'] as const) {
    await tools.show({ layer, heightRange });
    const found: number[] = [];
    for (const count of layer === 'level' ? [1, 2, 3, 4, 5, 6, 7, 8] : [1]) {
      found.push(await rightShare(layer, count));
    }
    levels = found.indexOf(Math.max(...found)) + 1;
    assert.ok(Math.max(...found) >= kAlike, `${layer}: ${found.join(', ')}`);
    assert.deepEqual(await tools.hits(), hits, 'a layer changes no hits');
  }
  await tools.loseAndRestoreContext();
  const again = await rightShare('level', levels);
  assert.ok(again >= kAlike, `after the context was lost: ${again}`);
  await tools.show({});
}

async function observerSees(tools: Tools): Promise<void> {
  const before = await tools.hits();
  const middle = before[Math.floor(kSmall.height * 0.6) * kSmall.width + kSmall.width / 2]!;
  const observer = plus(middle.point, [3.3, 14.6, -2.2]);
  await tools.show({ observer });
  const hits = await tools.hits();
  const isVisible = hits.map((hit) => ((hit?.bits ?? 0) & (1 << 15)) !== 0);
  const places = hits.flatMap((hit, i) => (hit !== undefined && hit.face < 6 ? [i] : []));
  const rays = places.map((i): CastRay => {
    const { point, face } = hits[i]!;
    const origin = plus(point, toNormal(face), 1e-2);
    const to = plus(observer, origin, -1);
    return { origin, direction: unit(to), maxT: Math.hypot(...to) };
  });
  const blocked = await tools.cast(rays);
  const same = places.map(
    (i, k) =>
      isVisible[i] ===
      (blocked[k] === undefined && dot(rays[k]!.direction, toNormal(hits[i]!.face)) > 0),
  );
  assert.ok(share(same) >= 0.99, `the same: ${share(same)}`);
  const seen = share(places.map((i) => isVisible[i]!));
  assert.ok(seen > 0.02 && seen < 0.98, `seen: ${seen}`);
  for (const hit of blocked) if (hit !== undefined) assert.equal(typeof hit.isVisible, 'boolean');
  // Hidden places are violet, which nothing else is; see kAlike for what may differ.
  const picture = await tools.picture();
  const violet = inner(hits, (hit) => (hit.bits >> 15) & 1).map(
    (i) =>
      [
        isVisible[i]!,
        picture[4 * i + 2]! > picture[4 * i + 1]! && picture[4 * i]! > picture[4 * i + 1]!,
      ] as const,
  );
  const tinted = share(violet.filter(([visible]) => !visible).map(([, is]) => is));
  const kept = share(violet.filter(([visible]) => visible).map(([, is]) => !is));
  assert.ok(tinted >= 0.9 && kept >= 0.9, `tinted: ${tinted}, kept: ${kept}`);
  await tools.show({});
  assert.equal(
    (
      await tools.cast([
        { origin: tools.camera.position, direction: tools.pixelDirection(kPixels - 1), maxT: 1e6 },
      ])
    )[0]?.isVisible,
    undefined,
  );
}

test('the tools for analyses draw and tell the same', { skip: noBrowser }, async (t) => {
  const browser = await openBrowser();
  try {
    // One page for all of them: each leaves it as it was.
    const [tools, { errors }] = await openTools(browser);
    await t.test('rays that are cast meet what the picture shows, and the picture goes on', () =>
      castMeetsPicture(tools),
    );
    await t.test(
      'a section cuts away what lies beyond it, closes what is cut, and leaves no trace',
      () => sectionCuts(tools),
    );
    await t.test(
      'layers have the colours of their legends, also after the graphics context was lost',
      () => layersMatchLegends(tools),
    );
    await t.test('an observer sees what a ray reaches, and all else is tinted', () =>
      observerSees(tools),
    );
    assert.deepEqual(
      errors.filter((message) => !isNoise(message)),
      [],
    );
  } finally {
    await browser.close();
  }
});
