/** Largest number of particles in a picture with shadows. */
const MOST_SHADED = 20000;

/** Largest distance at which spheres occlude each other, in radii of the largest sphere. */
const SHADE = 2.2;

/** Ambient occlusion of the opaque parts of a picture, which are drawn a second time for their depths. */
class Occlusion {
  constructor(renderer) {
    const { gl } = renderer;
    this.renderer = renderer;
    this.shade = program(gl, "occlusion");
    this.depths = gl.createTexture();
    this.target = gl.createFramebuffer();
    this.size = [0, 0];
  }

  /** Gives the depth buffer the size of the picture. */
  resize() {
    const { renderer: { gl, canvas }, size } = this;
    if (size[0] === canvas.width && size[1] === canvas.height) {
      return;
    }
    this.size = [canvas.width, canvas.height];
    gl.bindTexture(gl.TEXTURE_2D, this.depths);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.DEPTH_COMPONENT24, ...this.size, 0, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, null);
    for (const [name, value] of [
      [gl.TEXTURE_MIN_FILTER, gl.NEAREST], [gl.TEXTURE_MAG_FILTER, gl.NEAREST], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
    ]) {
      gl.texParameteri(gl.TEXTURE_2D, name, value);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.depths, 0);
    gl.drawBuffers([gl.NONE]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /** Darkens the objects that `drawOpaque` draws. */
  draw(camera, scheme, drawOpaque) {
    const { renderer, renderer: { gl } } = this;
    this.resize();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    drawOpaque();
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const uniforms = renderer.use(this.shade, camera, scheme);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.depths);
    gl.uniform1i(uniforms.depths, 0);
    gl.uniform2f(uniforms.viewport, ...this.size);
    gl.uniform1f(uniforms.reach, SHADE * renderer.largest);
    gl.bindVertexArray(renderer.nothing);
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ZERO, gl.SRC_COLOR);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
  }
}
