// What runs on the graphics card. Light and sky are those of the pictures that the program takes (`crates/picture/src/light.rs`).

/** Reads a record of a body, relative to the eye: see `wire.rs`. */
const BODY = `#version 300 es
precision highp float;
precision highp int;
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in uvec3 i_now;
layout(location = 3) in uvec3 i_was;
layout(location = 4) in vec3 i_scale;
layout(location = 5) in vec4 i_color;
uniform ivec3 u_cell;   // of the eye
uniform vec3 u_rest;    // from the eye to its cell, metres
uniform float u_step;
uniform float u_mix;    // from the record before to this one
uniform mat4 u_lens;

vec3 place(uvec3 record) {
  return vec3(ivec3(record & 0xfffffu) - u_cell) * u_step + u_rest;
}

vec4 rotation(uvec3 record) {
  vec3 three = (vec3((record >> 20u) & 0x7ffu) * (2.0 / 2047.0) - 1.0) * 0.70710678;
  float largest = sqrt(max(0.0, 1.0 - dot(three, three)));
  uint k = (record.x >> 31u) | ((record.y >> 31u) << 1u);
  return k == 0u ? vec4(largest, three) : k == 1u ? vec4(three.x, largest, three.yz)
    : k == 2u ? vec4(three.xy, largest, three.z) : vec4(three, largest);
}

vec3 rotate(vec4 q, vec3 v) {
  vec3 t = 2.0 * cross(q.xyz, v);
  return v + q.w * t + cross(q.xyz, t);
}

// Where the corner is, from the eye; the rotation goes to q.
vec3 corner(out vec4 q) {
  vec3 at = place(i_now);
  q = rotation(i_now);
  if (u_mix < 1.0 && (i_was.x & 0xfffffu) != 0xfffffu) {
    vec4 before = rotation(i_was);
    q = normalize(mix(before * sign(dot(before, q) + 1e-9), q, u_mix));
    at = mix(place(i_was), at, u_mix);
  }
  return at + rotate(q, a_position * i_scale);
}

bool absent() {
  return (i_now.x & 0xfffffu) == 0xfffffu;
}
`;

export const BODY_VERTEX = `${BODY}
uniform mat4 u_sun;     // to the picture of the sun
out vec3 v_at;
out vec3 v_normal;
out vec3 v_sun;
flat out vec3 v_color;
flat out int v_slot;
uniform int u_first;
void main() {
  vec4 q;
  v_at = corner(q);
  v_normal = rotate(q, a_normal / i_scale);
  v_sun = (u_sun * vec4(v_at, 1.0)).xyz * 0.5 + 0.5;
  v_color = pow(i_color.rgb, vec3(2.2));
  v_slot = gl_InstanceID + u_first;
  gl_Position = absent() ? vec4(0.0, 0.0, 2.0, 1.0) : u_lens * vec4(v_at, 1.0);
}`;

const LIGHT = `
uniform vec3 u_sun_at;  // towards the sun
uniform float u_dark;
const vec3 SUN_LIGHT = vec3(2.75, 2.45, 2.0);
const vec3 SKY_LIGHT = vec3(0.52, 0.64, 0.84);
const vec3 GROUND_LIGHT = vec3(0.30, 0.27, 0.23);

vec3 air(vec3 way) {
  float near = max(dot(way, u_sun_at), 0.0);
  near *= near;
  vec3 day = vec3(0.80, 0.87, 0.95) + vec3(0.16, 0.12, 0.05) * near * near;
  return mix(day, vec3(0.052, 0.064, 0.080), u_dark);
}

vec3 sky(vec3 way) {
  if (way.z < 0.0) {
    float down = min(-6.0 * way.z, 1.0);
    vec3 below = mix(vec3(0.62, 0.66, 0.70), vec3(0.030, 0.036, 0.044), u_dark);
    return mix(air(way), below, down * down * (3.0 - 2.0 * down));
  }
  float rest = 1.0 - min(way.z, 1.0);
  rest *= rest;
  vec3 zenith = mix(vec3(0.22, 0.40, 0.74), vec3(0.010, 0.014, 0.022), u_dark);
  return mix(zenith, air(way), rest * rest * rest);
}

// As film sees it (Narkowicz, "ACES filmic tone mapping curve", 2015), and as a screen shows it.
vec3 develop(vec3 light) {
  vec3 x = mix(0.45, 0.30, u_dark) * light;
  x = clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
  return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(vec3(0.0031308), x));
}
`;

export const BODY_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2DShadow;
in vec3 v_at;
in vec3 v_normal;
in vec3 v_sun;
flat in vec3 v_color;
flat in int v_slot;
uniform sampler2DShadow u_shadow;
uniform float u_shadows;
uniform float u_texel;
uniform float u_reach;  // of the air, metres
uniform int u_kind;
uniform int u_pick;
uniform float u_grid;   // distance of the lines, metres
uniform vec3 u_eye;
out vec4 color;
${LIGHT}
float lines(vec2 at, float pitch) {
  vec2 cell = at / pitch;
  vec2 width = max(fwidth(cell), 1e-5);
  vec2 near = abs(fract(cell - 0.5) - 0.5) / width;
  float line = 1.0 - min(min(near.x, near.y), 1.0);
  return line * (1.0 - smoothstep(0.15, 0.5, max(width.x, width.y)));
}

float lit(vec3 normal) {
  if (u_shadows == 0.0 || any(lessThan(v_sun, vec3(0.0))) || any(greaterThan(v_sun, vec3(1.0)))) return 1.0;
  float sum = 0.0;
  // Four looks, each of which the card takes between four pixels.
  for (int k = 0; k < 4; k++)
    sum += texture(u_shadow, v_sun + vec3((vec2(k & 1, k >> 1) * 1.6 - 0.8) * u_texel, -0.0006));
  return 0.25 * sum;
}

