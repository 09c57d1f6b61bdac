/** The programs of the graphics card: one casts a ray through every pixel, the other draws the traces as ribbons. */

export const SCREEN = `#version 300 es
layout(location = 0) in vec2 corner;
void main() { gl_Position = vec4(corner, 0.0, 1.0); }`;

/** Rods, ellipsoids, cylinders, arrows and the floor are met exactly, surfaces of revolution by Newton steps. */
/**
 * @param {number} kind 0 ball or ellipsoid, 1 heavy top, 2 cylinder, 3 surface of revolution
 * @param {number} side rays of a pixel along a side
 * @param {number} glass whether one sees through the body
 */
export const RAYS = (kind, side, glass) => `#version 300 es
precision highp float;
const int kind = ${kind}, side = ${side}, glass = ${glass};
uniform vec2 size;
uniform vec3 eye, right, up, ahead, centre, lightDirection, middle;
uniform float lens, near, far, stemRadius, stemHeight, spinBlur, grid, dark;
uniform vec3 surface, halves; // centre and half axes of what is drawn
uniform vec3 meridian[64]; // height and radius, by the half axes, and inclination of the normal
uniform mat3 body; // columns: axes of the surface
uniform vec3 arrowStart[4], arrowVector[4], arrowColour[4];
uniform vec3 skyColour, floorColour, lineColour, heavyColour, lightColour, markColour, stemColour;
out vec4 colour;

const float NONE = 1e9;
struct Hit { float t; vec3 normal; vec3 paint; float shine; };

float ball(vec3 o, vec3 d, vec3 c, float r) {
  vec3 p = o - c;
  float b = dot(p, d), h = b * b - dot(p, p) + r * r;
  if (h < 0.0) return NONE;
  float t = -b - sqrt(h);
  return t > 0.0 ? t : NONE;
}

vec3 section(float z) { // radius, its slope, and the inclination of the normal at a height
  int low = 0, high = 63;
  while (high - low > 1) {
    int m = (low + high) / 2;
    if (meridian[m].x > z) low = m; else high = m;
  }
  vec3 a = meridian[low], b = meridian[high], c = b - a;
  float s = (z - a.x) / c.x;
  return vec3(a.y + s * c.y, c.y / c.x, a.z + clamp(s, 0.0, 1.0) * c.z);
}

float lathe(vec3 o, vec3 d, out vec3 normal) { // distance to the axis less radius is convex along a ray: no step is too far
  float b = dot(o, d), h = b * b - dot(o, o) + 3.0, t = max(-b - sqrt(max(h, 0.0)), 0.0);
  if (h < 0.0) return NONE;
  for (int i = 0; i < 24; i++) {
    vec3 p = o + t * d, s = section(p.z);
    float r = max(length(p.xy), 1e-6), outside = r - s.x, slope = dot(p.xy, d.xy) / r - s.y * d.z;
    normal = vec3(p.xy / r * sin(s.z), cos(s.z));
    if (outside < 1e-4 * max(1.0, -slope)) return t;
    if (slope >= 0.0) return NONE;
    t -= outside / slope;
  }
  return NONE;
}

float rod(vec3 o, vec3 d, vec3 a, vec3 b, float r) { // a capsule
  vec3 ba = b - a, oa = o - a;
  float baba = dot(ba, ba), bard = dot(ba, d), baoa = dot(ba, oa), rdoa = dot(d, oa), oaoa = dot(oa, oa);
  float A = baba - bard * bard, B = baba * rdoa - baoa * bard, C = baba * oaoa - baoa * baoa - r * r * baba;
  float h = B * B - A * C;
  if (h < 0.0) return NONE;
  float t = (-B - sqrt(h)) / A, y = baoa + t * bard;
  if (y > 0.0 && y < baba) return t > 0.0 ? t : NONE;
  return ball(o, d, y <= 0.0 ? a : b, r);
}

vec3 rodNormal(vec3 p, vec3 a, vec3 b) {
  vec3 ba = b - a;
  return normalize(p - a - clamp(dot(p - a, ba) / dot(ba, ba), 0.0, 1.0) * ba);
}

float cone(vec3 o, vec3 d, vec3 a, vec3 b, float r, out vec3 normal) { // wide end a, point b
  vec3 ba = b - a, oa = o - a;
  float m = dot(ba, ba), nd = dot(d, ba), no = dot(oa, ba);
  float best = NONE;
  if (nd != 0.0) {
    float t = -no / nd;
    vec3 p = oa + t * d;
    if (t > 0.0 && dot(p, p) < r * r) { best = t; normal = -normalize(ba); }
  }
  float k = r * r / m;
  vec3 axis = ba / sqrt(m);
  vec3 q = o - b;
  float dv = dot(d, axis), ov = dot(q, axis), s = m / (m + r * r);
  float A = dv * dv - s, B = dv * ov - s * dot(q, d), C = ov * ov - s * dot(q, q);
  float h = B * B - A * C;
  if (h > 0.0) {
    float root = sqrt(h);
    for (int i = 0; i < 2; i++) {
      float t = (i == 0 ? -B - root : -B + root) / A;
      float y = no + t * nd;
      if (t > 0.0 && t < best && y > 0.0 && y < m) {
        best = t;
        vec3 p = o + t * d - b;
        normal = normalize(p - axis * dot(p, axis) * (1.0 + k));
        vec3 outward = o + t * d - (a + ba * y / m);
        if (dot(normal, outward) < 0.0) normal = -normal;
      }
    }
  }
  return best;
}

float wave(float x, float cells) { // the integral of a pattern of so many cells around, half of them dark
  float y = x * cells / 6.2831853;
  return (floor(y) * 0.5 + min(fract(y), 0.5)) * 6.2831853 / cells;
}

float stripes(float angle, float cells, float blur) {
  return (wave(angle + 0.5 * blur, cells) - wave(angle - 0.5 * blur, cells)) / blur;
}

float edge(float from, float x, float width) { return smoothstep(from - width, from + width, x); }

vec3 pattern(vec3 p, float pixel) { // p on the unit sphere, axes of the body
  float around = atan(p.y, p.x), across = max(length(p.xy), 1e-3);
  float blur = max(spinBlur, pixel / across);
  float dark4 = stripes(around, 4.0, blur);
  vec3 upper = mix(lightColour, lightColour * 0.78 + heavyColour * 0.12, dark4);
  vec3 lower = mix(heavyColour, heavyColour * 0.62 + 0.04, dark4);
  vec3 paint = mix(lower, upper, edge(0.0, p.z, pixel));
  float band = edge(-0.09, p.z, pixel) - edge(0.09, p.z, pixel);
  float flag = stripes(around, 1.0, max(blur, pixel / across));
  paint = mix(paint, mix(stemColour, markColour, flag), band);
  return mix(paint, markColour, edge(0.972, p.z, pixel * 0.5));
}

Hit solid(vec3 o, vec3 d, float pixel) { // the body itself
  Hit hit = Hit(NONE, vec3(0), vec3(0), 0.0);
  vec3 axis = body[2];
  if (kind != 2) {
    vec3 c = surface;
    if (kind == 1) {
      vec3 a = centre - axis, b = centre + (halves.z + 0.28) * axis;
      float s = rod(o, d, a + 0.03 * axis, b, 0.03);
      if (s < hit.t) hit = Hit(s, rodNormal(o + s * d, a, b), stemColour, 0.6);
    }
    vec3 oo = ((o - c) * body) / halves, dd = (d * body) / halves, n;
    float size = length(dd), t = kind == 3 ? lathe(oo, dd / size, n) : ball(oo, dd / size, vec3(0), 1.0);
    if (t < NONE && t / size < hit.t) {
      vec3 p = oo + t / size * dd;
      t /= size;
      if (kind != 3) n = p / halves;
      hit = Hit(t, normalize(body * n), pattern(normalize(p), pixel * t / halves.x), kind == 1 ? 0.6 : 0.55);
    }
    if (stemRadius > 0.0) {
      vec3 e = c + stemHeight * axis;
      float s = rod(o, d, c, e, stemRadius);
      if (s < hit.t) {
        vec3 p = o + s * d, n = rodNormal(p, c, e), b = n * body;
        float flag = stripes(atan(b.y, b.x), 2.0, max(spinBlur, 2.0 * pixel * s / stemRadius));
        hit = Hit(s, n, mix(stemColour, markColour, flag), 0.5);
      }
    }
  } else {
    vec3 oo = (o - surface) * body, dd = d * body;
    float radius = halves.x, A = dot(dd.xz, dd.xz), B = dot(oo.xz, dd.xz), C = dot(oo.xz, oo.xz) - radius * radius, h = B * B - A * C;
    float wide = radius;
    if (h > 0.0) {
      float t = (-B - sqrt(h)) / A;
      vec3 p = oo + t * dd;
      if (t > 0.0 && abs(p.y) < wide) {
        float dark = stripes(atan(p.x, p.z), 8.0, max(spinBlur, pixel * t / radius));
        float cap = p.z < 0.0 ? 1.0 : 0.0;
        hit = Hit(t, body * vec3(p.x, 0, p.z) / radius,
          mix(mix(lightColour, heavyColour, cap), stemColour, 0.45 * dark), 0.4);
      }
      float side = -sign(dd.y), u = (side * wide - oo.y) / dd.y;
      vec3 e = oo + u * dd;
      if (u > 0.0 && u < hit.t && dot(e.xz, e.xz) < radius * radius) {
        vec2 m = e.xz + ((surface - centre) * body).xz;
        float k = pixel * u;
        vec3 paint = mix(heavyColour, lightColour, edge(0.0, e.z, k));
        paint = mix(paint, stemColour, edge(0.93 * radius, length(e.xz), k));
        paint = mix(paint, stemColour, 1.0 - edge(0.05 * radius, length(e.xz), k));
        paint = mix(paint, markColour, 1.0 - edge(0.1 * radius, length(m), k));
        hit = Hit(u, body * vec3(0, side, 0), paint, 0.3);
      }
    }
  }
  return hit;
}

Hit arrows(vec3 o, vec3 d) {
  Hit hit = Hit(NONE, vec3(0), vec3(0), 0.0);
  for (int i = 0; i < 4; i++) {
    float size = length(arrowVector[i]);
    if (size < 1e-3) continue;
    vec3 along = arrowVector[i] / size, a = arrowStart[i], b = a + arrowVector[i];
    vec3 m = o - a - 0.5 * arrowVector[i];
    float md = dot(m, d), reach = 0.5 * size + 0.07;
    if (dot(m, m) - md * md > reach * reach) continue;
    float head = min(0.16, 0.5 * size), thick = 0.022 * min(1.0, size * 3.0);
    vec3 neck = b - head * along, normal;
    if (size > head) {
      float t = rod(o, d, a, neck, thick);
      if (t < hit.t) hit = Hit(t, rodNormal(o + t * d, a, neck), arrowColour[i], 0.35);
    }
    float t = cone(o, d, neck, b, 0.4 * head, normal);
    if (t < hit.t) hit = Hit(t, normal, arrowColour[i], 0.35);
  }
  return hit;
}

float softBall(vec3 o, vec3 d, vec3 c, float r, float k) { // how much of the light passes a ball
  vec3 p = o - c;
  float b = dot(p, d), h = b * b - dot(p, p) + r * r;
  if (b > 0.0) return 1.0;
  return smoothstep(0.0, 1.0, clamp(0.5 - 0.5 * h * k / (r * max(-b, 0.2 * r)), 0.0, 1.0));
}

float sunlight(vec3 p) {
  vec3 axis = body[2];
  if (kind < 2) {
    vec3 d = (lightDirection * body) / halves;
    float s = softBall(((p - surface) * body) / halves, normalize(d), vec3(0), 1.0, kind == 0 ? 2.4 : 3.0);
    if (stemRadius > 0.0) {
      for (int i = 1; i <= 3; i++) {
        vec3 e = surface + axis * mix(halves.x * 0.8, stemHeight, float(i) / 3.0);
        s *= softBall(p, lightDirection, e, stemRadius, 1.6);
      }
    }
    if (kind == 1) {
      for (int i = 0; i < 7; i++) {
        vec3 e = centre + axis * (-1.0 + 0.15 * float(i));
        s *= mix(0.86, 1.0, softBall(p, lightDirection, e, 0.06, 0.8));
      }
    }
    return s;
  }
  float s = 0.0;
  for (int i = 0; i < 9; i++) {
    vec2 j = vec2(float(i % 3) - 1.0, float(i / 3) - 1.0) * 0.07;
    vec3 d = normalize(lightDirection + vec3(j, 0.0));
    s += solid(p + d * 1e-3, d, 0.0).t < NONE ? 0.0 : 1.0;
  }
  return s / 9.0;
}

float least() { return min(halves.x, min(halves.y, halves.z)); }

float sky(vec3 p) { // how much of the sky the floor sees
  float r = kind == 1 ? 0.8 * halves.x : least();
  vec3 q = surface - p;
  float l2 = dot(q, q);
  return 1.0 - 0.85 * clamp(q.z / sqrt(l2), 0.0, 1.0) * min(r * r / l2, 1.0);
}

vec3 lit(Hit hit, vec3 p, vec3 d) {
  float diffuse = max(dot(hit.normal, lightDirection), 0.0);
  float wrapped = max(0.5 + 0.5 * dot(hit.normal, lightDirection), 0.0);
  float ground = 0.5 - 0.5 * hit.normal.z;
  vec3 bounce = mix(vec3(0.94, 0.97, 1.0), floorColour * 1.05, ground) * (0.34 + 0.2 * hit.normal.z);
  vec3 h = normalize(lightDirection - d);
  float gloss = pow(max(dot(hit.normal, h), 0.0), 70.0) * hit.shine;
  float rim = pow(1.0 - max(-dot(hit.normal, d), 0.0), 4.0) * 0.22;
  return hit.paint * (bounce + 0.6 * diffuse + 0.14 * wrapped) + gloss * vec3(1.0, 0.98, 0.94) + rim * skyColour;
}

float gridLine(vec2 p, vec2 width) {
  vec2 q = abs(fract(p / grid - 0.5) - 0.5) * grid;
  vec2 line = 1.0 - smoothstep(width * 0.6, width * 1.6, q);
  vec2 calm = clamp(grid / width * 0.12, 0.0, 1.0);
  return max(line.x * calm.x, line.y * calm.y);
}

vec3 backdrop(vec3 d) { return mix(skyColour, skyColour * (dark > 0.5 ? 1.5 : 0.94), smoothstep(0.0, 0.5, d.z)); }

vec3 world(vec3 o, vec3 d, float pixel, out float t) { // floor and sky
  t = NONE;
  if (d.z > -1e-4) return backdrop(d);
  t = -o.z / d.z;
  vec3 p = o + t * d;
  vec2 width = vec2(pixel * t) * (1.0 + 0.35 / -d.z);
  vec3 c = mix(floorColour, lineColour, 0.5 * gridLine(p.xy, max(width, vec2(0.008 * grid))));
  float light = sunlight(p);
  c *= sky(p) * (dark > 0.5 ? mix(0.42, 1.0, light) : mix(0.62, 1.0, light));
  float away = length(p.xy - middle.xy);
  return mix(c, backdrop(d), smoothstep(5.0, 16.0, away));
}

vec3 shade(vec3 o, vec3 d, float pixel, out float depth) {
  vec3 c = world(o, d, pixel, depth);
  Hit a = arrows(o, d);
  if (o.z + a.t * d.z < 0.0) a.t = NONE;
  Hit b = solid(o, d, pixel);
  if (glass == 1) {
    if (kind != 2) {
      float r = 0.12 * (kind == 1 ? 1.0 : least()), t = ball(o, d, centre, r);
      if (t < a.t) a = Hit(t, (o + t * d - centre) / r, markColour, 0.6);
    }
    if (a.t < depth) { c = lit(a, o + a.t * d, d); depth = a.t; }
    if (b.t < depth) {
      float rim = 1.0 - max(-dot(b.normal, d), 0.0);
      c = mix(c, lit(b, o + b.t * d, d), 0.26 + 0.5 * rim * rim);
    }
    return c;
  }
  if (b.t < depth) { // arrows inside the body shine through
    float hidden = a.t < depth && a.t > b.t ? 0.4 : 0.0;
    c = mix(lit(b, o + b.t * d, d), a.paint, hidden);
    depth = b.t;
  }
  if (a.t < depth) { c = lit(a, o + a.t * d, d); depth = a.t; }
  return c;
}

void main() {
  vec3 sum = vec3(0);
  float nearest = NONE, pixel = 2.0 * lens / size.y;
  for (int i = 0; i < side; i++) for (int j = 0; j < side; j++) {
    vec2 shift = (vec2(i, j) + 0.5) / float(side) - 0.5;
    vec2 p = (2.0 * (gl_FragCoord.xy + shift) - size) / size.y * lens;
    vec3 d = normalize(ahead + p.x * right + p.y * up);
    float t;
    sum += shade(eye, d, pixel / float(side), t);
    nearest = min(nearest, t * dot(d, ahead));
  }
  colour = vec4(pow(sum / float(side * side), vec3(0.9)), 1.0);
  float z = min(nearest, far);
  gl_FragDepth = clamp(0.5 + 0.5 * (far + near - 2.0 * far * near / z) / (far - near), 0.0, 1.0);
}`;

