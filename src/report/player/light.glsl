// Light on a surface, in camera space: a key light from the upper left, a weak one from the right, the sky above and the
// ground below. Colours are mixed in linear light.
uniform vec3 up;
uniform vec3 background;
uniform vec2 haze;

vec3 toLinear(vec3 colour) {
  return pow(colour, vec3(2.2));
}

vec3 lit(vec3 colour, vec3 normal, vec3 place) {
  vec3 eye = normalize(-place);
  vec3 key = normalize(vec3(-0.45, 0.62, 0.64));
  vec3 side = normalize(vec3(0.80, 0.05, 0.45));
  float sky = 0.5 + 0.5 * dot(normal, up);
  vec3 ambient = mix(vec3(0.17, 0.16, 0.17), vec3(0.42, 0.45, 0.50), sky);
  float facing = max(dot(normal, eye), 0.0);
  vec3 light = ambient + 0.78 * max(dot(normal, key), 0.0) + vec3(0.11, 0.10, 0.09) * max(dot(normal, side), 0.0);
  // Neighbours shade the flanks of a sphere: edges are darker, so that spheres of one colour stay apart.
  float night = 1.0 - smoothstep(0.1, 0.6, background.g);
  light *= mix(mix(0.45, 0.75, night), 1.0, smoothstep(0.0, 0.65, facing));
  float shine = pow(max(dot(normal, normalize(key + eye)), 0.0), 42.0);
  // Before a dark background, dark colours need a rim of light.
  float rim = pow(1.0 - facing, 3.0) * mix(sky, 1.0, night);
  vec3 seen = toLinear(colour) * light + 0.22 * shine + mix(0.05, 0.20, night) * rim;
  float far = clamp((-place.z - haze.x) / (haze.y - haze.x), 0.0, 1.0);
  seen = mix(seen, toLinear(background), 0.42 * far * far);
  return pow(clamp(seen, 0.0, 1.0), vec3(1.0 / 2.2));
}
