// A translucent surface, lit on the side that is seen, and denser at its rim, as glass is.
in vec3 place;
in vec3 normal;

uniform vec3 colour;
uniform float opacity;

out vec4 fragment;

void main() {
  vec3 eye = normalize(-place);
  vec3 side = normalize(normal);
  side = dot(side, eye) < 0.0 ? -side : side;
  float rim = 1.0 - dot(side, eye);
  fragment = vec4(lit(colour, side, place), mix(opacity, 1.0, 0.35 * rim * rim * rim));
}
