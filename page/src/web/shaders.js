// What runs on the graphics card.

export const SOLID = {
  vertex: `
in vec3 position;
in vec3 normal;
in vec4 colour;
uniform mat4 model, both, light;
out vec3 world, facing, paint;
out vec4 lit;
out float sure;
void main() {
  vec4 place = model * vec4(position, 1.0);
  world = place.xyz;
  facing = transpose(inverse(mat3(model))) * normal;
  paint = colour.rgb;
  sure = colour.a;
  lit = light * place;
  gl_Position = both * place;
}`,
  fragment: `
in vec3 world, facing, paint;
in vec4 lit;
in float sure;
uniform vec4 tint, pale;
uniform float alpha, glow, plain, soft;
uniform vec3 eye, sun;
uniform vec2 screen;
uniform highp sampler2DShadow shadow;
uniform sampler2D dusk;
out vec4 shown;
float sunlight() {
  vec3 at = lit.xyz / lit.w * 0.5 + 0.5;
  if (any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) return 1.0;
  vec2 texel = 1.0 / vec2(textureSize(shadow, 0));
  float sum = 0.0;
  for (int x = -1; x <= 1; x++) for (int y = -1; y <= 1; y++) {
    sum += texture(shadow, vec3(at.xy + 1.3 * vec2(x, y) * texel, at.z - 0.0016));
  }
  return sum / 9.0;
}
void main() {
  vec3 srgb = mix(paint, tint.rgb, tint.a);
  if (plain > 0.5) {
    shown = vec4(srgb, alpha);
    return;
  }
  // The less sure, the paler; what is a guess is hatched.
  float doubt = pale.a * (1.0 - sure);
  float hatch = step(0.62, fract((gl_FragCoord.x + gl_FragCoord.y) / 9.0)) * smoothstep(0.45, 0.7, doubt);
  srgb = mix(mix(srgb, pale.rgb, 0.86 * smoothstep(0.05, 1.0, doubt)), srgb, 0.55 * hatch);
  vec3 albedo = pow(srgb, vec3(2.2));
  vec3 look = normalize(eye - world);
  vec3 n = normalize(facing);
  if (dot(n, look) < 0.0) n = -n;
  float open = mix(1.0, texture(dusk, gl_FragCoord.xy / screen).r, soft);
  float day = sunlight();
  vec3 sky = mix(vec3(0.34, 0.33, 0.33), vec3(0.60, 0.63, 0.68), 0.5 + 0.5 * n.z);
  float key = max(dot(n, sun), 0.0) * day;
  float fill = 0.16 * max(dot(n, look), 0.0);
  vec3 half_way = normalize(sun + look);
  float shine = pow(max(dot(n, half_way), 0.0), 48.0) * 0.10 * day;
  float rim = pow(1.0 - max(dot(n, look), 0.0), 4.0) * 0.08;
  vec3 light = albedo * (open * (sky + fill) + 0.72 * vec3(1.0, 0.97, 0.92) * key) + shine + rim * sky;
  light = mix(light, vec3(1.0), glow * (0.24 + 0.7 * pow(1.0 - max(dot(n, look), 0.0), 2.0)));
  shown = vec4(pow(clamp(light, 0.0, 1.0), vec3(1.0 / 2.2)), alpha);
}`,
};

/** Depth alone, for shadows and dusk. */
export const DEPTH = {
  vertex: `
in vec3 position;
uniform mat4 model, both;
void main() { gl_Position = both * model * vec4(position, 1.0); }`,
  fragment: "void main() {}",
};

/** Which item is where, and how deep. */
export const PICK = {
  vertex: DEPTH.vertex,
  fragment: `
uniform uint item;
out uvec4 found;
void main() { found = uvec4(item, floatBitsToUint(gl_FragCoord.z), 0u, 1u); }`,
};

const WHOLE = `
out vec2 at;
void main() {
  at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;
  gl_Position = vec4(at * 2.0 - 1.0, 0.99999, 1.0);
}`;

export const SKY = {
  vertex: WHOLE,
  fragment: `
in vec2 at;
uniform vec3 high, low;
out vec4 shown;
float noise(vec2 p) { return fract(sin(dot(p, vec2(12.9898, 78.233))) * 43758.5453); }
void main() {
  vec3 c = mix(low, high, smoothstep(0.0, 1.0, at.y));
  shown = vec4(c + (noise(gl_FragCoord.xy) - 0.5) / 255.0, 1.0);
}`,
};

