// The reverse of packing.py.
const TYPES = {f4: Float32Array, u1: Uint8Array, u2: Uint16Array, u4: Uint32Array};

async function unpacked(text) {
  const letters = atob(text.trim()), packed = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) packed[k] = letters.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const length = new DataView(bytes.buffer).getUint32(0, true);
  const film = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  return [film, bytes.subarray(4 + length)];
}

// Whole numbers of all frames, one frame after the other, row by row.
function steps(spec, bytes, count) {
  const {order, columns, size, bits} = spec, rows = typeof spec.rows === "number" ? Array(count).fill(spec.rows) : spec.rows;
  const values = bits > 8 ? new Uint16Array(size) : new Uint8Array(size), starts = [], mask = bits > 8 ? 65535 : 255;
  let start = 0, before = 0;
  for (const number of rows) {
    starts.push(start);
    before = number > 0 && starts.length > 1 && rows[starts.length - 2] === number ? before + 1 : 0;
    const one = start - number * columns, other = one - number * columns, straight = order === 2 && before > 1;
    for (let column = 0; column < columns; column++) {
      for (let row = 0; row < number; row++) {
        const place = column * (size / columns) + start / columns + row, at = row * columns + column;
        const zigzag = bytes[spec.at + place] | (bits > 8 ? bytes[spec.at + size + place] << 8 : 0);
        const guess = before === 0 || order === 0 ? (row > 0 ? values[start + at - columns] : 0)
          : straight ? 2 * values[one + at] - values[other + at] : values[one + at];
        values[start + at] = (guess + ((zigzag >>> 1) ^ -(zigzag & 1))) & mask;
      }
    }
    start += number * columns;
  }
  return {rows, starts, values};
}

// One array of a track over all frames. `at(frame)` is the array, and `rows(frame)` the number of its rows.
class Stream {
  constructor(spec, bytes, count) {
    Object.assign(this, {columns: spec.columns, still: spec.kind === "still", low: [0, 0, 0, 0], span: [1, 1, 1, 1], scaled: false});
    if (this.still) {
      const values = new TYPES[spec.type](bytes.buffer, bytes.byteOffset + spec.at, spec.rows * spec.columns);
      this.rows = frame => spec.shown && !spec.shown[frame] ? 0 : spec.rows;
      this.at = () => values;
      this.even = !spec.shown;
      return;
    }
    const {rows, starts, values} = steps(spec, bytes, count), half = new Uint16Array(2), word = new Uint32Array(half.buffer);
    this.even = typeof spec.rows === "number";
    this.columns = spec.whole ? spec.columns / 2 : spec.columns;
    this.rows = frame => rows[frame];
    this.at = frame => values.subarray(starts[frame], starts[frame] + rows[frame] * spec.columns);
    if (spec.table) {
      const table = new Uint32Array(new Uint8Array(spec.table).buffer), raw = this.at;
      this.at = frame => new Uint8Array(Uint32Array.from(raw(frame), index => table[index]).buffer);
      this.columns *= 4;
    } else if (spec.whole) {
      const raw = this.at;
      this.at = frame => { const parts = raw(frame); return Uint32Array.from({length: parts.length / 2}, (_, k) => { half[0] = parts[2 * k]; half[1] = parts[2 * k + 1]; return word[0]; }); };
    } else if (spec.low) {
      const most = 2 ** spec.bits - 1;
      this.scaled = true;
      this.low = spec.low;
      this.span = spec.low.map((low, column) => (spec.high[column] - low) * 65535 / most);
    }
  }
  // The array of a frame in its unit, between two frames if they have the same rows.
  real(frame, share) {
    const one = this.at(frame), count = this.columns;
    if (!this.scaled) return Float32Array.from(one);
    const other = share > 0 && this.even ? this.at(frame + 1) : one;
    return Float32Array.from(one, (value, k) => {
      const way = Math.abs(other[k] - value) > 32767 ? 0 : other[k] - value;
      return this.low[k % count] + this.span[k % count] * (value + share * way) / 65535;
    });
  }
}
