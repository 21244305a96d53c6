/**
 * Draws what is in the pools: samples of the picture are traced and accumulated, then developed for
 * the screen. Knows no world and no requests: a table of columns, a camera and a light are given.
 */
import type { Vec2 } from '../../vec3.js';
import { Analysis, isAnalysis } from './analysis.js';
import type { Appearance } from './appearance.js';
import type { ColumnTable } from './column-table.js';
import developSource from './develop.glsl';
import { fromHalf } from '../../bytes.js';
import hashSource from './hash.glsl';
import { HitsPass, kMaxRays, type CastRay, type FirstHits } from './hits.js';
import layerSource from './layer.glsl';
import type { Bounds } from './level-cut.js';
import lightSource from './light.glsl';
import { type Look, pixelRad, type Camera } from './look.js';
import materialSource from './material.glsl';
import { Program, makeTexture } from './program.js';
import sectionSource from './section.glsl';
import type { SkyLight } from './sky-light.js';
import skySource from './sky.glsl';
import type { TexturePools } from './texture-pools.js';
import traceSource from './trace.glsl';
import walkSource from './walk.glsl';
import { wavePhases } from './waves.js';

export type { CastRay, FirstHits } from './hits.js';
export { kDefaultLook, type Look, type Section } from './look.js';

/** A part of the picture in pixels, from the lower left corner. */
export type Band = { readonly y: number; readonly height: number };

