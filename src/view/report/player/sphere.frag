// The sphere itself: where the line of sight meets it. With DISC its depth is that of a disc through its centre: spheres of a
// few pixels look the same, and what is hidden is not shaded.
flat in vec3 centre;
flat in float extent;
flat in vec3 colour;
flat in float glow;
in vec3 ray;

uniform mat4 projection;
uniform float pixel;
uniform float opacity;
uniform vec3 flash;

out vec4 fragment;

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
  fragment = vec4(mix(lit(colour, normal, place), flash, 0.9 * glow), cover * min(opacity * glass, 1.0));
}
