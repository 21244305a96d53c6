/**
 * Draws what is in the pools: samples of the picture are traced and accumulated, then developed for
 * the screen. Knows no world and no requests: a table of columns, a camera and a light are given.
 */
import type { Appearance } from './appearance.js';
import { pixelRad, type Camera } from './camera.js';
import type { ColumnTable } from './column-table.js';
import developSource from './develop.glsl';
import { fromHalf } from './half.js';
import hashSource from './hash.glsl';
import type { Bounds } from './level-cut.js';
import lightSource from './light.glsl';
import materialSource from './material.glsl';
import { Program } from './program.js';
import type { SkyLight } from './sky-light.js';
import skySource from './sky.glsl';
import type { TexturePools } from './texture-pools.js';
import traceSource from './trace.glsl';
import walkSource from './walk.glsl';
import { wavePhases } from './waves.js';

export type Look = {
  readonly shadows: boolean;
  readonly softSun: boolean;
  readonly occlusion: boolean;
  readonly textures: boolean;
  /** Holes between leaves. */
  readonly cutOuts: boolean;
  readonly bounces: number;
  /** Share of the true colours, [0, 1]; -1: true colours alone. */
  readonly colourMix: number;
  readonly exposureEv: number;
  readonly tone: 'photographic' | 'linear';
};

export const kDefaultLook: Look = {
  shadows: true,
  softSun: true,
  occlusion: true,
  textures: true,
  cutOuts: true,
  bounces: 6,
  colourMix: 0.85,
  exposureEv: 0,
  tone: 'photographic',
};

/** What the primary rays of a picture have met, row by row from the upper left corner. */
export type FirstHits = {
  /** x, y, z of the voxel, and bits: face 0-2, level 4-8, hole 12, hit 13, in the sun 14. */
  readonly voxels: Int32Array;
  /** Bits of t (a float, level-0 voxels), attribute, and two unused. */
  readonly details: Int32Array;
};

/** A part of the picture in pixels, from the lower left corner. */
export type Band = { readonly y: number; readonly height: number };

const kTraceSource = [
  walkSource,
  hashSource,
  skySource,
  materialSource,
  lightSource,
  traceSource,
].join('\n');
const kMaterialTexels = 9;
const kPoolRow = 1024;
const kMaxSteps = 20_000;
const kNightAltitudeSine = Math.sin((-2 * Math.PI) / 180); // lamps are lit below it

type Target = { readonly texture: WebGLTexture; readonly frame: WebGLFramebuffer };

export class Renderer {
  readonly #gl: WebGL2RenderingContext;
  readonly #pools: TexturePools;
  readonly #materials: WebGLTexture;
  readonly #ratio: WebGLTexture;
  readonly #own: WebGLTexture;
  readonly #panes: WebGLTexture;
  readonly #columns: WebGLTexture;
  readonly #boxes: WebGLTexture;
  readonly #sky: WebGLTexture;
  readonly #trace: Program;
  readonly #develop: Program;
  readonly #look: Appearance;
  readonly #meanPane: readonly number[];
  readonly #voxelM: number;
  #hits: Program | undefined;
  #targets: readonly [Target, Target] | undefined;
  #size: readonly [number, number] = [0, 0];
  #samples = 0;
  #table: { readonly mask: number; readonly entry: Bounds; readonly coarsest: number } | undefined;
  #light: SkyLight | undefined;

  /** @throws Error when the browser lacks what is needed */
  constructor(gl: WebGL2RenderingContext, pools: TexturePools, look: Appearance, voxelM: number) {
    if (gl.getExtension('EXT_color_buffer_float') === null)
      throw new Error('draw the place: this browser cannot draw into textures of floats');
    this.#gl = gl;
    this.#pools = pools;
    this.#look = look;
    this.#voxelM = voxelM;
    this.#trace = new Program(gl, kTraceSource);
    this.#develop = new Program(gl, developSource);
    this.#materials = this.#table2d(gl.RGBA32F, kMaterialTexels, materialsOf(look));
    this.#ratio = this.#halves(look.ratio);
    this.#own = this.#halves(look.own);
    this.#panes = this.#halves(look.panes);
    this.#meanPane = meanPaneOf(look);
    this.#columns = this.#texture();
    this.#boxes = this.#texture();
    this.#sky = this.#texture();
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  }

