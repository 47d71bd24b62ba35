/** Opacities of a surface seen straight on, and of its edges. */
const SHEET = 0.35;
const OUTLINE = 0.45;

/** Returns the surfaces from their bytes, see `src/view/report/recording/surface.rs`. */
function surfacesOf(head) {
  const { triangles, edges, vertices, parts, lower, size } = head;
  const bytes = head.bytes.buffer;
  const corners = new Uint32Array(bytes, 0, 3 * triangles);
  const steps = new Uint16Array(bytes, 12 * triangles, 6 * edges + 3 * vertices);
  const normals = new Int8Array(bytes, 12 * (triangles + edges) + 6 * vertices, 3 * vertices);
  const place = (index) => lower[index % 3] + (steps[index] / 65535) * size[index % 3];
  const ends = new Float32Array(6 * edges).map((_, index) => place(index));
  const points = new Float32Array(6 * vertices);
  for (let k = 0; k < 3 * vertices; k += 1) {
    const at = 6 * Math.floor(k / 3) + (k % 3);
    points[at] = place(6 * edges + k);
    points[at + 3] = normals[k] / 127;
  }
  return { parts, corners, ends, points };
}

/** Pose at rest: the columns of the identity matrix, then a displacement of zero. */
const AT_REST = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];

/** Transforms the vectors in a range of indices. `move` is 1 for positions and 0 for directions. */
function posed(from, to, pose, [first, end, stride], move) {
  for (let k = first; k < end; k += stride) {
    const [x, y, z] = [from[k], from[k + 1], from[k + 2]];
    for (let axis = 0; axis < 3; axis += 1) {
      to[k + axis] = pose[axis] * x + pose[3 + axis] * y + pose[6 + axis] * z + move * pose[9 + axis];
    }
  }
}

class Surfaces {
  constructor(renderer, head) {
    const { gl } = renderer;
    this.renderer = renderer;
    this.still = surfacesOf(head);
    this.points = this.still.points.slice();
    this.ends = this.still.ends.slice();
    this.sheets = program(gl, "surface");
    this.pointBuffer = renderer.buffer(this.points);
    this.shape = renderer.shape(this.sheets, [
      ["position", this.pointBuffer, 3, gl.FLOAT, 24, 0, 0],
      ["direction", this.pointBuffer, 3, gl.FLOAT, 24, 12, 0],
    ]);
    this.order = gl.createBuffer();
    this.endBuffer = renderer.buffer(this.ends);
    this.outline = renderer.outline(this.endBuffer);
    this.place([]);
  }

  /** Surfaces that are absent from the frame are left out. */
  place(poses) {
    const key = JSON.stringify(poses);
    if (this.placed === key) {
      return;
    }
    this.placed = key;
    const { parts, corners, points, ends } = this.still;
    const there = [];
    let [triangle, edge, vertex, edges] = [0, 0, 0, 0];
    parts.forEach(([triangleCount, edgeCount, vertexCount], part) => {
      const pose = part < poses.length ? poses[part] : AT_REST;
      if (pose) {
        there.push(corners.subarray(3 * triangle, 3 * (triangle + triangleCount)));
        posed(points, this.points, pose, [6 * vertex, 6 * (vertex + vertexCount), 6], 1);
        posed(points, this.points, pose, [6 * vertex + 3, 6 * (vertex + vertexCount), 6], 0);
        const own = new Float32Array(6 * edgeCount);
        posed(ends.subarray(6 * edge, 6 * (edge + edgeCount)), own, pose, [0, own.length, 3], 1);
        this.ends.set(own, 6 * edges);
        edges += edgeCount;
      }
      triangle += triangleCount;
      edge += edgeCount;
      vertex += vertexCount;
    });
    const count = there.reduce((sum, own) => sum + own.length, 0);
    this.corners = new Uint32Array(count);
    there.reduce((first, own) => (this.corners.set(own, first), first + own.length), 0);
    this.sorted = new Uint32Array(count);
    this.keys = new Uint32Array(count / 3);
    this.depths = new Float32Array(count / 3);
    this.edges = edges;
    this.seen = undefined;
    this.renderer.fill(this.pointBuffer, this.points);
    this.renderer.fill(this.endBuffer, this.ends);
  }

  /** Sorts the triangles by depth, the farthest first. */
  sort(view) {
    const { corners, points, keys, depths, sorted } = this;
    let [least, most] = [Infinity, -Infinity];
    for (let k = 0; k < keys.length; k += 1) {
      let depth = 0;
      for (let corner = 3 * k; corner < 3 * k + 3; corner += 1) {
        const at = 6 * corners[corner];
        depth += view[2] * points[at] + view[6] * points[at + 1] + view[10] * points[at + 2];
      }
      depths[k] = depth;
      least = Math.min(least, depth);
      most = Math.max(most, depth);
    }
    // A key has the depth in the upper 16 bits, and the index of the triangle in the lower 16 bits. A page has fewer
    // than 2^16 triangles.
    const scale = most > least ? 65535 / (most - least) : 0;
    for (let k = 0; k < keys.length; k += 1) {
      keys[k] = Math.round((depths[k] - least) * scale) * 65536 + k;
    }
    keys.sort();
    for (let k = 0; k < keys.length; k += 1) {
      const first = 3 * (keys[k] & 65535);
      sorted[3 * k] = corners[first];
      sorted[3 * k + 1] = corners[first + 1];
      sorted[3 * k + 2] = corners[first + 2];
    }
  }

  draw(camera, scheme) {
    const { renderer } = this;
    const { gl } = renderer;
    const uniforms = renderer.use(this.sheets, camera, scheme);
    gl.uniform3fv(uniforms.colour, scheme.sheet.map((x) => x / 255));
    gl.uniform1f(uniforms.opacity, SHEET);
    gl.bindVertexArray(this.shape);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.order);
    const seen = camera.view.join();
    if (this.seen !== seen) {
      this.seen = seen;
      this.sort(camera.view);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, this.sorted, gl.DYNAMIC_DRAW);
    }
    gl.drawElements(gl.TRIANGLES, this.sorted.length, gl.UNSIGNED_INT, 0);
    renderer.drawEdges(camera, scheme, { shape: this.outline, count: this.edges, width: 0.7, opacity: OUTLINE });
  }
}