/** How much of the sky is hidden at each point, from depths alone. */
export const DUSK = {
  vertex: WHOLE,
  fragment: `
in vec2 at;
uniform sampler2D depth;
uniform mat4 projection;
uniform float reach;
out vec4 shown;
vec3 seen(vec2 uv) {
  float z = -projection[3][2] / (texture(depth, uv).r * 2.0 - 1.0 + projection[2][2]);
  vec2 ndc = uv * 2.0 - 1.0;
  return vec3(ndc.x * -z / projection[0][0], ndc.y * -z / projection[1][1], z);
}
void main() {
  if (texture(depth, at).r >= 1.0) { shown = vec4(1.0); return; }
  vec3 p = seen(at);
  vec3 n = normalize(cross(dFdx(p), dFdy(p)));
  float spin = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) * 6.2831853;
  vec2 wide = reach * 0.5 * vec2(projection[0][0], projection[1][1]) / -p.z;
  float hidden = 0.0;
  for (int i = 0; i < 14; i++) {
    float k = (float(i) + 0.5) / 14.0;
    float a = spin + k * 6.2831853 * 5.0;
    vec2 uv = at + wide * k * vec2(cos(a), sin(a));
    if (texture(depth, uv).r >= 1.0) continue;
    vec3 v = seen(uv) - p;
    float far = dot(v, v) / (reach * reach);
    hidden += max(dot(v, n) / reach - 0.02, 0.0) / (far + 0.02) * max(1.0 - far, 0.0);
  }
  shown = vec4(clamp(1.0 - 1.1 * hidden / 14.0, 0.25, 1.0));
}`,
};

/** Evens out the grain of dusk, within one surface. */
export const BLUR = {
  vertex: WHOLE,
  fragment: `
in vec2 at;
uniform sampler2D dusk, depth;
uniform vec2 range;
out vec4 shown;
float away(float d) { return range.x * range.y / (range.y - d * (range.y - range.x)); }
void main() {
  vec2 texel = 1.0 / vec2(textureSize(dusk, 0));
  float own = away(texture(depth, at).r);
  float sum = 0.0, weight = 0.0;
  for (int x = -2; x <= 2; x++) for (int y = -2; y <= 2; y++) {
    vec2 uv = at + vec2(x, y) * texel;
    float w = 1.0 / (0.002 + abs(away(texture(depth, uv).r) - own) / own);
    sum += w * texture(dusk, uv).r;
    weight += w;
  }
  shown = vec4(sum / weight);
}`,
};

export const GROUND = {
  vertex: `
uniform mat4 both, light;
uniform vec3 centre;
uniform float radius;
out vec3 world;
out vec4 lit;
void main() {
  vec2 at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  world = centre + vec3(at * radius, 0.0);
  lit = light * vec4(world, 1.0);
  gl_Position = both * vec4(world, 1.0);
}`,
  fragment: `
in vec3 world;
in vec4 lit;
uniform vec3 centre, ink, chalk;
uniform float radius, step_size, strength, grid;
uniform highp sampler2DShadow shadow;
out vec4 shown;
float lines(vec2 p) {
  vec2 d = abs(fract(p - 0.5) - 0.5) / max(fwidth(p), 1e-6);
  return 1.0 - min(min(d.x, d.y), 1.0);
}
void main() {
  vec3 at = lit.xyz / lit.w * 0.5 + 0.5;
  float day = 0.0;
  vec2 texel = 1.0 / vec2(textureSize(shadow, 0));
  for (int x = -2; x <= 2; x++) for (int y = -2; y <= 2; y++) {
    day += texture(shadow, vec3(at.xy + 2.2 * vec2(x, y) * texel, at.z - 0.001)) / 25.0;
  }
  if (any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) day = 1.0;
  float away = length(world.xy - centre.xy) / radius;
  float fade = 1.0 - smoothstep(0.25, 1.0, away);
  float drawn = grid * (0.6 * lines(world.xy / step_size) + 0.4 * lines(world.xy / (5.0 * step_size)));
  float dark = strength * (1.0 - day);
  shown = vec4(mix(chalk, ink, dark / max(dark + drawn, 1e-4)), fade * max(dark, drawn));
}`,
};

/** Lines of so many pixels: one instance a segment. */
export const LINES = {
  vertex: `
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
layout(location = 2) in vec4 paint;
layout(location = 3) in float width;
uniform mat4 both;
uniform vec2 screen;
out vec4 tone;
void main() {
  vec4 a = both * vec4(from, 1.0), b = both * vec4(to, 1.0);
  float near = 1e-4;
  if (a.w < near) a = mix(a, b, (near - a.w) / max(b.w - a.w, 1e-9));
  if (b.w < near) b = mix(b, a, (near - b.w) / max(a.w - b.w, 1e-9));
  vec2 along = (b.xy / b.w - a.xy / a.w) * screen;
  along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  float side = (gl_VertexID & 1) == 0 ? -1.0 : 1.0;
  bool end = gl_VertexID >= 2;
  vec4 p = end ? b : a;
  vec2 push = (across * side + along * (end ? 0.5 : -0.5)) * width;
  p.xy += push / screen * p.w;
  p.z -= 0.0004 * p.w;
  tone = paint;
  gl_Position = p;
}`,
  fragment: `
in vec4 tone;
uniform float alpha;
out vec4 shown;
void main() { shown = vec4(tone.rgb, tone.a * alpha); }`,
};
