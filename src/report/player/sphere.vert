#version 300 es
// A square that covers the outline of a sphere in perspective, and a margin of a pixel.
precision highp float;

in vec2 corner;
in vec3 position;
in float radius;
in float tone;

uniform mat4 view;
uniform mat4 projection;
// The field that coordinates are fractions of.
uniform vec3 lower;
uniform vec3 size;
uniform bool isQuantised;
// What the tones 0 and 1 stand for, and the ends of the scale of colours.
uniform vec2 range;
uniform vec2 scale;
uniform bool isSpecies;
// Size of a pixel at a distance of 1.
uniform float pixel;
uniform highp sampler2D colours;

flat out vec3 centre;
flat out float extent;
flat out vec3 colour;
out vec3 ray;

void main() {
  bool isBeyond = isQuantised && position.x > 0.999995;
  vec3 place = isQuantised ? lower + position * (65535.0 / 65534.0) * size : position;
  centre = (view * vec4(place, 1.0)).xyz;
  extent = radius;
  float far = length(centre);
  if (isBeyond || far <= 1.02 * radius || centre.z > 0.0) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  vec3 ahead = centre / far;
  vec3 right = normalize(cross(ahead, abs(ahead.y) < 0.99 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
  vec3 above = cross(right, ahead);
  float reach = radius * far / sqrt(far * far - radius * radius) + 1.5 * pixel * far;
  ray = centre + (corner.x * right + corner.y * above) * reach;
  int index = int(round(tone * 255.0));
  if (isSpecies) {
    colour = texelFetch(colours, ivec2(index, 0), 0).rgb;
  } else {
    float value = (mix(range.x, range.y, tone) - scale.x) / (scale.y - scale.x);
    colour = texelFetch(colours, ivec2(int(round(clamp(value, 0.0, 1.0) * 255.0)), 1), 0).rgb;
  }
  gl_Position = projection * vec4(ray, 1.0);
}
