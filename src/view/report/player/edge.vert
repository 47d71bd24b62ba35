#version 300 es
// An edge of the box, some pixels wide at any distance.
precision highp float;

in vec2 corner;
in vec3 start;
in vec3 end;

uniform mat4 view;
uniform mat4 projection;
uniform vec2 viewport;
uniform float width;
uniform float nearest;

void main() {
  vec3 a = (view * vec4(start, 1.0)).xyz;
  vec3 b = (view * vec4(end, 1.0)).xyz;
  // What is behind the eye has no place in the picture.
  if (a.z > -nearest && b.z > -nearest) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  if (a.z > -nearest) a = mix(b, a, (-nearest - b.z) / (a.z - b.z));
  if (b.z > -nearest) b = mix(a, b, (-nearest - a.z) / (b.z - a.z));
  vec4 from = projection * vec4(a, 1.0);
  vec4 to = projection * vec4(b, 1.0);
  vec2 along = (to.xy / to.w - from.xy / from.w) * viewport;
  along = length(along) > 0.0 ? normalize(along) : vec2(1.0, 0.0);
  vec4 place = corner.x < 0.0 ? from : to;
  place.xy += vec2(-along.y, along.x) * corner.y * width / viewport * place.w;
  gl_Position = place;
}
