#version 300 es
// A cylinder between two points.
precision highp float;

in vec3 corner;
in vec3 start;
in vec3 end;
in float radius;

uniform mat4 view;
uniform mat4 projection;

out vec3 place;
out vec3 normal;

void main() {
  vec3 a = (view * vec4(start, 1.0)).xyz;
  vec3 b = (view * vec4(end, 1.0)).xyz;
  vec3 axis = b - a;
  float span = length(axis);
  axis = span > 0.0 ? axis / span : vec3(0.0, 0.0, 1.0);
  vec3 right = normalize(cross(axis, abs(axis.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
  normal = corner.x * right + corner.y * cross(right, axis);
  place = mix(a, b, corner.z) + radius * normal;
  gl_Position = projection * vec4(place, 1.0);
}
