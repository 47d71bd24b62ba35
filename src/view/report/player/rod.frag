in vec3 place;
in vec3 normal;

uniform vec3 colour;

out vec4 fragment;

void main() {
  fragment = vec4(lit(colour, normalize(normal), place), 1.0);
}
