#version 300 es
// A line of some pixels, with a width at each end: a trail, or the shaft or the head of an arrow.
precision highp float;

in vec2 corner;
in vec3 start;
in vec3 end;
in vec2 widths;
in vec4 ink;

uniform mat4 view;
uniform mat4 projection;
uniform vec2 viewport;
uniform float nearest;
// How far the line is drawn towards the eye, so that the sphere that it belongs to does not hide it.
uniform float lift;

out vec4 colour;

void main() {
  vec3 a = (view * vec4(start, 1.0)).xyz;
  vec3 b = (view * vec4(end, 1.0)).xyz;
  if (a.z > -nearest || b.z > -nearest) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  vec4 from = projection * vec4(a, 1.0);
  vec4 to = projection * vec4(b, 1.0);
  vec2 along = (to.xy / to.w - from.xy / from.w) * viewport;
  along = length(along) > 0.0 ? normalize(along) : vec2(1.0, 0.0);
  vec4 place = corner.x < 0.0 ? from : to;
  vec3 seen = corner.x < 0.0 ? a : b;
  vec4 lifted = projection * vec4(seen * (1.0 - min(lift / length(seen), 0.9)), 1.0);
  place.xy += vec2(-along.y, along.x) * corner.y * (corner.x < 0.0 ? widths.x : widths.y) / viewport * place.w;
  place.z = lifted.z / lifted.w * place.w;
  gl_Position = place;
  colour = ink;
}
