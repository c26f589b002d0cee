/* Vectors as arrays of three numbers, cameras, and matrices of three rows of four. */

export const add = (a, b) => a.map((x, i) => x + b[i]);
export const subtract = (a, b) => a.map((x, i) => x - b[i]);
export const scale = (a, s) => a.map(x => x * s);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross =
    (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = a => Math.sqrt(dot(a, a));
export const unit = a => scale(a, 1 / (length(a) || 1));

/* Turns a vector about an axis of unit length (Rodrigues). */
export function turn(v, axis, radians) {
  const c = Math.cos(radians), s = Math.sin(radians);
  return add(add(scale(v, c), scale(cross(axis, v), s)), scale(axis, dot(axis, v) * (1 - c)));
}

/* The axes of a camera: to the right, up, and ahead. */
export function axes(camera) {
  const ahead = unit(subtract(camera.target, camera.eye)), right = unit(cross(ahead, camera.up));
  return {ahead, right, up: cross(right, ahead)};
}

const pixels_for_a_slope = (camera, height) => height / 2 / Math.tan(camera.fov * Math.PI / 360);

/* Column, row and depth of a point, in pixels from the top left; null behind the eye. */
export function project(camera, [width, height], point) {
  const {ahead, right, up} = axes(camera), d = subtract(point, camera.eye), depth = dot(d, ahead);
  if (depth <= 0) return null;
  const s = pixels_for_a_slope(camera, height) / depth;
  return {x: width / 2 + s * dot(d, right), y: height / 2 - s * dot(d, up), depth};
}

/* The direction in which a place of the picture is seen. */
export function ray(camera, [width, height], {x, y}) {
  const {ahead, right, up} = axes(camera), s = 1 / pixels_for_a_slope(camera, height);
  return unit(add(ahead, add(scale(right, (x - width / 2) * s), scale(up, (height / 2 - y) * s))));
}

/* Where a ray meets a plane; null where it does not. */
export function meet(from, direction, point, normal) {
  const slope = dot(direction, normal), way = dot(subtract(point, from), normal) / slope;
  return Math.abs(slope) < .05 || !(way > 0) ? null : add(from, scale(direction, way));
}

/* ---- matrices ---- */

export const shift = (m, by) => m.map((x, i) => i % 4 === 3 ? x + by[(i - 3) / 4] : x);

/* The matrix followed by a turn about the vertical through a point. */
export function turn_matrix(m, centre, radians) {
  const out = new Array(12);
  for (let column = 0; column < 4; column++) {
    let v = [m[column], m[4 + column], m[8 + column]];
    if (column === 3) v = subtract(v, centre);
    v = turn(v, [0, 1, 0], radians);
    if (column === 3) v = add(v, centre);
    for (let row = 0; row < 3; row++) out[4 * row + column] = v[row];
  }
  return out;
}
