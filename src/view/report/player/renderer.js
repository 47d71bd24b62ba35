/** Light and dark colour schemes, sRGB. A flashing particle takes the colour of the flash. */
const SCHEMES = {
  light: {
    background: [0.969, 0.973, 0.98], ink: [0.27, 0.3, 0.34, 0.85], fixed: [144, 153, 168], sheet: [156, 174, 198], flash: [0.87, 0.2, 0.08],
  },
  dark: {
    background: [0.075, 0.082, 0.098], ink: [0.62, 0.66, 0.72, 0.8], fixed: [132, 141, 156], sheet: [126, 146, 172], flash: [1, 0.96, 0.82],
  },
};

/** Radius below which spheres are drawn as discs if there are very many `[pixels]`. */
const SMALL = 10;

/** Number of spheres in a row of a table, as in sphere.vert. */
const ROW = 2048;

/** Compiles a program. The inputs of all programs have the same locations, by their order here. */
function program(gl, name, definitions = "") {
  const text = (id) => document.getElementById(`shader-${id}`).textContent.trim();
  const lit = `#version 300 es\nprecision highp float;\n${definitions}\n${text("light")}\n`;
  const fragment = text(`${name}.frag`);
  const sources = [
    [gl.VERTEX_SHADER, text(`${name}.vert`)],
    [gl.FRAGMENT_SHADER, fragment.startsWith("#version") ? fragment : lit + fragment],
  ];
  const linked = gl.createProgram();
  for (const [kind, source] of sources) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
      throw new Error(`${name}: ${gl.getShaderInfoLog(shader)}`);
    }
    gl.attachShader(linked, shader);
  }
  gl.linkProgram(linked);
  if (!gl.getProgramParameter(linked, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(`${name}: ${gl.getProgramInfoLog(linked)}`);
  }
  const uniforms = {};
  for (let k = 0; k < gl.getProgramParameter(linked, gl.ACTIVE_UNIFORMS); k += 1) {
    const { name: uniform } = gl.getActiveUniform(linked, k);
    uniforms[uniform] = gl.getUniformLocation(linked, uniform);
  }
  return { linked, uniforms, place: (attribute) => gl.getAttribLocation(linked, attribute) };
}

/**
 * Draws particles into a canvas. `particles` has the numbers of `moving` and `fixed` particles; `radii` and `species`
 * of all particles, moving ones first; `fixedPositions`; `bonds` with `bondEnds` and `bondRadii`; the axes that are
 * `flat` and `periodic`; and `surfaces`, if any.
 */