  /** Number of samples that have been accumulated. */
  get samples(): number {
    return this.#samples;
  }

  setColumns(table: ColumnTable, entry: Bounds, coarsest: number): void {
    const gl = this.#gl;
    this.#upload(this.#columns, gl.RGBA32UI, 256, table.columns);
    this.#upload(this.#boxes, gl.RGBA32UI, kPoolRow, table.boxes);
    this.#table = { mask: table.mask, entry, coarsest };
    this.restart();
  }

  setLight(light: SkyLight): void {
    const gl = this.#gl;
    const texels = light.columns * 3;
    const rgba = new Float32Array(texels * light.rows * 4);
    for (let i = 0; i < texels * light.rows; ++i)
      rgba.set(light.nodes.subarray(i * 3, i * 3 + 3), i * 4);
    this.#upload(this.#sky, gl.RGBA32F, texels, rgba);
    this.#light = light;
    this.restart();
  }

  /** What was accumulated is no longer the picture. */
  restart(): void {
    this.#samples = 0;
  }

  /** @param size of the picture, pixels */
  resize(size: readonly [number, number]): void {
    if (size[0] === this.#size[0] && size[1] === this.#size[1]) return;
    this.#dropTargets();
    this.#size = size;
    this.#targets = [this.#target(size), this.#target(size)];
    this.restart();
  }

  /**
   * Traces one sample of each pixel, or of those of a band; a pass ends with the band at the top.
   * @param jitter place of the sample inside the pixel, [0, 1)
   */
  trace(camera: Camera, look: Look, jitter: readonly [number, number], band?: Band): void {
    const gl = this.#gl;
    if (this.#targets === undefined) return;
    const [from, to] = this.#targets;
    const [width, height] = this.#size;
    gl.bindFramebuffer(gl.FRAMEBUFFER, to.frame);
    gl.viewport(0, 0, width, height);
    this.#trace.use();
    this.#setScene(this.#trace, camera, look, jitter);
    this.#trace.texture('uPrevious', gl.TEXTURE_2D, from.texture);
    this.#trace.int('uAccumulate', this.#samples > 0 ? 1 : 0);
    if (band !== undefined) {
      gl.enable(gl.SCISSOR_TEST);
      gl.scissor(0, band.y, width, band.height);
    }
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
    if (band !== undefined && band.y + band.height < height) return;
    this.#targets = [to, from];
    ++this.#samples;
  }

  /** Develops what was accumulated to the canvas. */
  show(look: Look): void {
    const gl = this.#gl;
    if (this.#targets === undefined || this.#samples === 0) return;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    this.#develop.use();
    this.#develop.texture('uAccumulated', gl.TEXTURE_2D, this.#targets[0].texture);
    this.#develop.float(
      'uScale',
      this.#size[0] / gl.drawingBufferWidth,
      this.#size[1] / gl.drawingBufferHeight,
    );
    this.#develop.float('uExposure', 2 ** look.exposureEv);
    this.#develop.int('uTone', look.tone === 'photographic' ? 0 : 1);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** Traces the first hits of a picture and reads them back. */
  firstHits(camera: Camera, look: Look, size: readonly [number, number]): FirstHits {
    const gl = this.#gl;
    this.#hits ??= new Program(gl, kTraceSource, ['FIRST_HITS']);
    const [width, height] = size;
    const textures = [this.#texture(), this.#texture()];
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    textures.forEach((texture, i) => {
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32I, width, height);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
    });
    gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
    gl.viewport(0, 0, width, height);
    const before = this.#size;
    this.#size = size;
    this.#hits.use();
    this.#setScene(this.#hits, camera, look, [0.5, 0.5]);
    this.#size = before;
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const read = (i: number): Int32Array => {
      const rows = new Int32Array(width * height * 4);
      gl.readBuffer(gl.COLOR_ATTACHMENT0 + i);
      gl.readPixels(0, 0, width, height, gl.RGBA_INTEGER, gl.INT, rows);
      return upsideDown(rows, width * 4);
    };
    const out = { voxels: read(0), details: read(1) };
    gl.deleteFramebuffer(frame);
    for (const texture of textures) gl.deleteTexture(texture);
    return out;
  }

  #setScene(p: Program, camera: Camera, look: Look, jitter: readonly [number, number]): void {
    const gl = this.#gl;
    const light = this.#light;
    const table = this.#table;
    if (light === undefined || table === undefined) throw new Error('draw before there is a place');
    const { sky } = this.#look;
    p.texture('uCells', gl.TEXTURE_2D_ARRAY, this.#pools.cells);
    p.texture('uFirst', gl.TEXTURE_2D_ARRAY, this.#pools.first);
    p.texture('uAttributes', gl.TEXTURE_2D_ARRAY, this.#pools.attributes);
    p.texture('uColumns', gl.TEXTURE_2D, this.#columns);
    p.texture('uBoxes', gl.TEXTURE_2D, this.#boxes);
    p.uint('uColumnsMask', table.mask);
    p.int('uBoundsMin', ...table.entry.min);
    p.int('uBoundsMax', ...table.entry.max);
    p.int('uCoarsest', table.coarsest);
    p.int('uMaxSteps', kMaxSteps);

    p.texture('uSky', gl.TEXTURE_2D, this.#sky);
    p.int('uSkySize', light.columns, light.rows);
    p.float('uToSun', ...light.toSun);
    p.float('uSunRight', ...light.sunRight);
    p.float('uSunUp', ...light.sunUp);
    p.float('uSunLight', ...light.sunLight);
    p.float('uSunHeight', light.sunHeight);
    p.float('uSunShare', light.sunShare);
    p.float('uHazeRayleigh', ...sky.hazeRayleighPerM);
    p.float('uHazeMie', ...sky.hazeMiePerM);
    p.float('uNight', ...sky.night);
    p.float('uGround', ...light.ground);
    p.vectors('uAmbient', light.ambient);

    p.texture('uMaterials', gl.TEXTURE_2D, this.#materials);
    p.texture('uRatio', gl.TEXTURE_2D, this.#ratio);
    p.texture('uOwn', gl.TEXTURE_2D, this.#own);
    p.texture('uPanes', gl.TEXTURE_2D, this.#panes);
    p.float('uMeanPane', ...this.#meanPane.slice(0, 4));
    p.float('uMeanGlass', this.#meanPane[4]!);
    p.float('uVoxel_m', this.#voxelM);
    p.float('uColourMix', look.colourMix);
    p.int('uTextures', look.textures ? 1 : 0);
    p.int('uNightTime', light.toSun[1] < kNightAltitudeSine ? 1 : 0);

    p.int('uBounces', look.bounces);
    p.int('uShadows', look.shadows ? 1 : 0);
    p.int('uOcclusion', look.occlusion ? 1 : 0);
    p.int('uCutOuts', look.cutOuts ? 1 : 0);
    p.int('uSoftSun', look.softSun ? 1 : 0);

    const eye = camera.position.map(Math.floor);
    p.int('uEye', ...eye);
    p.float('uEyeOffset', ...camera.position.map((v, a) => v - eye[a]!));
    const phases = wavePhases(eye[0]! * this.#voxelM, eye[2]! * this.#voxelM);
    p.int('uWavesAt', eye[0]!, eye[2]!);
    p.floats('uWaves', phases.waves);
    p.float('uRuffled', ...phases.ruffled);
    p.float('uForward', ...camera.forward);
    p.float('uRight', ...camera.right);
    p.float('uUp', ...camera.up);
    p.float('uSize', ...this.#size);
    p.float('uJitter', ...jitter);
    p.float('uPixelRad', pixelRad(camera, this.#size[1]));
    p.uint('uFrame', this.#samples);
  }

  #texture(): WebGLTexture {
    const gl = this.#gl;
    const texture = gl.createTexture();
    if (texture === null) throw new Error('make a texture: the graphics context is lost');
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
      gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
      gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    return texture;
  }

  #target(size: readonly [number, number]): Target {
    const gl = this.#gl;
    const texture = this.#texture();
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, size[0], size[1]);
    const frame = gl.createFramebuffer();
    if (frame === null) throw new Error('make a frame: the graphics context is lost');
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    return { texture, frame };
  }

  #dropTargets(): void {
    for (const target of this.#targets ?? []) {
      this.#gl.deleteFramebuffer(target.frame);
      this.#gl.deleteTexture(target.texture);
    }
    this.#targets = undefined;
  }

  // Whole rows of a table whose size may change.
  #upload(texture: WebGLTexture, format: number, width: number, data: ArrayBufferView): void {
    const gl = this.#gl;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    const isInteger = format === gl.RGBA32UI;
    const texelBytes = 16;
    gl.texImage2D(
      gl.TEXTURE_2D,
      0,
      format,
      width,
      data.byteLength / texelBytes / width,
      0,
      isInteger ? gl.RGBA_INTEGER : gl.RGBA,
      isInteger ? gl.UNSIGNED_INT : gl.FLOAT,
      data,
    );
  }

  #table2d(format: number, width: number, data: Float32Array): WebGLTexture {
    const texture = this.#texture();
    this.#upload(texture, format, width, data);
    return texture;
  }

  // Half floats, four to a texel, in rows of kPoolRow.
  #halves(values: Uint16Array): WebGLTexture {
    const gl = this.#gl;
    const rows = Math.max(1, Math.ceil(values.length / 4 / kPoolRow));
    const padded = new Uint16Array(rows * kPoolRow * 4);
    padded.set(values);
    const texture = this.#texture();
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, kPoolRow, rows, 0, gl.RGBA, gl.HALF_FLOAT, padded);
    return texture;
  }
}

function materialsOf(look: Appearance): Float32Array {
  const out: number[] = [];
  for (const m of look.materials) {
    out.push(...m.colour, m.kind);
    out.push(m.variation, m.roughness, m.index, m.reflects ? 1 : 0);
    out.push(...m.absorptionPerM, m.windows ? 1 : 0);
    out.push(...m.glow, m.waves ? 1 : 0);
    out.push(...m.emission, 0);
    out.push(...m.own, 0);
    for (const face of [m.side, m.bottom, m.top]) {
      const flags =
        face.turns |
        (face.metric ? 256 : 0) |
        (face.layered ? 512 : 0) |
        (face.hasOwn ? 1024 : 0) |
        (face.hasHoles ? 2048 : 0);
      out.push(face.first, face.ownFirst, face.variants, flags);
    }
  }
  return new Float32Array(out);
}

// The mean over the styles of windows, from their coarsest mips: own colour, share, glass.
function meanPaneOf(look: Appearance): number[] {
  const kStyles = 8;
  const kTexels = 341;
  let mean = [0, 0, 0, 0, 0];
  for (let style = 0; style < kStyles; ++style) {
    const at = (style * kTexels + kTexels - 1) * 8;
    const pane = [0, 1, 2, 3, 4].map((i) => fromHalf(look.panes[at + i]!));
    const t = 1 / (style + 1);
    const share = mean[3]! * (1 - t) + pane[3]! * t;
    const own = [0, 1, 2].map((i) =>
      share > 0 ? (mean[i]! * mean[3]! * (1 - t) + pane[i]! * pane[3]! * t) / share : 0,
    );
    mean = [...own, share, mean[4]! * (1 - t) + pane[4]! * t];
  }
  return mean;
}

function upsideDown(rows: Int32Array, stride: number): Int32Array {
  const out = new Int32Array(rows.length);
  for (let from = 0, to = rows.length - stride; to >= 0; from += stride, to -= stride)
    out.set(rows.subarray(from, from + stride), to);
  return out;
}
