// Light on a surface, in camera space: a key light from the upper left, a weak one from the right, the sky above and the
// ground below. Colours are mixed in linear light.
uniform vec3 up;
uniform vec3 background;
uniform vec2 haze;

// Squares and roots stand for the curve of sRGB: they differ by little and cost less.
vec3 toLinear(vec3 colour) {
  return colour * colour;
}

vec3 lit(vec3 colour, vec3 normal, vec3 place) {
  vec3 eye = normalize(-place);
  const vec3 key = vec3(-0.4510, 0.6214, 0.6407);
  const vec3 side = vec3(0.8703, 0.0544, 0.4895);
  float sky = 0.5 + 0.5 * dot(normal, up);
  vec3 ambient = mix(vec3(0.17, 0.16, 0.17), vec3(0.42, 0.45, 0.50), sky);
  float facing = max(dot(normal, eye), 0.0);
  vec3 light = ambient + 0.78 * max(dot(normal, key), 0.0) + vec3(0.11, 0.10, 0.09) * max(dot(normal, side), 0.0);
  // Neighbours shade the flanks of a sphere: edges are darker, so that spheres of one colour stay apart.
  float night = 1.0 - smoothstep(0.1, 0.6, background.g);
  light *= mix(mix(0.45, 0.75, night), 1.0, smoothstep(0.0, 0.65, facing));
  float shine = max(dot(normal, normalize(key + eye)), 0.0);
  shine *= shine;
  shine *= shine;
  shine *= shine;
  shine *= shine * shine * shine * shine;
  // Before a dark background, dark colours need a rim of light.
  float rim = (1.0 - facing) * (1.0 - facing) * (1.0 - facing) * mix(sky, 1.0, night);
  vec3 seen = toLinear(colour) * light + 0.22 * shine + mix(0.05, 0.20, night) * rim;
  float far = clamp((-place.z - haze.x) / (haze.y - haze.x), 0.0, 1.0);
  seen = mix(seen, toLinear(background), 0.42 * far * far);
  return sqrt(clamp(seen, 0.0, 1.0));
}
