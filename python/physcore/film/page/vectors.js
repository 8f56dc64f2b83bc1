// Vectors, rotations column by column, and normals.
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => { const length = Math.hypot(...a) || 1; return a.map(each => each / length); };
const apply = (m, v) => [0, 1, 2].map(row => m[row] * v[0] + m[3 + row] * v[1] + m[6 + row] * v[2]);
const product = (a, b) => [0, 1, 2].flatMap(column => apply(a, b.slice(3 * column, 3 * column + 3)));
const STRAIGHT = [1, 0, 0, 0, 1, 0, 0, 0, 1];
// The rotation by an angle about a unit axis, column by column.
function rotation([x, y, z], angle) {
  const c = Math.cos(angle), s = Math.sin(angle), t = 1 - c;
  return [t * x * x + c, t * x * y + s * z, t * x * z - s * y, t * x * y - s * z, t * y * y + c, t * y * z + s * x,
          t * x * z + s * y, t * y * z - s * x, t * z * z + c];
}

// Mean unit normals of the triangles around each point, weighted by their areas.
function normals(places, faces) {
  const result = new Float32Array(places.length);
  for (let k = 0; k < faces.length; k += 3) {
    const a = 3 * faces[k], b = 3 * faces[k + 1], c = 3 * faces[k + 2];
    const ux = places[b] - places[a], uy = places[b + 1] - places[a + 1], uz = places[b + 2] - places[a + 2];
    const vx = places[c] - places[a], vy = places[c + 1] - places[a + 1], vz = places[c + 2] - places[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    for (const at of [a, b, c]) { result[at] += x; result[at + 1] += y; result[at + 2] += z; }
  }
  for (let k = 0; k < result.length; k += 3) {
    const length = Math.hypot(result[k], result[k + 1], result[k + 2]) || 1;
    result[k] /= length; result[k + 1] /= length; result[k + 2] /= length;
  }
  return result;
}
