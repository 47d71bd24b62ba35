/** Light and dark surroundings of the particles, sRGB. */
const SCHEMES = {
  light: { background: [0.969, 0.973, 0.98], ink: [0.27, 0.3, 0.34, 0.85], fixed: [144, 153, 168] },
  dark: { background: [0.075, 0.082, 0.098], ink: [0.62, 0.66, 0.72, 0.8], fixed: [132, 141, 156] },
};

/** Sides of a bond. */
const SIDES = 14;

/** Compiles a program; its inputs have the same places in all programs, by their order here. */
function program(gl, name) {
  const text = (id) => document.getElementById(`shader-${id}`).textContent.trim();
  const lit = `#version 300 es\nprecision highp float;\n${text("light")}\n`;
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

/** Draws frames into a canvas. */
class Renderer {
  constructor(canvas, recording) {
    const isLarge = recording.count > 50000;
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: !isLarge, preserveDrawingBuffer: true });
    if (!gl) {
      throw new Error("This browser offers no WebGL 2, which the player needs. Everything else on this page is complete.");
    }
    this.gl = gl;
    this.canvas = canvas;
    this.recording = recording;
    this.sharpest = isLarge ? 1 : 2;
    this.hasCoverage = gl.getParameter(gl.SAMPLES) > 1;
    this.spheres = program(gl, "sphere");
    this.rods = program(gl, "rod");
    this.edges = program(gl, "edge");
    this.quad = this.buffer(new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]));
    this.tube = this.buffer(tube());
    this.makeMoving();
    this.makeFixed();
    this.rodEnds = this.buffer(new Float32Array(0));
    this.rodShape = this.shape(this.rods, [
      ["corner", this.tube, 3, gl.FLOAT, 12, 0, 0],
      ["start", this.rodEnds, 3, gl.FLOAT, 28, 0, 1],
      ["end", this.rodEnds, 3, gl.FLOAT, 28, 12, 1],
      ["radius", this.rodEnds, 1, gl.FLOAT, 28, 24, 1],
    ]);
    this.edgeEnds = this.buffer(new Float32Array(0));
    this.edgeShape = this.shape(this.edges, [
      ["corner", this.quad, 2, gl.FLOAT, 8, 0, 0],
      ["start", this.edgeEnds, 3, gl.FLOAT, 24, 0, 1],
      ["end", this.edgeEnds, 3, gl.FLOAT, 24, 12, 1],
    ]);
    this.colours = gl.createTexture();
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

  /** Attributes: name, buffer, number and type of components, stride, offset, and whether one per instance. */
  shape(used, attributes) {
    const { gl } = this;
    const made = gl.createVertexArray();
    gl.bindVertexArray(made);
    for (const [name, buffer, number, type, stride, offset, divisor] of attributes) {
      const place = used.place(name);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, number, type, type !== gl.FLOAT, stride, offset);
      gl.vertexAttribDivisor(place, divisor);
    }
    gl.bindVertexArray(null);
    return made;
  }

  sphereShape(positions, type, radii, tones) {
    const { gl } = this;
    return this.shape(this.spheres, [
      ["corner", this.quad, 2, gl.FLOAT, 8, 0, 0],
      ["position", positions, 3, type, type === gl.FLOAT ? 12 : 6, 0, 1],
      ["radius", radii, 1, gl.FLOAT, 4, 0, 1],
      ["tone", tones, 1, gl.UNSIGNED_BYTE, 1, 0, 1],
    ]);
  }

  makeMoving() {
    const { gl, recording } = this;
    const { moving } = recording.head;
    this.steps = this.buffer(new Uint16Array(3 * moving));
    this.tones = this.buffer(new Uint8Array(moving));
    const radii = this.buffer(recording.radii.subarray(0, moving));
    this.moving = { count: moving, shape: this.sphereShape(this.steps, gl.UNSIGNED_SHORT, radii, this.tones) };
  }

  /** Static particles that hold a bond are part of what they hold; the others are a mesh. */
  makeFixed() {
    const { gl, recording } = this;
    const { moving, fixed } = recording.head;
    const holding = new Set(recording.bondEnds);
    const group = (isWanted) => {
      const chosen = [...Array(fixed).keys()].filter((k) => isWanted(moving + k));
      const positions = new Float32Array(chosen.flatMap((k) => [...recording.fixedPositions.subarray(3 * k, 3 * k + 3)]));
      const radii = this.buffer(Float32Array.from(chosen, (k) => recording.radii[moving + k]));
      const tones = this.buffer(Uint8Array.from(chosen, (k) => recording.species[moving + k]));
      return { count: chosen.length, shape: this.sphereShape(this.buffer(positions), gl.FLOAT, radii, tones) };
    };
    this.pivots = group((k) => holding.has(k));
    this.mesh = group((k) => !holding.has(k));
  }

  /** A row of species colours, and one of the scale. */
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

  /** Takes over a frame, coloured by a channel or, with -1, by species. */
  load(frame, channel) {
    const { recording } = this;
    this.frame = frame;
    this.channel = channel;
    this.fill(this.steps, frame.steps);
    this.fill(this.tones, channel < 0 ? recording.species.subarray(0, recording.head.moving) : frame.channels[channel]);
    if (recording.head.bonds > 0) {
      this.fill(this.rodEnds, recording.rods(frame));
    }
    this.boxEdges = boxEdges(frame.head, recording.head.flat);
    this.fill(this.edgeEnds, this.boxEdges);
  }

  /** Fits the pixels of the canvas to its place on the page; returns its width over its height. */
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
    gl.uniform2fv(uniforms.haze ?? null, camera.haze);
    return uniforms;
  }

  draw(camera, scheme, { hasBox, fixed }) {
    const { gl, canvas } = this;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...scheme.background, 1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    this.drawSpheres(camera, scheme, fixed);
    if (this.recording.head.bonds > 0) {
      const uniforms = this.use(this.rods, camera, scheme);
      gl.uniform3fv(uniforms.colour, scheme.fixed.map((x) => x / 255));
      gl.bindVertexArray(this.rodShape);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 2 * SIDES + 2, 2 * this.recording.head.bonds);
    }
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    if (hasBox) {
      const uniforms = this.use(this.edges, camera, scheme);
      gl.uniform2f(uniforms.viewport, canvas.width, canvas.height);
      gl.uniform1f(uniforms.width, Math.max(1.4, canvas.width / 700));
      gl.uniform1f(uniforms.nearest, camera.near);
      gl.uniform4fv(uniforms.ink, scheme.ink);
      gl.bindVertexArray(this.edgeShape);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.boxEdges.length / 6);
    }
    if (fixed === "veil") {
      const uniforms = this.use(this.spheres, camera, scheme);
      this.drawGroup(uniforms, this.mesh, 0.17);
    }
    gl.bindVertexArray(null);
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
  }

  /** Whether the graphics processor has not yet finished the last picture. */
  isBusy() {
    const { gl, fence } = this;
    if (!fence || gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.UNSIGNALED) {
      return Boolean(fence);
    }
    gl.deleteSync(fence);
    this.fence = undefined;
    return false;
  }

  drawSpheres(camera, scheme, fixed) {
    const { gl, canvas, frame } = this;
    const uniforms = this.use(this.spheres, camera, scheme);
    gl.bindTexture(gl.TEXTURE_2D, this.colours);
    gl.uniform1i(uniforms.colours, 0);
    gl.uniform1f(uniforms.pixel, (2 * SLOPE) / canvas.height);
    gl.uniform3fv(uniforms.lower, frame.head.field[0]);
    gl.uniform3fv(uniforms.size, frame.head.field[1]);
    const isSpecies = this.channel < 0;
    const { low, high } = isSpecies ? { low: 0, high: 1 } : this.recording.head.channels[this.channel];
    gl.uniform2fv(uniforms.range, isSpecies ? [0, 1] : frame.head.ranges[this.channel]);
    gl.uniform2f(uniforms.scale, low, high);
    if (this.hasCoverage) {
      gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    }
    gl.uniform1i(uniforms.isQuantised, 1);
    gl.uniform1i(uniforms.isSpecies, isSpecies ? 1 : 0);
    gl.uniform1f(uniforms.opacity, 1);
    gl.bindVertexArray(this.moving.shape);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.moving.count);
    this.drawGroup(uniforms, this.pivots, 1);
    if (fixed === "solid") {
      this.drawGroup(uniforms, this.mesh, 1);
    }
    gl.disable(gl.SAMPLE_ALPHA_TO_COVERAGE);
  }

  drawGroup(uniforms, group, opacity) {
    const { gl } = this;
    gl.uniform1i(uniforms.isQuantised, 0);
    gl.uniform1i(uniforms.isSpecies, 1);
    gl.uniform1f(uniforms.opacity, opacity);
    gl.bindVertexArray(group.shape);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, group.count);
  }
}

/** A strip around a cylinder: the normal across its axis, and which end. */
function tube() {
  const strip = [];
  for (let side = 0; side <= SIDES; side += 1) {
    const angle = (2 * Math.PI * side) / SIDES;
    strip.push(Math.cos(angle), Math.sin(angle), 0, Math.cos(angle), Math.sin(angle), 1);
  }
  return new Float32Array(strip);
}

/** The edges of the box that have a length, each once. */
function boxEdges({ lower, size }, flat) {
  const edges = [];
  const corner = (index) => [0, 1, 2].map((k) => lower[k] + ((index >> k) & 1 ? size[k] : 0));
  for (let axis = 0; axis < 3; axis += 1) {
    for (let index = 0; index < 8; index += 1) {
      const isOnce = [0, 1, 2].every((k) => !flat[k] || !((index >> k) & 1));
      if (!flat[axis] && !((index >> axis) & 1) && isOnce) {
        edges.push(...corner(index), ...corner(index | (1 << axis)));
      }
    }
  }
  return new Float32Array(edges);
}
