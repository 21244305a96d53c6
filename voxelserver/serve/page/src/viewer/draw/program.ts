/** A shader program with its uniforms by name. */

const kVersion = '#version 300 es\n';
const kPrecisions = `precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
precision highp usampler2DArray;
precision highp isampler2D;
`;
// One triangle that covers the screen.
const kVertexShader = `${kVersion}void main() {
  vec2 at = vec2[](vec2(-1.0, -1.0), vec2(3.0, -1.0), vec2(-1.0, 3.0))[gl_VertexID];
  gl_Position = vec4(at, 0.0, 1.0);
}
`;

export class Program {
  readonly #gl: WebGL2RenderingContext;
  readonly #program: WebGLProgram;
  readonly #locations = new Map<string, WebGLUniformLocation | null>();
  #units = 0;

  /**
   * @param source of the fragment shader, without version and precisions
   * @throws Error with the compiler's message
   */
  constructor(gl: WebGL2RenderingContext, source: string, defines: readonly string[] = []) {
    this.#gl = gl;
    const head = defines.map((name) => `#define ${name}\n`).join('');
    const vertex = compile(gl, gl.VERTEX_SHADER, kVertexShader);
    const fragment = compile(gl, gl.FRAGMENT_SHADER, kVersion + kPrecisions + head + source);
    const program = gl.createProgram();
    if (program === null) throw new Error('make a shader program: the graphics context is lost');
    gl.attachShader(program, vertex);
    gl.attachShader(program, fragment);
    gl.linkProgram(program);
    gl.deleteShader(vertex);
    gl.deleteShader(fragment);
    if (gl.getProgramParameter(program, gl.LINK_STATUS) !== true && !gl.isContextLost()) {
      throw new Error(`link a shader program: ${gl.getProgramInfoLog(program) ?? ''}`);
    }
    this.#program = program;
  }

  /** Makes it the current program; textures are bound anew from unit 0. */
  use(): void {
    this.#gl.useProgram(this.#program);
    this.#units = 0;
  }

  int(name: string, ...values: readonly number[]): void {
    const at = this.#at(name);
    if (values.length === 1) this.#gl.uniform1iv(at, values);
    else if (values.length === 2) this.#gl.uniform2iv(at, values);
    else this.#gl.uniform3iv(at, values);
  }

  uint(name: string, value: number): void {
    this.#gl.uniform1ui(this.#at(name), value >>> 0);
  }

  float(name: string, ...values: readonly number[]): void {
    const at = this.#at(name);
    if (values.length === 1) this.#gl.uniform1f(at, values[0]!);
    else if (values.length === 2) this.#gl.uniform2fv(at, values);
    else if (values.length === 3) this.#gl.uniform3fv(at, values);
    else this.#gl.uniform4fv(at, values);
  }

  /** An array of single numbers. */
  floats(name: string, values: readonly number[]): void {
    this.#gl.uniform1fv(this.#at(name), values);
  }

  /** An array of three components each. */
  vectors(name: string, values: readonly (readonly number[])[]): void {
    this.#gl.uniform3fv(this.#at(name), values.flat());
  }

  texture(name: string, target: number, texture: WebGLTexture): void {
    const gl = this.#gl;
    const unit = this.#units;
    this.#units += 1;
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(target, texture);
    gl.uniform1i(this.#at(name), unit);
  }

  // A uniform that the compiler has removed has no location; setting it does nothing.
  #at(name: string): WebGLUniformLocation | null {
    let at = this.#locations.get(name);
    if (at === undefined) {
      at = this.#gl.getUniformLocation(this.#program, name);
      this.#locations.set(name, at);
    }
    return at;
  }
}

function compile(gl: WebGL2RenderingContext, type: number, source: string): WebGLShader {
  const shader = gl.createShader(type);
  if (shader === null) throw new Error('compile a shader: the graphics context is lost');
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  if (gl.getShaderParameter(shader, gl.COMPILE_STATUS) !== true && !gl.isContextLost()) {
    throw new Error(`compile a shader: ${gl.getShaderInfoLog(shader) ?? ''}`);
  }
  return shader;
}

/** A texture of single texels, without content. @throws Error when the graphics context is lost */
export function makeTexture(gl: WebGL2RenderingContext): WebGLTexture {
  const texture = gl.createTexture();
  if (texture === null) throw new Error('make a texture: the graphics context is lost');
  gl.bindTexture(gl.TEXTURE_2D, texture);
  for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
    gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
  }
  for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) {
    gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
  }
  return texture;
}
