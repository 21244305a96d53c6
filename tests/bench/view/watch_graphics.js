// Runs in the page before its own scripts: counts the bytes of its textures, and times its
// passes. window.watched holds the figures.
(() => {
  const kBytes = {
    RGBA32UI: 16,
    RGBA32I: 16,
    RGBA32F: 16,
    R32UI: 4,
    RGBA8UI: 4,
    RGBA8: 4,
    RGBA16F: 8,
    R8: 1,
    R8UI: 1,
    RGB32F: 12,
    RG32UI: 8,
  };
  const watched = {
    textureBytes: 0,
    // Of each timed pass or band: pixels, milliseconds.
    passes: [],
    isTiming: false,
    renderer: '',
  };
  window.watched = watched;
  const gl2 = WebGL2RenderingContext.prototype;
  const wrap = (name, around) => {
    const plain = gl2[name];
    gl2[name] = function (...args) {
      return around.call(this, plain, args);
    };
  };
  const bytesOf = new WeakMap(); // by texture
  wrap('deleteTexture', function (plain, [texture]) {
    watched.textureBytes -= bytesOf.get(texture) ?? 0;
    bytesOf.delete(texture);
    return plain.call(this, texture);
  });
  const bound = new WeakMap(); // by context: target -> texture
  wrap('bindTexture', function (plain, args) {
    if (!bound.has(this)) bound.set(this, new Map());
    bound.get(this).set(args[0], args[1]);
    return plain.apply(this, args);
  });
  const store = (gl, target, format, texels) => {
    const name = Object.keys(kBytes).find((known) => gl2[known] === format);
    const texture = bound.get(gl)?.get(target);
    const bytes = texels * (kBytes[name] ?? 4);
    watched.textureBytes += bytes - (bytesOf.get(texture) ?? 0);
    bytesOf.set(texture, bytes);
  };
  wrap('texStorage2D', function (plain, args) {
    store(this, args[0], args[2], args[3] * args[4]);
    return plain.apply(this, args);
  });
  wrap('texStorage3D', function (plain, args) {
    store(this, args[0], args[2], args[3] * args[4] * args[5]);
    return plain.apply(this, args);
  });
  wrap('texImage2D', function (plain, args) {
    if (args.length === 9) store(this, args[0], args[2], args[3] * args[4]);
    return plain.apply(this, args);
  });
  // Only passes draw with a scissor box. Reading a pixel back waits until they are done, which
  // finish() does not do in browsers.
  const pixel = new Float32Array(4);
  wrap('drawArrays', function (plain, args) {
    if (watched.renderer === '') {
      const about = this.getExtension('WEBGL_debug_renderer_info');
      watched.renderer = String(this.getParameter(about?.UNMASKED_RENDERER_WEBGL ?? gl2.RENDERER));
    }
    if (!watched.isTiming || !this.isEnabled(gl2.SCISSOR_TEST)) return plain.apply(this, args);
    const box = this.getParameter(gl2.SCISSOR_BOX);
    this.readPixels(box[0], box[1], 1, 1, gl2.RGBA, gl2.FLOAT, pixel);
    const started = performance.now();
    const result = plain.apply(this, args);
    this.readPixels(box[0], box[1], 1, 1, gl2.RGBA, gl2.FLOAT, pixel);
    watched.passes.push([box[2] * box[3], performance.now() - started]);
    return result;
  });
})();
