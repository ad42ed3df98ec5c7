#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/shared.h"
// Pulls its vertices from a buffer.
layout(set = 0, binding = 0, scalar) readonly buffer VerticesBlock { vec4 values[]; } vertices;
void main() { gl_Position = vertices.values[gl_VertexIndex]; }