const kTraceSource = [
  walkSource,
  sectionSource,
  hashSource,
  skySource,
  materialSource,
  lightSource,
  layerSource,
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
  readonly #analysis: Analysis;
  // Compiled when they are first used, since most visitors use none of them.
  #traceAnalysis: Program | undefined;
  #hits: HitsPass | undefined;
  #targets: readonly [Target, Target] | undefined;
  #size: Vec2 = [0, 0];
  #samples = 0;
  #table: { readonly mask: number; readonly entry: Bounds; readonly coarsest: number } | undefined;
  #light: SkyLight | undefined;

  /**
   * @param levels that the world has
   * @throws Error when the browser lacks what is needed
   */
  constructor(
    gl: WebGL2RenderingContext,
    pools: TexturePools,
    look: Appearance,
    voxelM: number,
    levels: number,
  ) {
    if (gl.getExtension('EXT_color_buffer_float') === null) {
      throw new Error('draw the place: this browser cannot draw into textures of floats');
    }
    this.#gl = gl;
    this.#pools = pools;
    this.#look = look;
    this.#voxelM = voxelM;
    this.#trace = new Program(gl, kTraceSource);
    this.#develop = new Program(gl, developSource);
    this.#materials = this.#table2d(gl.RGBA32F, kMaterialTexels, packMaterials(look));
    this.#ratio = this.#halves(look.ratio);
    this.#own = this.#halves(look.own);
    this.#panes = this.#halves(look.panes);
    this.#meanPane = computeMeanPane(look);
    this.#columns = makeTexture(gl);
    this.#boxes = makeTexture(gl);
    this.#sky = makeTexture(gl);
    this.#analysis = new Analysis(gl, look, voxelM, levels);
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
    for (let i = 0; i < texels * light.rows; ++i) {
      rgba.set(light.nodes.subarray(i * 3, i * 3 + 3), i * 4);
    }
    this.#upload(this.#sky, gl.RGBA32F, texels, rgba);
    this.#light = light;
    this.restart();
  }

  /** What was accumulated is no longer the picture. */
  restart(): void {
    this.#samples = 0;
  }

  /** @param size of the picture, pixels */
  resize(size: Vec2): void {
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
  trace(camera: Camera, look: Look, jitter: Vec2, band?: Band): void {
    const gl = this.#gl;
    if (this.#targets === undefined) return;
    const [from, to] = this.#targets;
    const [width, height] = this.#size;
    gl.bindFramebuffer(gl.FRAMEBUFFER, to.frame);
    gl.viewport(0, 0, width, height);
    const program = this.#traceProgram(look);
    program.use();
    this.#setScene(program, camera, look, jitter, this.#size);
    program.texture('uPrevious', gl.TEXTURE_2D, from.texture);
    program.int('uAccumulate', this.#samples > 0 ? 1 : 0);
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
    // The colours of a layer are those of its legend, by day and by night.
    const isLayer = look.layer !== 'none';
    this.#develop.float('uExposure', isLayer ? 1 : 2 ** look.exposureEv);
    this.#develop.int('uTone', isLayer || look.tone === 'linear' ? 1 : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** Traces the first hits of a picture and reads them back. */
  firstHits(camera: Camera, look: Look, size: Vec2): FirstHits {
    return this.#hitsPass().trace(size, (p) => this.#setScene(p, camera, look, [0.5, 0.5], size));
  }

  /** Follows rays of a list to their first hits. @throws Error for more than kMaxRays */
  cast(rays: readonly CastRay[], camera: Camera, look: Look): FirstHits {
    if (rays.length > kMaxRays) {
      throw new Error(`cast rays: ${rays.length} of them; allowed: 0 to ${kMaxRays}`);
    }
    return this.#hitsPass().cast(rays, (p) => this.#setScene(p, camera, look, [0.5, 0.5], [1, 1]));
  }

  #hitsPass(): HitsPass {
    return (this.#hits ??= new HitsPass(this.#gl, kTraceSource));
  }

  #traceProgram(look: Look): Program {
    if (!isAnalysis(look)) return this.#trace;
    return (this.#traceAnalysis ??= new Program(this.#gl, kTraceSource, ['ANALYSIS']));
  }

  #setScene(p: Program, camera: Camera, look: Look, jitter: Vec2, size: Vec2): void {
    const gl = this.#gl;
    const light = this.#light;
    const table = this.#table;
    if (light === undefined || table === undefined) throw new Error('draw before there is a place');
    const { sky } = this.#look;
    p.texture('uCells', gl.TEXTURE_2D_ARRAY, this.#pools.cells);
    p.texture('uFirst', gl.TEXTURE_2D_ARRAY, this.#pools.first);
    p.texture('uAttributes', gl.TEXTURE_2D_ARRAY, this.#pools.attributes);
    p.texture('uClasses', gl.TEXTURE_2D_ARRAY, this.#pools.classes);
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
    p.float('uHazeRayleigh', ...sky.hazeRayleigh_per_m);
    p.float('uHazeMie', ...sky.hazeMie_per_m);
    p.float('uNight', ...sky.night);
    p.float('uGround', ...light.ground);
    p.vectors('uAmbient', light.ambient);

    this.#setMaterials(p, look, light);

    p.int('uBounces', look.bounces);
    p.int('uShadows', look.shadows ? 1 : 0);
    p.int('uOcclusion', look.occlusion ? 1 : 0);
    p.int('uCutOuts', look.cutOuts ? 1 : 0);
    p.int('uSoftSun', look.softSun ? 1 : 0);

    const eye = camera.position.map(Math.floor);
    p.int('uEye', ...eye);
    this.#analysis.set(p, look, eye);
    p.float('uEyeOffset', ...camera.position.map((v, a) => v - eye[a]!));
    const phases = wavePhases(eye[0]! * this.#voxelM, eye[2]! * this.#voxelM);
    p.int('uWavesAt', eye[0]!, eye[2]!);
    p.floats('uWaves', phases.waves);
    p.float('uRuffled', ...phases.ruffled);
    p.float('uForward', ...camera.forward);
    p.float('uRight', ...camera.right);
    p.float('uUp', ...camera.up);
    p.float('uSize', ...size);
    p.float('uJitter', ...jitter);
    p.float('uPixelRad', pixelRad(camera, size[1]));
    p.uint('uFrame', this.#samples);
  }

  #setMaterials(p: Program, look: Look, light: SkyLight): void {
    const gl = this.#gl;
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
  }

  #target(size: Vec2): Target {
    const gl = this.#gl;
    const texture = makeTexture(gl);
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
    const texture = makeTexture(this.#gl);
    this.#upload(texture, format, width, data);
    return texture;
  }

  // Half floats, four to a texel, in rows of kPoolRow.
  #halves(values: Uint16Array): WebGLTexture {
    const gl = this.#gl;
    const rows = Math.max(1, Math.ceil(values.length / 4 / kPoolRow));
    const padded = new Uint16Array(rows * kPoolRow * 4);
    padded.set(values);
    const texture = makeTexture(gl);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, kPoolRow, rows, 0, gl.RGBA, gl.HALF_FLOAT, padded);
    return texture;
  }
}

function packMaterials(look: Appearance): Float32Array {
  const out: number[] = [];
  for (const m of look.materials) {
    out.push(...m.colour, m.kind);
    out.push(m.variation, m.roughness, m.index, m.reflects ? 1 : 0);
    out.push(...m.absorption_per_m, m.windows ? 1 : 0);
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
function computeMeanPane(look: Appearance): number[] {
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