/** A ribbon of constant width on the screen, whose older part fades. */
export const RIBBON = `#version 300 es
in vec3 before, here, next;
in float side, time;
uniform mat3 turn;
uniform vec3 shift, eye, right, up, ahead;
uniform vec2 size;
uniform float lens, near, far, width, now, memory, towards;
out float age, across;
vec4 seen(vec3 p) {
  vec3 q = turn * p + shift - eye;
  float z = dot(q, ahead);
  return vec4(dot(q, right) / lens * size.y / size.x, dot(q, up) / lens,
    ((far + near) * z - 2.0 * far * near) / (far - near) - towards * z, z);
}
void main() {
  vec4 a = seen(before), b = seen(here), c = seen(next);
  vec2 d = (c.xy / max(c.w, near) - a.xy / max(a.w, near)) * size;
  vec2 n = length(d) > 1e-6 ? vec2(-d.y, d.x) / length(d) : vec2(0);
  gl_Position = b;
  gl_Position.xy += n / size * side * width * b.w;
  age = (now - time) / memory;
  across = side;
}`;

export const INK = `#version 300 es
precision highp float;
in float age, across;
uniform vec3 ink;
uniform float faint;
out vec4 colour;
void main() {
  if (age > 1.0 || age < 0.0) discard;
  float a = mix(0.95, faint, age) * (1.0 - smoothstep(0.6, 1.0, abs(across)));
  colour = vec4(ink * a, a);
}`;
