// The sphere itself: where the line of sight meets it. With DISC its depth is that of a disc through its centre: spheres of a
// few pixels look the same, and what is hidden is not shaded.
flat in vec3 centre;
flat in float extent;
flat in vec3 colour;
flat in float glow;
flat in vec4 turn;
in vec3 ray;

uniform mat4 projection;
uniform float pixel;
uniform float opacity;
uniform vec3 flash;
uniform mat4 view;
uniform bool isMarked;

out vec4 fragment;

// How dark the mark of a turned sphere is, 0 to 1, at a place with the given normal. Two opposite quarters of the sphere
// are dark, so that a turn about any axis can be seen. `width` is the size of a pixel relative to the radius.
float mark(vec3 normal, float width) {
  vec3 world = transpose(mat3(view)) * normal;
  vec4 q = normalize(turn);
  vec3 body = world - 2.0 * cross(q.xyz, q.w * world - cross(q.xyz, world));
  vec3 before = smoothstep(-width, width, body);
  return max(min(before.x, before.z), min(1.0 - before.x, 1.0 - before.z));
}

void main() {
  vec3 sight = normalize(ray);
  float along = dot(sight, centre);
  // The miss distance, without the cancellation of two large squares.
  vec3 miss = sight * along - centre;
  float distance = length(miss);
  float cover = clamp((extent - distance) / (pixel * along) + 0.5, 0.0, 1.0);
  if (cover <= 0.0) {
    discard;
  }
  float depth = sqrt(max(extent * extent - distance * distance, 0.0));
  vec3 place = sight * (along - depth);
  vec3 normal = normalize(place - centre);
#ifndef DISC
  vec4 clip = projection * vec4(place, 1.0);
  gl_FragDepth = 0.5 * clip.z / clip.w + 0.5;
#endif
  float glass = opacity < 1.0 ? 0.6 + 1.8 * (1.0 + dot(normal, sight)) * (1.0 + dot(normal, sight)) : 1.0;
  vec3 paint = isMarked ? colour * (1.0 - 0.35 * mark(normal, pixel * along / extent)) : colour;
  fragment = vec4(mix(lit(paint, normal, place), flash, 0.9 * glow), cover * min(opacity * glass, 1.0));
}