void main() {
  float distance = length(v_at);
  vec3 way = v_at / distance;
  // Where a shape has flat faces its normal is that of the triangle.
  vec3 normal = u_kind == 1 || u_kind == 3 ? normalize(v_normal) : normalize(cross(dFdx(v_at), dFdy(v_at)));
  if (dot(normal, way) > 0.0) normal = -normal;
  vec3 own = v_color;
  if (u_kind == 2) {
    own *= mix(1.0, 0.28, u_dark);
    vec3 side = normalize(abs(normal.z) > 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 0.0, 1.0));
    vec3 x = normalize(cross(side, normal)), y = cross(normal, x);
    vec2 at = vec2(dot(v_at + u_eye, x), dot(v_at + u_eye, y));
    own = mix(own, own * 0.72, 0.5 * lines(at, u_grid) + 0.5 * lines(at, 10.0 * u_grid));
  }
  float facing = max(dot(normal, u_sun_at), 0.0);
  float seen = facing > 0.0 ? lit(normal) : 0.0;
  vec3 around = mix(GROUND_LIGHT, SKY_LIGHT, 0.5 + 0.5 * normal.z) * (0.80 + 0.20 * normal.z);
  vec3 middle = normalize(u_sun_at - way);
  float gloss = facing > 0.0 ? 0.16 * pow(max(dot(normal, middle), 0.0), 32.0) : 0.0;
  vec3 light = own * (SUN_LIGHT * facing * seen + around) + SUN_LIGHT * gloss * facing * seen;
  if (v_slot == u_pick) {
    float rim = 1.0 - abs(dot(normal, way));
    light = mix(light, vec3(2.6, 1.6, 0.3), 0.25 + 0.7 * rim * rim);
  }
  float far = distance / u_reach;
  color = vec4(develop(mix(air(way), light, exp(-min(far * far, 80.0)))), 1.0);
}`;

export const SHADOW_VERTEX = `${BODY}
void main() {
  vec4 q;
  vec3 at = corner(q);
  gl_Position = absent() ? vec4(0.0, 0.0, 2.0, 1.0) : u_lens * vec4(at, 1.0);
}`;

export const SHADOW_FRAGMENT = `#version 300 es
void main() {}`;

export const PICK_VERTEX = `${BODY}
uniform int u_first;
flat out uint v_slot;
out float v_distance;
void main() {
  vec4 q;
  vec3 at = corner(q);
  v_slot = uint(gl_InstanceID + u_first) + 1u;
  v_distance = 0.0;
  gl_Position = absent() ? vec4(0.0, 0.0, 2.0, 1.0) : u_lens * vec4(at, 1.0);
  v_distance = gl_Position.w;
}`;

export const PICK_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
flat in uint v_slot;
in float v_distance;
out uvec4 found;
void main() {
  found = uvec4(v_slot, floatBitsToUint(v_distance), 0u, 0u);
}`;

export const SKY_VERTEX = `#version 300 es
precision highp float;
uniform vec3 u_right;
uniform vec3 u_up;
uniform vec3 u_forward;
out vec3 v_way;
void main() {
  vec2 at = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  v_way = u_forward + at.x * u_right + at.y * u_up;
  gl_Position = vec4(at, 0.99999, 1.0);
}`;

export const SKY_FRAGMENT = `#version 300 es
precision highp float;
in vec3 v_way;
out vec4 color;
${LIGHT}
void main() {
  color = vec4(develop(sky(normalize(v_way))), 1.0);
}`;

export const LINE_VERTEX = `#version 300 es
precision highp float;
precision highp int;
layout(location = 0) in vec3 i_from;
layout(location = 1) in vec3 i_to;
layout(location = 2) in vec4 i_color;
uniform vec3 u_eye;
uniform mat4 u_lens;
uniform vec2 u_size;    // of the picture, pixels
uniform float u_width;
out vec2 v_at;
out vec3 v_color;
flat out float v_dot;
void main() {
  vec4 a = u_lens * vec4(i_from - u_eye, 1.0), b = u_lens * vec4(i_to - u_eye, 1.0);
  v_dot = i_color.a > 0.0 ? 1.0 : 0.0;
  v_color = i_color.rgb;
  float side = (gl_VertexID & 1) == 0 ? -1.0 : 1.0, along = gl_VertexID < 2 ? 0.0 : 1.0;
  if (a.w <= 1e-4 || b.w <= 1e-4) {
    gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
    return;
  }
  vec2 way = (b.xy / b.w - a.xy / a.w) * u_size;
  vec2 forward = v_dot > 0.5 || dot(way, way) < 1e-6 ? vec2(1.0, 0.0) : normalize(way);
  float width = v_dot > 0.5 ? 2.4 * u_width : u_width;
  v_at = vec2(side, 2.0 * along - 1.0);
  vec4 at = along < 0.5 ? a : b;
  vec2 shift = side * vec2(-forward.y, forward.x) + (v_dot > 0.5 ? (2.0 * along - 1.0) * forward : vec2(0.0));
  // A little nearer than what it lies on.
  gl_Position = at + vec4(shift * width / u_size * at.w, -0.0004 * at.w, 0.0);
}`;

export const LINE_FRAGMENT = `#version 300 es
precision highp float;
in vec2 v_at;
in vec3 v_color;
flat in float v_dot;
uniform float u_strength;
out vec4 color;
void main() {
  if (v_dot > 0.5 && dot(v_at, v_at) > 1.0) discard;
  color = vec4(v_color * u_strength, u_strength);
}`;
