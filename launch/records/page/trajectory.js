// Frames: rows of 32-bit floats, laid out as `about.layout` says; times rise from row to row.
class Film {
  constructor(layout) {
    this.places = new Map();
    this.width = 0;
    for (const [name, count] of layout) {
      this.places.set(name, [this.width, count]);
      this.width += count;
    }
    this.floats = new Float32Array(0);
    this.clear();
  }

  /// Begins anew.
  clear() {
    this.length = 0;
    this.fall = undefined; // when the robot fell, if it did
  }

  /// Adds rows, given as bytes.
  append(bytes) {
    const more = new Float32Array(bytes), used = this.length * this.width;
    if (used + more.length > this.floats.length) {
      const room = new Float32Array(used === 0 ? more.length : 2 * (used + more.length));
      room.set(this.floats.subarray(0, used));
      this.floats = room;
    }
    this.floats.set(more, used);
    const before = this.length;
    this.length += more.length / this.width;
    for (let row = before; this.fall === undefined && row < this.length; row++) {
      if (this.get(row, "fallen")) this.fall = this.get(row, "time");
    }
  }

  /// Lets go of the oldest rows.
  forget(rows) {
    this.floats.copyWithin(0, rows * this.width, this.length * this.width);
    this.length -= rows;
  }

  count(name) { return this.places.get(name)[1]; }

  get(row, name, index = 0) { return this.floats[row * this.width + this.places.get(name)[0] + index]; }

  /// All values of a quantity in a row.
  all(row, name) {
    const [from, count] = this.places.get(name), at = row * this.width + from;
    return this.floats.subarray(at, at + count);
  }

  /// A quantity over all rows from one on.
  column(name, index = 0, from = 0) {
    return Array.from({ length: this.length - from }, (_, row) => this.get(from + row, name, index));
  }

  get begin() { return this.length === 0 ? 0 : this.get(0, "time"); }
  get end() { return this.length === 0 ? 0 : this.get(this.length - 1, "time"); }

  /// The last row at or before a time.
  row(time) {
    let [low, high] = [0, Math.max(this.length - 1, 0)];
    while (low < high) {
      const middle = Math.ceil((low + high) / 2);
      if (this.get(middle, "time") <= time) low = middle; else high = middle - 1;
    }
    return low;
  }
}

/// Base 64 as bytes.
function bytesOf(text) {
  const letters = atob(text.trim()), bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes.buffer;
}

