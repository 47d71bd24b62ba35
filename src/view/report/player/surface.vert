#version 300 es
// A corner of a triangle of a surface.
precision highp float;

in vec3 position;
in vec3 direction;

uniform mat4 view;
uniform mat4 projection;

out vec3 place;
out vec3 normal;

void main() {
  place = (view * vec4(position, 1.0)).xyz;
  normal = mat3(view) * direction;
  gl_Position = projection * vec4(place, 1.0);
}
