/** The uniforms of section.glsl and layer.glsl. */
import type { Appearance } from './appearance.js';
import { contourStepM, kLayerColours, layerTable, type Layer } from './layers.js';
import type { Look } from './look.js';
import { type Program, makeTexture } from './program.js';

const kLayers: Readonly<Record<Layer, number>> = {
  none: 0,
  height: 1,
  material: 2,
  class: 3,
  level: 4,
};

/** Whether a picture needs more than the plain program. */
export function isAnalysis(look: Look): boolean {
  return look.layer !== 'none' || look.section !== undefined || look.observer !== undefined;
}

export class Analysis {
  readonly #gl: WebGL2RenderingContext;
  readonly #appearance: Appearance;
  readonly #voxelM: number;
  readonly #levels: number;
  readonly #colours: WebGLTexture;
  #layer: Layer | undefined;

  constructor(gl: WebGL2RenderingContext, appearance: Appearance, voxelM: number, levels: number) {
    this.#gl = gl;
    this.#appearance = appearance;
    this.#voxelM = voxelM;
    this.#levels = levels;
    this.#colours = makeTexture(gl);
  }

  /** @param origin the whole voxel that the shader computes relative to */
  set(p: Program, look: Look, origin: readonly number[]): void {
    const { section, observer, heightRange } = look;
    if (this.#layer !== look.layer) this.#fill(look.layer);
    p.texture('uLayerColours', this.#gl.TEXTURE_2D, this.#colours);
    p.int('uLayer', kLayers[look.layer]);
    p.float('uLowest', heightRange[0] - origin[1]!);
    p.float('uPerHeight', (kLayerColours - 1) / (heightRange[1] - heightRange[0]));
    const band = contourStepM((heightRange[1] - heightRange[0]) * this.#voxelM) / this.#voxelM;
    p.float('uBand', band);
    // Where in the two bands of a pair the origin lies.
    p.float('uInBands', origin[1]! - Math.floor(origin[1]! / (2 * band)) * 2 * band);

    p.int('uOrigin', ...origin);
    p.int('uIsCut', section === undefined ? 0 : 1);
    const normal = section?.normal ?? [0, 1, 0];
    const along = origin.reduce((sum, v, a) => sum + v * normal[a]!, 0);
    p.float('uSectionNormal', ...normal);
    p.float('uSectionOffset', (section?.offset ?? 0) - along);

    const eye = observer ?? [0, 0, 0];
    const whole = eye.map(Math.floor);
    p.int('uHasObserver', observer === undefined ? 0 : 1);
    p.int('uObserver', ...whole);
    p.float('uObserverOffset', ...eye.map((v, a) => v - whole[a]!));
  }

  #fill(layer: Layer): void {
    const gl = this.#gl;
    const table = layerTable(layer, this.#appearance, this.#levels);
    gl.bindTexture(gl.TEXTURE_2D, this.#colours);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, kLayerColours, 1, 0, gl.RGBA, gl.FLOAT, table);
    this.#layer = layer;
  }
}
