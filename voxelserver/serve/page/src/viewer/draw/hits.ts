/** The pass that finds what rays meet first, and reads it back. */
import type { Vec2, Vec3 } from '../../vec3.js';
import { Program, makeTexture } from './program.js';

/** What rays have met, four numbers each: of a picture row by row from the upper left corner. */
export type FirstHits = {
  /**
   * x, y, z of the voxel, and bits: face 0-2 (7: none), level 4-8, hole 12, hit 13, in the sun 14,
   * visible from the observer 15, cut face of a section 16.
   */
  readonly voxels: Int32Array;
  /** Bits of t (a float, level-0 voxels), attribute, class (256: not known), and one unused. */
  readonly details: Int32Array;
};

/** A ray to be followed to its first hit: level-0 voxels. */
export type CastRay = {
  readonly origin: Vec3;
  /** Of unit length. */
  readonly direction: Vec3;
  readonly maxT: number;
};

/** Rays of one call. */
export const kMaxRays = 4096;
const kRaysRow = 64;
const kRayTexels = 3;

export class HitsPass {
  readonly #gl: WebGL2RenderingContext;
  readonly #program: Program;
  readonly #rays: WebGLTexture;

  constructor(gl: WebGL2RenderingContext, source: string) {
    this.#gl = gl;
    this.#program = new Program(gl, source, ['ANALYSIS', 'FIRST_HITS']);
    this.#rays = makeTexture(gl);
    this.#fill(new Int32Array(kRayTexels * 4 * kRaysRow), 1);
  }

  /** Traces the rays of a picture. @param setScene sets all uniforms but those of this pass */
  trace(size: Vec2, setScene: (p: Program) => void): FirstHits {
    const hits = this.#draw(size, false, setScene);
    const stride = size[0] * 4;
    return { voxels: upsideDown(hits.voxels, stride), details: upsideDown(hits.details, stride) };
  }

  /** Traces rays of a list, of at most kMaxRays; the hits are in its order. */
  cast(rays: readonly CastRay[], setScene: (p: Program) => void): FirstHits {
    const rows = Math.max(1, Math.ceil(rays.length / kRaysRow));
    this.#fill(packed(rays, rows), rows);
    return this.#draw([kRaysRow, rows], true, setScene);
  }

  #draw([width, height]: Vec2, isCast: boolean, setScene: (p: Program) => void): FirstHits {
    const gl = this.#gl;
    const textures = [makeTexture(gl), makeTexture(gl)];
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    textures.forEach((texture, i) => {
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32I, width, height);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
    });
    gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
    gl.viewport(0, 0, width, height);
    this.#program.use();
    setScene(this.#program);
    this.#program.texture('uRays', gl.TEXTURE_2D, this.#rays);
    this.#program.int('uIsCast', isCast ? 1 : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const read = (i: number): Int32Array => {
      const rows = new Int32Array(width * height * 4);
      gl.readBuffer(gl.COLOR_ATTACHMENT0 + i);
      gl.readPixels(0, 0, width, height, gl.RGBA_INTEGER, gl.INT, rows);
      return rows;
    };
    const out = { voxels: read(0), details: read(1) };
    gl.deleteFramebuffer(frame);
    for (const texture of textures) gl.deleteTexture(texture);
    return out;
  }

  #fill(texels: Int32Array, rows: number): void {
    const gl = this.#gl;
    const width = kRaysRow * kRayTexels;
    gl.bindTexture(gl.TEXTURE_2D, this.#rays);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32I, width, rows, 0, gl.RGBA_INTEGER, gl.INT, texels);
  }
}

// As trace.glsl reads them. What is left of the last row are rays of no length.
function packed(rays: readonly CastRay[], rows: number): Int32Array {
  const texels = new Int32Array(rows * kRaysRow * kRayTexels * 4);
  const floats = new Float32Array(texels.buffer);
  rays.forEach(({ origin, direction, maxT }, i) => {
    const at = i * kRayTexels * 4;
    const whole = origin.map(Math.floor);
    texels.set(whole, at);
    floats[at + 3] = maxT;
    floats.set(
      origin.map((v, a) => v - whole[a]!),
      at + 4,
    );
    floats.set(direction, at + 8);
  });
  return texels;
}

function upsideDown(rows: Int32Array, stride: number): Int32Array {
  const out = new Int32Array(rows.length);
  for (let from = 0, to = rows.length - stride; to >= 0; from += stride, to -= stride) {
    out.set(rows.subarray(from, from + stride), to);
  }
  return out;
}
