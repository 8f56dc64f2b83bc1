// Shaders: how places become pixels, and the light of the renderer (styles in film/colors/light.py, rust_core/canvas).
const COMMON = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform vec2 size;          // of the picture [pixels]
uniform float pixel;        // pixels of the screen per pixel of the picture
uniform vec4 eye;           // scale [pixels/m], middle [pixels], 1 / distance [1/m]
uniform mat3 turn;          // by the viewer
uniform vec3 zoom;          // factor, and shift [pixels]
uniform bool deep;
uniform vec3 low, span;     // ends of the quantized places
uniform float share;        // of the later one of two frames
uniform vec2 fog;           // share of the background in the farthest color, half the depth of the motion [m]
uniform vec3 background;
uniform vec4 plane;         // unit normal and offset of the ground on which shadows fall; 0 without
const vec3 LAMP = vec3(-0.42, 0.62, 0.66);
const float NOTHING = -1e29; // above the depth where there is no liquid
`;
const PLACING = `
vec3 between(vec3 one, vec3 other) {
  // A step of more than half of the box is a jump, as across a face of a periodic domain.
  bool jumps = any(greaterThan(abs(other - one), vec3(0.5)));
  return low + span * (jumps ? one : mix(one, other, share));
}
vec3 turned(vec3 place) {
  vec3 to = turn * place;
  return plane.xyz == vec3(0.0) ? to : to - LAMP * (dot(plane.xyz, to) - plane.w) / dot(plane.xyz, LAMP);
}
float deepness(float z) { return eye.w > 0.0 ? 1.0 - 0.1 / max(1.0 - z * eye.w, 0.02) : clamp(-z / (40.0 * fog.y), -1.0, 1.0); }
// Pixel of the picture, depth of the screen, pixels per unit of length.
vec4 seen(vec3 to) {
  vec2 at = to.xy;
  float depth = 0.0, scale = 1.0;
  if (deep) {
    float far = max(1.0 - to.z * eye.w, 0.02);
    scale = eye.x / far;
    at = eye.yz + scale * vec2(to.x, -to.y);
    depth = deepness(to.z);
  }
  return vec4((at - 0.5 * size) * zoom.x + 0.5 * size + zoom.yz, depth, scale * zoom.x);
}
// Place of the screen, with perspective: corners of large triangles may be behind the eye.
vec4 screen(vec3 to) {
  float far = deep ? 1.0 - to.z * eye.w : 1.0;
  vec2 at = deep ? far * eye.yz + eye.x * vec2(to.x, -to.y) : to.xy;
  at = zoom.x * (at - 0.5 * far * size) + far * (0.5 * size + zoom.yz);
  float depth = !deep ? 0.0 : eye.w > 0.0 ? far - 0.1 : clamp(-to.z / (40.0 * fog.y), -1.0, 1.0);
  return vec4(vec2(2.0, -2.0) * at / size + far * vec2(-1.0, 1.0), depth, far);
}
vec4 placed(vec2 at, float depth) { return vec4(vec2(2.0, -2.0) * at / size + vec2(-1.0, 1.0), depth, 1.0); }
vec4 fogged(vec4 ink, vec3 to) {
  float far = fog.y > 0.0 ? fog.x * clamp(0.5 - 0.5 * to.z / fog.y, 0.0, 1.0) : 0.0;
  return vec4(mix(ink.rgb, background, far), ink.a);
}
`;
// The sky that water reflects, as in rust_core/canvas/src/sky.rs.
const SKY = `
uniform vec3 horizon, zenith, high;
uniform float brightness;   // 0: no reflection
vec3 reflected(vec3 shown, vec3 normal, vec3 toward, float part) {
  float cosine = clamp(dot(normal, toward), 0.0, 1.0), mirrored = part * min(brightness * (0.02 + 0.98 * pow(1.0 - cosine, 5.0)), 0.85);
  float upward = dot(2.0 * cosine * normal - toward, high);
  return mix(shown, mix(horizon, zenith, sqrt(min(abs(upward), 1.0))), mirrored);
}
`;
const ROUND = `${COMMON}
in vec2 corner; in vec3 one, other; in float length_; in vec4 ink;
flat out vec4 color; flat out float radius; flat out vec2 ball; out vec2 from;
${PLACING}
void main() {
  vec3 to = turned(between(one, other));
  vec4 at = seen(to);
  ball = vec2(to.z, length_);
  radius = length_ * at.w * pixel;
  from = corner * (radius + 1.0);
  color = deep ? fogged(ink, to) : ink;
  if (plane.xyz == vec3(0.0)) { gl_Position = placed(at.xy + from / pixel, at.z); return; }
  vec3 first = normalize(cross(plane.xyz, vec3(1.0, 0.3, 0.2))), second = cross(plane.xyz, first);
  at = seen(to + length_ * (corner.x * first + corner.y * second));
  from = corner * radius;
  gl_Position = placed(at.xy, at.z);
}`;
const DISC = `${COMMON}
flat in vec4 color; flat in float radius; in vec2 from; out vec4 result;
uniform float shading;
void main() {
  float square = radius * radius, drawn = square >= 1.0 / 3.0 ? sqrt(square - 1.0 / 12.0) : 0.5;
  float alpha = color.a * min(1.0, 3.0 * square) * clamp(0.5 + drawn - length(from), 0.0, 1.0);
  if (alpha <= 0.0) discard;
  if (plane.xyz != vec3(0.0)) { result = vec4(1.0); return; }
  vec3 shown = color.rgb;
  if (shading > 0.0) {
    vec2 n = from / max(radius, 1e-6) * vec2(1.0, -1.0);
    vec3 normal = vec3(n, sqrt(max(1.0 - dot(n, n), 0.0)));
    float cosine = dot(normal, LAMP), up = 0.5 + 0.5 * normal.y;
    float light = 0.3 + 0.16 * up + 0.72 * max((cosine + 0.2) / 1.2, 0.0), rim = shading * 0.3 * up * pow(1.0 - normal.z, 2.0);
    shown = (shown + (1.0 - shown) * rim) * (1.0 - shading * (1.0 - light)) + 70.0 / 255.0 * shading * pow(max(cosine, 0.0), 8.0);
  }
  result = vec4(shown, alpha);
}`;
// Light, or a shadow of its color, which is added to what is behind by 1 − (1 − a)(1 − b).
const HALO = `${COMMON}
uniform bool shadow;
flat in vec4 color; flat in float radius; in vec2 from; out vec4 result;
void main() {
  float inside = max(1.0 - dot(from, from) / (radius * radius), 0.0);
  result = vec4((shadow ? 1.0 - color.rgb : color.rgb) * color.a * inside * inside, 1.0);
}`;
const STRIPE = `${COMMON}
in vec2 corner; in vec3 one, other, end, endLater; in float width; in vec4 ink;
flat out vec4 color; flat out vec2 start, stop; flat out float half_; out vec2 from;
${PLACING}
void main() {
  vec3 first = turned(between(one, other)), second = turned(between(end, endLater));
  vec4 a = seen(first), b = seen(second);
  float wide = width * zoom.x * pixel;
  start = a.xy * pixel; stop = b.xy * pixel;
  half_ = 0.5 * max(wide, 1.0);
  vec2 way = stop - start, along = length(way) > 1e-6 ? normalize(way) : vec2(1.0, 0.0), across = vec2(-along.y, along.x);
  vec2 base = corner.x < 0.0 ? start : stop;
  from = base + (half_ + 1.0) * (corner.x * along + corner.y * across);
  color = deep ? fogged(ink, corner.x < 0.0 ? first : second) : ink;
  color.a *= min(wide, 1.0);
  gl_Position = placed(from / pixel, (corner.x < 0.0 ? a.z : b.z) - 1e-5);
}`;
const LINE = `${COMMON}
flat in vec4 color; flat in vec2 start, stop; flat in float half_; in vec2 from; out vec4 result;
void main() {
  vec2 way = stop - start, off = from - start;
  off -= clamp(dot(off, way) / max(dot(way, way), 1e-9), 0.0, 1.0) * way;
  float alpha = color.a * clamp(0.5 + half_ - length(off), 0.0, 1.0);
  if (alpha <= 0.0) discard;
  result = plane.xyz == vec3(0.0) ? vec4(color.rgb, alpha) : vec4(1.0);
}`;
const CORNER = `${COMMON}
in vec3 one, other; in vec4 ink; out vec4 color;
${PLACING}
void main() {
  vec3 to = turned(between(one, other));
  color = deep ? fogged(ink, to) : ink;
  gl_Position = screen(to);
}`;
const PLAIN = `${COMMON}
in vec4 color; out vec4 result;
void main() { result = plane.xyz == vec3(0.0) ? color : vec4(1.0); }`;
const POINT = `${COMMON}
in vec3 one, normal; in vec4 ink; in vec2 spot; out vec4 color; out vec3 leaning, place; out vec2 texel;
${PLACING}
void main() {
  vec3 to = turned(one);
  color = ink; leaning = turn * normal; place = to; texel = spot;
  gl_Position = screen(to);
}`;
const BODY = `${COMMON}
in vec3 one, other, point, normal; in vec4 way, wayLater, ink; in float tone; out vec4 color; out vec3 leaning, place; out vec2 texel;
uniform vec4 lowTurn, spanTurn;
${PLACING}
vec3 rotated(vec4 q, vec3 v) { vec3 t = 2.0 * cross(q.yzw, v); return v + q.x * t + cross(q.yzw, t); }
void main() {
  vec4 q = normalize(lowTurn + spanTurn * mix(way, wayLater, share));
  vec3 to = turned(between(one, other) + rotated(q, point));
  color = vec4(min(ink.rgb * tone, vec3(1.0)), ink.a); leaning = turn * rotated(q, normal); place = to; texel = vec2(0.0);
  gl_Position = screen(to);
}`;
const LIT = `${COMMON}${SKY}
in vec4 color; in vec3 leaning, place; in vec2 texel; out vec4 result;
uniform vec4 back;          // color of the back; alpha 0: that of the front, darker
uniform bool textured, closed;
uniform sampler2D texels;
${PLACING}
void main() {
  if (plane.xyz != vec3(0.0)) { result = vec4(1.0); return; }
  vec3 shown = textured ? color.rgb * texture(texels, vec2(texel.x, 1.0 - texel.y)).rgb : color.rgb;
  if (!deep) { result = vec4(shown, color.a); return; }
  bool away = !gl_FrontFacing && !closed;
  if (away && back.a > 0.0) shown = back.rgb;
  vec3 n = normalize(away ? -leaning : leaning);
  n.z = max(n.z, 0.0);
  float up = 0.5 + 0.5 * n.y, light = 0.3 + 0.16 * up + 0.72 * max((dot(n, LAMP) + 0.2) / 1.2, 0.0);
  shown = min((shown + (1.0 - shown) * 0.3 * up * pow(1.0 - n.z, 2.0)) * light, vec3(1.0)) * (away ? 0.9 : 1.0);
  vec3 toward = eye.w > 0.0 ? normalize(vec3(0.0, 0.0, 1.0 / eye.w) - place) : vec3(0.0, 0.0, 1.0);
  result = fogged(vec4(brightness > 0.0 ? reflected(shown, n, toward, 1.0) : shown, color.a), place);
}`;
const FLAT = `${COMMON}
in vec3 one; in vec2 spot; out vec2 at;
${PLACING}
void main() { at = spot; gl_Position = screen(turned(one)); }`;
// Values on a grid between the centers of cells, by the cubic of rust_core/canvas/src/heatmap.rs; 0 to 254 are 0 to 1.
const CUBIC = `
uniform vec2 cells;
float weight(float x) { x = abs(x); return x < 1.0 ? (1.5 * x - 2.5) * x * x + 1.0 : x < 2.0 ? ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0 : 0.0; }
float cubic(sampler2D one, sampler2D other, vec2 at) {
  vec2 place = at * cells - 0.5, base = floor(place);
  float value = 0.0;
  for (int j = -1; j < 3; j++) for (int i = -1; i < 3; i++) {
    vec2 off = place - base - vec2(i, j);
    ivec2 cell = clamp(ivec2(base) + ivec2(i, j), ivec2(0), ivec2(cells) - 1);
    value += weight(off.x) * weight(off.y) * mix(texelFetch(one, cell, 0).r, texelFetch(other, cell, 0).r, share);
  }
  return 255.0 / 254.0 * value;
}
`;
const FIELD = `${COMMON}${CUBIC}
in vec2 at; out vec4 result;
uniform sampler2D values, later, table, walls;
uniform float contours, relief, zero; uniform vec3 isoline, wall; uniform bool walled;
void main() {
  float value = cubic(values, later, at);
  vec2 slope = vec2(dFdx(value), dFdy(value)) * pixel;
  vec3 shown = texture(table, vec2((clamp(value, 0.0, 1.0) * 254.0 + 0.5) / 255.0, 0.5)).rgb;
  if (relief > 0.0) {
    float light = clamp(relief * 4.0 * (slope.x - slope.y) * size.x / 64.0, -1.0, 1.0);
    shown = light < 0.0 ? mix(shown, vec3(0.0), -0.6 * light) : mix(shown, vec3(1.0), 0.45 * light);
  }
  if (contours > 0.0) {
    // Lines are a distance between the ends of the scale apart, none at zero, and thin where they would merge.
    float level = (value - zero) * contours, steep = max(length(slope) * contours, 1e-6), off = abs(level - round(level)) / steep;
    if (round(level) != 0.0) shown = mix(shown, isoline, 150.0 / 255.0 * min(0.25 / steep, 1.0) * clamp(1.0 - off, 0.0, 1.0));
  }
  if (walled) {
    float part = texture(walls, at).r, steep = max(1.0, 1.0 / max(fwidth(at.x * cells.x), 1e-6));
    shown = mix(shown, wall, clamp((part - 0.5) * steep + 0.5, 0.0, 1.0));
  }
  result = vec4(shown, 1.0);
}`;
// A wave function: the phase as a hue over the background, as opaque as the density.
const PHASE = `${COMMON}${CUBIC}
in vec2 at; out vec4 result;
uniform sampler2D real, realLater, imaginary, imaginaryLater, table, walls;
uniform float soft, faint; uniform vec3 wall; uniform bool walled;
void main() {
  vec2 psi = 2.0 * vec2(cubic(real, realLater, at), cubic(imaginary, imaginaryLater, at)) - 1.0;
  float opacity = pow(clamp(dot(psi, psi), 0.0, 1.0), soft);
  vec3 hue = texture(table, vec2(atan(psi.y, psi.x) / 6.2831853 + 0.5, 0.5)).rgb;
  vec3 ground = walled ? mix(background, wall, faint * texture(walls, at).r) : background;
  result = vec4(mix(ground, hue, opacity), 1.0);
}`;
// The density of many points: the sum of their light, and the tone curve of rust_core/canvas/src/density.rs.
const SPARK = `${COMMON}
flat in vec4 color; flat in float radius; in vec2 from; out vec4 result;
uniform float amount;
void main() { vec2 off = 3.0 * from / radius; result = vec4(amount * exp(-0.5 * dot(off, off))); }`;
const EXPOSED = `${COMMON}
in vec2 at; out vec4 result;
uniform sampler2D picture, table;
void main() {
  float light = texture(picture, at).a;
  if (light <= 0.0) discard;
  float tone = pow(clamp(light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14), 0.0, 1.0), 1.0 / 2.2);
  result = vec4(texture(table, vec2(tone, 0.5)).rgb, min(tone / 0.3, 1.0));
}`;
// A liquid in 2D, as in rust_core/canvas/src/liquid: a field whose isoline bounds it, a lighter rim, a darker interior.
const DROP = `${COMMON}
flat in vec4 color; flat in float radius; in vec2 from; out vec4 result;
void main() {
  float inside = max(1.0 - dot(from, from) / (radius * radius), 0.0), amount = inside * inside * inside / 2.27;
  result = vec4(color.rgb * amount, amount);
}`;
const WATER = `${COMMON}
in vec2 at; out vec4 result;
uniform sampler2D picture;
uniform float glow, blur;
void main() {
  vec4 sum = texture(picture, at);
  vec2 slope = vec2(dFdx(sum.a), -dFdy(sum.a));
  float steep = max(length(slope), 1e-3), coverage = clamp(0.5 + (sum.a - 0.3) / steep, 0.0, 1.0);
  if (coverage <= 0.0) discard;
  float up = 0.5 + 0.5 * slope.y / steep, rim = 0.5 * (0.25 + 0.75 * up) * clamp((0.75 - sum.a) / 0.45, 0.0, 1.0);
  float deep = 1.0 - (1.0 - glow) * 0.2 * clamp((min(textureLod(picture, at, blur).a, 1.0) - 0.5) / 0.5, 0.0, 1.0);
  vec3 shown = sum.rgb / max(sum.a, 1e-4) * deep;
  result = vec4(mix(shown, vec3(1.0), rim), coverage);
}`;
// A liquid in 3D, as in rust_core/canvas/src/liquid but for the filter, which is by rows and columns here: the front of its drops,
// their thickness, and the front smoothed.
const FRONT = `${COMMON}
flat in vec4 color; flat in float radius; flat in vec2 ball; in vec2 from; out vec4 result;
${PLACING}
void main() {
  float square = dot(from, from) / (radius * radius);
  if (square >= 1.0) discard;
  float z = ball.x + ball.y * sqrt(1.0 - square);
  result = vec4(color.rgb, z);
  gl_FragDepth = 0.5 + 0.5 * deepness(z);
}`;
const THICK = `${COMMON}
flat in vec4 color; flat in float radius; in vec2 from; out vec4 result;
void main() { result = vec4(vec3(color.a), 1.0) * sqrt(max(1.0 - dot(from, from) / (radius * radius), 0.0)) * 1.5 / 3.1415927; }`;
const CALM = `${COMMON}
in vec2 at; out vec4 result;
uniform sampler2D picture;
uniform vec2 along;
uniform float reach, range; // of the filter [pixels of the screen], of depths that belong together [m]
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(picture, 0) - 1;
  vec4 own = texelFetch(picture, here, 0), sum = own;
  float weights = 1.0;
  for (float k = 1.0; own.a > NOTHING && k <= reach; k++) {
    float part = k / (reach + 1.0), weight = (1.0 - part * part) * (1.0 - part * part);
    for (int side = -1; side <= 1; side += 2) {
      ivec2 there = here + side * int(k) * ivec2(along);
      vec4 other = texelFetch(picture, clamp(there, ivec2(0), last), 0);
      if (abs(other.a - own.a) < range) { sum += weight * other; weights += weight; }
    }
  }
  result = sum / weights;
}`;
const SEA = `${COMMON}${SKY}
in vec2 at; out vec4 result;
uniform sampler2D picture, thick, behind;
uniform float range, steep, ball, glow; // pixels of the screen per meter, and the radius of a drop [pixels]
${PLACING}
float gentler(float before, float here, float after) {
  float p = after - here, q = here - before;
  bool one = abs(p) < range, other = abs(q) < range;
  if (one && other) return min(abs(p), abs(q)) > 0.25 * max(abs(p), abs(q)) ? 0.5 * (p + q) : abs(q) < abs(p) ? q : p;
  return one ? p : other ? q : 0.0;
}
float front(ivec2 shift) { return texelFetch(picture, clamp(ivec2(gl_FragCoord.xy) + shift, ivec2(0), textureSize(picture, 0) - 1), 0).a; }
void main() {
  vec4 own = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
  if (own.a <= NOTHING) discard;
  vec4 sum = textureLod(thick, at, log2(max(0.2 * ball, 1.0)));
  float amount = sum.a, opacity = sum.r / max(sum.a, 1e-4);
  vec2 slope = -steep * vec2(gentler(front(ivec2(-1, 0)), own.a, front(ivec2(1, 0))), gentler(front(ivec2(0, -1)), own.a, front(ivec2(0, 1))));
  vec3 normal = normalize(vec3(clamp(slope, -3.0, 3.0), 1.0));
  float light = dot(normal, LAMP), shining = pow(max(dot(normal, normalize(LAMP + vec3(0.0, 0.0, 1.0))), 0.0), 64.0);
  float passes = exp(-0.05 * pow(80.0, opacity) * amount);
  float thin = min(0.7 * amount, 1.0);
  float diffuse = mix(0.62 + 0.12 * (0.5 + 0.5 * normal.y) + 0.38 * light, 1.0, glow);
  vec2 bent = min(0.35 * amount * ball, 24.0 * pixel) * normal.xy;
  vec3 seen = texture(behind, (gl_FragCoord.xy - bent) / vec2(textureSize(behind, 0))).rgb;
  vec3 body = mix(own.rgb * diffuse, seen * pow(max(own.rgb, vec3(0.02)), vec3(0.1 * amount)), passes);
  body = reflected(body, normal, vec3(0.0, 0.0, 1.0), (1.0 - glow) * min(amount / 0.2, 1.0));
  result = vec4(body + (1.0 - glow) * 200.0 / 255.0 * shining * thin * thin, min(amount / 0.2, 1.0));
  gl_FragDepth = 0.5 + 0.5 * deepness(own.a);
}`;
// Shadows of everything in 3D on the ground, softened.
const DIMMED = `${COMMON}
in vec2 at; out vec4 result;
uniform sampler2D picture;
uniform float blur;
void main() {
  float sum = 0.0;
  for (int k = 0; k < 24; k++) {
    float turn = 2.39996 * float(k), far = blur * sqrt((float(k) + 0.5) / 24.0);
    sum += texture(picture, at + far * vec2(cos(turn), sin(turn)) / size).a;
  }
  result = vec4(0.0, 0.0, 0.03, 0.42 * sum / 24.0);
}`;
const GROUND = `${COMMON}
in vec2 at; out vec4 result;
uniform vec4 tint;          // color, and uniform opacity; 0: it fades with the distance
uniform vec4 grid;          // color, and opacity of the lines
uniform float pitch;
void main() {
  float square = dot(at, at), lit = tint.a > 0.0 ? tint.a : 1.0 / (1.0 + square * square);
  vec2 wide = vec2(length(vec2(dFdx(at.x), dFdy(at.x))), length(vec2(dFdx(at.y), dFdy(at.y)))) * pixel / max(pitch, 1e-9);
  vec2 away = abs(at / max(pitch, 1e-9) - round(at / max(pitch, 1e-9)));
  vec2 line = clamp(1.2 - away / max(wide, 1e-9), 0.0, 1.0) * min(0.25 / max(wide, 1e-9), 1.0);
  float covered = pitch > 0.0 ? grid.a * max(line.x, line.y) * lit * lit : 0.0;
  float whole = 1.0 - (1.0 - lit) * (1.0 - covered);
  result = vec4((tint.rgb * lit * (1.0 - covered) + grid.rgb * covered) / max(whole, 1e-6), whole);
}`;
const GLOW = `${COMMON}
in vec2 at; out vec4 result;
uniform vec4 tint;
void main() { float square = dot(at, at); result = vec4(tint.rgb, tint.a / ((1.0 + square) * (1.0 + square))); }`;
const PROGRAMS = {
  disc: [ROUND, DISC], halo: [ROUND, HALO], line: [STRIPE, LINE], triangle: [CORNER, PLAIN], surface: [POINT, LIT], solid: [BODY, LIT],
  grid: [FLAT, FIELD], ground: [FLAT, GROUND], backdrop: [FLAT, GLOW],
  phase: [FLAT, PHASE], density: [ROUND, SPARK], exposed: [FLAT, EXPOSED],
  liquid: [ROUND, DROP], water: [FLAT, WATER], front: [ROUND, FRONT], thick: [ROUND, THICK], calm: [FLAT, CALM], sea: [FLAT, SEA], dimmed: [FLAT, DIMMED],
};
