/** Shader sources, bundled as texts. */
declare module '*.glsl' {
  const source: string;
  export default source;
}
