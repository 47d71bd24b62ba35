#version 300 es
// How much of the sky what is near hides from a point, from the depths of the picture.
precision highp float;

in vec2 at;

uniform highp sampler2D depths;
uniform mat4 projection;
uniform vec2 viewport;
// How far away things hide the sky.
uniform float reach;

out vec4 fragment;

const int SAMPLES = 28;
// The angle by which the leaves of a sunflower follow each other: samples are nowhere close to each other.
const float GOLDEN = 2.399963;

vec3 placeAt(vec2 seen) {
  float depth = 2.0 * texture(depths, seen).r - 1.0;
  float z = -projection[3][2] / (depth + projection[2][2]);
  return vec3((2.0 * seen - 1.0) * -z / vec2(projection[0][0], projection[1][1]), z);
}

vec3 shorter(vec3 a, vec3 b) {
  return abs(a.z) < abs(b.z) ? a : b;
}

// The farthest of a pixel and its neighbours: a smoothed outline shows some of what is behind it, which is darker.
vec2 farthest() {
  vec2 pixel = 1.0 / viewport;
  vec2 found = at;
  float depth = texture(depths, at).r;
  for (int k = 0; k < 4; k += 1) {
    vec2 beside = at + pixel * vec2[4](vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0))[k];
    float there = texture(depths, beside).r;
    if (there < 1.0 && there > depth) {
      found = beside;
      depth = there;
    }
  }
  return found;
}

void main() {
  if (texture(depths, at).r >= 1.0) {
    discard;
  }
  vec2 seen = farthest();
  vec3 place = placeAt(seen);
  vec2 pixel = 1.0 / viewport;
  // At an outline one of the neighbours is on something else.
  vec3 right = shorter(placeAt(seen + vec2(pixel.x, 0.0)) - place, place - placeAt(seen - vec2(pixel.x, 0.0)));
  vec3 above = shorter(placeAt(seen + vec2(0.0, pixel.y)) - place, place - placeAt(seen - vec2(0.0, pixel.y)));
  vec3 normal = normalize(cross(right, above));
  vec2 size = 0.5 * reach * vec2(projection[0][0], projection[1][1]) / -place.z;
  float hidden = 0.0;
  for (int k = 0; k < SAMPLES; k += 1) {
    float angle = GOLDEN * float(k);
    vec2 offset = size * sqrt((float(k) + 0.5) / float(SAMPLES)) * vec2(cos(angle), sin(angle));
    vec3 way = placeAt(seen + offset) - place;
    float far = length(way);
    float nearness = max(1.0 - far * far / (reach * reach), 0.0);
    hidden += nearness * max(dot(normal, way) / max(far, 1e-30) - 0.1, 0.0);
  }
  fragment = vec4(vec3(1.0 - min(2.4 * hidden / float(SAMPLES), 0.8)), 1.0);
}