class Renderer {
  constructor(canvas, particles) {
    const isLarge = particles.moving + particles.fixed > 50000;
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: !isLarge, preserveDrawingBuffer: true });
    if (!gl) {
      throw new Error("This browser offers no WebGL 2, which the player needs. Everything else on this page is complete.");
    }
    this.gl = gl;
    this.canvas = canvas;
    this.sharpest = isLarge ? 1 : 2;
    this.hasCoverage = gl.getParameter(gl.SAMPLES) > 1;
    this.whole = program(gl, "sphere");
    this.discs = isLarge ? program(gl, "sphere", "#define DISC") : this.whole;
    this.rods = program(gl, "rod");
    this.edges = program(gl, "edge");
    this.quad = this.buffer(new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]));
    this.tube = this.buffer(tube());
    this.nothing = gl.createVertexArray();
    this.rodEnds = this.buffer(new Float32Array(0));
    this.rodShape = this.shape(this.rods, [
      ["corner", this.tube, 3, gl.FLOAT, 12, 0, 0],
      ["start", this.rodEnds, 3, gl.FLOAT, 28, 0, 1],
      ["end", this.rodEnds, 3, gl.FLOAT, 28, 12, 1],
      ["radius", this.rodEnds, 1, gl.FLOAT, 28, 24, 1],
    ]);
    this.edgeEnds = this.buffer(new Float32Array(0));
    this.edgeShape = this.outline(this.edgeEnds);
    this.colours = gl.createTexture();
    this.show(particles);
  }

  show(particles) {
    for (const table of this.particles ? [this.moving, this.pivots, this.mesh] : []) {
      this.free(table);
    }
    this.images?.free();
    this.particles = particles;
    this.largest = particles.radii.reduce((most, radius) => Math.max(most, radius), 0);
    this.moving = this.spheres(particles.moving);
    this.images = new Images(this);
    this.makeFixed();
    this.surfaces = particles.surfaces ? new Surfaces(this, particles.surfaces) : undefined;
    this.state = undefined;
  }

  buffer(data) {
    const { gl } = this;
    const made = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, made);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return made;
  }

  fill(buffer, data) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
  }

  /**
   * Creates a shape from its attributes: name, buffer, number and type of components, stride, offset, whether there is
   * one value per instance, and whether bytes represent fractions.
   */
  shape(used, attributes) {
    const { gl } = this;
    const made = gl.createVertexArray();
    gl.bindVertexArray(made);
    for (const [name, buffer, number, type, stride, offset, divisor, isFraction = false] of attributes) {
      const place = used.place(name);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, number, type, isFraction, stride, offset);
      gl.vertexAttribDivisor(place, divisor);
    }
    gl.bindVertexArray(null);
    return made;
  }

  /** Creates the shape of edges with equal width and colour. */
  outline(ends) {
    const { gl } = this;
    return this.shape(this.edges, [
      ["corner", this.quad, 2, gl.FLOAT, 8, 0, 0],
      ["start", ends, 3, gl.FLOAT, 24, 0, 1],
      ["end", ends, 3, gl.FLOAT, 24, 12, 1],
    ]);
  }

  /** Creates a table of spheres for the shader: positions and radii, tones and flashes, and orientations. */
  spheres(count) {
    const { gl } = this;
    const rows = Math.max(1, Math.ceil(count / ROW));
    const texture = () => {
      const made = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, made);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      return made;
    };
    const numbers = new Float32Array(4 * ROW * rows);
    return { count, rows, numbers, letters: new Uint8Array(2 * ROW * rows), places: texture(), tones: texture(), turns: texture() };
  }

  free({ places, tones, turns }) {
    [places, tones, turns].forEach((texture) => this.gl.deleteTexture(texture));
  }

  /** Uploads a table to the graphics processor. */
  upload(table) {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, table.places);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, ROW, table.rows, 0, gl.RGBA, gl.FLOAT, table.numbers);
    gl.bindTexture(gl.TEXTURE_2D, table.tones);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG8, ROW, table.rows, 0, gl.RG, gl.UNSIGNED_BYTE, table.letters);
    if (table.quaternions) {
      gl.bindTexture(gl.TEXTURE_2D, table.turns);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8_SNORM, ROW, table.rows, 0, gl.RGBA, gl.BYTE, table.quaternions);
    }
  }

  /**
   * Creates the tables of static particles. Those with a bond are drawn with the bonded objects; all others form a
   * mesh.
   */
  makeFixed() {
    const { moving, fixed, radii, species, fixedPositions, bondEnds } = this.particles;
    const holding = new Set(bondEnds);
    const group = (isWanted) => {
      const chosen = [...Array(fixed).keys()].filter((k) => isWanted(moving + k));
      const table = this.spheres(chosen.length);
      chosen.forEach((k, index) => {
        table.numbers.set(fixedPositions.subarray(3 * k, 3 * k + 3), 4 * index);
        table.numbers[4 * index + 3] = radii[moving + k];
        table.letters[2 * index] = species[moving + k];
      });
      this.upload(table);
      return table;
    };
    this.pivots = group((k) => holding.has(k));
    this.mesh = group((k) => !holding.has(k));
  }

  /** Sets the colour texture: a row of species colours, and a row of the colour scale. */
  setColours(palette, scale) {
    const { gl } = this;
    const pixels = new Uint8Array(2 * 256 * 4).fill(255);
    for (let k = 0; k < 256; k += 1) {
      pixels.set(palette[k] ?? [128, 128, 128], 4 * k);
      pixels.set(scale[k], 4 * (256 + k));
    }
    gl.bindTexture(gl.TEXTURE_2D, this.colours);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 256, 2, 0, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  /**
   * Loads a state of the particles: `positions` of the moving ones (NaN for a hidden particle), their `tones` in 255
   * steps of a `range` and the `scale` of the colours (without tones, particles have the colours of their species), the
   * brightness of each particle's flash (`flashes`) in 255 steps, the orientations (`turns`) as quaternions in 1/127, which
   * a mark on each particle shows, the `growth` of their radii, the `box` with its
   * `displacement` along x from one image to the next one up along y, and the `poses` of the surfaces. All parts are
   * optional.
   */
  load(state) {
    const { moving, particles: { radii, species, bonds, flat } } = this;
    const { positions, tones = species, flashes, growth = 1 } = state;
    this.state = state;
    const { numbers, letters } = moving;
    for (let k = 0; k < moving.count; k += 1) {
      const isSeen = positions[3 * k] === positions[3 * k];
      numbers[4 * k] = positions[3 * k];
      numbers[4 * k + 1] = positions[3 * k + 1];
      numbers[4 * k + 2] = positions[3 * k + 2];
      numbers[4 * k + 3] = isSeen ? growth * radii[k] : -1;
      letters[2 * k] = tones[k];
      letters[2 * k + 1] = flashes ? flashes[k] : 0;
    }
    moving.quaternions = state.turns && (moving.quaternions ?? new Int8Array(4 * ROW * moving.rows));
    moving.quaternions?.set(state.turns);
    this.upload(moving);
    this.images.load(state);
    if (bonds > 0) {
      this.fill(this.rodEnds, bondRods(this.particles, state));
    }
    this.surfaces?.place(state.poses ?? []);
    this.boxEdges = boxEdges(state.box, flat);
    this.fill(this.edgeEnds, this.boxEdges);
  }

  /** Gives the canvas its size on the page. Returns its aspect ratio (width over height). */
  resize() {
    const { canvas } = this;
    const ratio = Math.min(window.devicePixelRatio || 1, this.sharpest);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    return width / height;
  }

  use(used, camera, scheme) {
    const { gl } = this;
    gl.useProgram(used.linked);
    const { uniforms } = used;
    gl.uniformMatrix4fv(uniforms.view, false, camera.view);
    gl.uniformMatrix4fv(uniforms.projection, false, camera.projection);
    gl.uniform3fv(uniforms.up ?? null, camera.up);
    gl.uniform3fv(uniforms.background ?? null, scheme.background);
    gl.uniform3fv(uniforms.flash ?? null, scheme.flash);
    gl.uniform2fv(uniforms.haze ?? null, camera.haze);
    return uniforms;
  }

  /** Draws lines. `width` is relative to the width of box edges. */
  drawEdges(camera, scheme, { shape, count, width, opacity }) {
    const { gl, canvas } = this;
    const uniforms = this.use(this.edges, camera, scheme);
    const [red, green, blue, alpha] = scheme.ink;
    gl.uniform2f(uniforms.viewport, canvas.width, canvas.height);
    gl.uniform1f(uniforms.width, width * Math.max(1.4, canvas.width / 700));
    gl.uniform1f(uniforms.nearest, camera.near);
    gl.uniform4f(uniforms.ink, red, green, blue, alpha * opacity);
    gl.bindVertexArray(shape);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
  }

  draw(camera, scheme, { hasBox, fixed, hasSurfaces, hasImages = true, hasShadows = false, hasMarks = true }) {
    const { gl, canvas } = this;
    this.isMarked = hasMarks;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...scheme.background, 1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    const drawOpaque = () => this.drawOpaque(camera, scheme, fixed, hasImages);
    drawOpaque();
    if (hasShadows) {
      this.occlusion ??= new Occlusion(this);
      this.occlusion.draw(camera, scheme, drawOpaque);
    }
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    if (hasBox) {
      this.drawEdges(camera, scheme, { shape: this.edgeShape, count: this.boxEdges.length / 6, width: 1, opacity: 1 });
    }
    if (fixed === "veil") {
      const uniforms = this.useSpheres(this.whole, camera, scheme);
      this.drawGroup(uniforms, this.mesh, 0.17);
    }
    if (hasSurfaces) {
      this.surfaces?.draw(camera, scheme);
    }
    gl.bindVertexArray(null);
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
  }

  drawOpaque(camera, scheme, fixed, hasImages) {
    const { gl } = this;
    this.drawSpheres(camera, scheme, fixed, hasImages);
    if (this.particles.bonds > 0) {
      const uniforms = this.use(this.rods, camera, scheme);
      gl.uniform3fv(uniforms.colour, scheme.fixed.map((x) => x / 255));
      gl.bindVertexArray(this.rodShape);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 2 * SIDES + 2, 2 * this.particles.bonds);
    }
  }

  /** Returns whether the graphics processor is still drawing the last picture. */
  isBusy() {
    const { gl, fence } = this;
    if (!fence || gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.UNSIGNALED) {
      return Boolean(fence);
    }
    gl.deleteSync(fence);
    this.fence = undefined;
    return false;
  }

  drawSpheres(camera, scheme, fixed, hasImages) {
    const { gl } = this;
    const size = (this.largest / (2 * SLOPE * camera.distance)) * this.canvas.height;
    const uniforms = this.useSpheres(size < SMALL ? this.discs : this.whole, camera, scheme);
    if (this.hasCoverage) {
      gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    }
    gl.uniform1i(uniforms.isSpecies, this.state.tones ? 0 : 1);
    this.drawGroup(uniforms, this.moving, 1);
    if (hasImages) {
      this.images.draw(uniforms);
    }
    gl.uniform1i(uniforms.isSpecies, 1);
    this.drawGroup(uniforms, this.pivots, 1);
    if (fixed === "solid") {
      this.drawGroup(uniforms, this.mesh, 1);
    }
    gl.disable(gl.SAMPLE_ALPHA_TO_COVERAGE);
  }

  useSpheres(used, camera, scheme) {
    const { gl, state } = this;
    const uniforms = this.use(used, camera, scheme);
    gl.uniform1f(uniforms.pixel, (2 * SLOPE) / this.canvas.height);
    gl.uniform2fv(uniforms.range, state.range ?? [0, 1]);
    gl.uniform2fv(uniforms.scale, state.scale ?? [0, 1]);
    gl.uniform1i(uniforms.isSpecies, 1);
    return uniforms;
  }

  drawGroup(uniforms, table, opacity) {
    const { gl } = this;
    [this.colours, table.places, table.tones, table.turns].forEach((texture, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
    });
    gl.activeTexture(gl.TEXTURE0);
    gl.uniform1i(uniforms.colours, 0);
    gl.uniform1i(uniforms.spheres, 1);
    gl.uniform1i(uniforms.tones, 2);
    gl.uniform1i(uniforms.turns, 3);
    gl.uniform1i(uniforms.isMarked, table.quaternions && this.isMarked ? 1 : 0);
    gl.uniform1f(uniforms.opacity, opacity);
    gl.bindVertexArray(this.nothing);
    gl.drawArrays(gl.TRIANGLES, 0, 6 * table.count);
  }
}
