#version 300 es
// A square that covers the outline of a sphere in perspective, and a margin of a pixel. Spheres come from tables, six corners
// each: instances of so few corners are slow on many graphics processors, and very slow in software.
precision highp float;

// Position and radius (negative: nothing is drawn), what the colour stands for and how bright it flashes, in rows of 2048.
uniform highp sampler2D spheres;
uniform highp sampler2D tones;
// Orientations as quaternions.
uniform highp sampler2D turns;

uniform mat4 view;
uniform mat4 projection;
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
flat out float glow;
flat out vec4 turn;
out vec3 ray;

const vec2 CORNERS[6] = vec2[6](
  vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(-1.0, 1.0), vec2(-1.0, 1.0), vec2(1.0, -1.0), vec2(1.0, 1.0)
);

void main() {
  int number = gl_VertexID / 6;
  ivec2 cell = ivec2(number & 2047, number >> 11);
  vec4 sphere = texelFetch(spheres, cell, 0);
  vec2 letters = texelFetch(tones, cell, 0).rg;
  float tone = letters.r;
  glow = letters.g;
  turn = texelFetch(turns, cell, 0);
  float radius = sphere.w;
  vec2 corner = CORNERS[gl_VertexID % 6];
  centre = (view * vec4(sphere.xyz, 1.0)).xyz;
  extent = radius;
  float far = length(centre);
  if (radius < 0.0 || far <= 1.02 * radius || centre.z > 0.0) {
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
