#version 460
layout(location = 0) out uvec2 value;
void main() { value = uvec2(uint(gl_FragCoord.x), 7u); }
