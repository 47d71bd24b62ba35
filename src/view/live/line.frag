#version 300 es
precision highp float;

in vec4 colour;

out vec4 fragment;

void main() {
  fragment = colour;
}
