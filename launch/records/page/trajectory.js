// The frames of a run: rows of 32-bit floats with the layout `runInfo.layout`, in ascending order of time.
class Trajectory {
  constructor(layout) {
    this.columns = new Map(); // name of a quantity to its first column and number of columns
    this.width = 0;
    for (const [name, count] of layout) {
      this.columns.set(name, [this.width, count]);
      this.width += count;
    }
    this.floats = new Float32Array(0);
    this.clear();
  }

  // Removes all rows.
  clear() {
    this.length = 0;
    this.fall = undefined; // time of the fall, if the robot fell
  }

  // Adds rows in binary form.
  append(bytes) {
    const added = new Float32Array(bytes), used = this.length * this.width;
    if (used + added.length > this.floats.length) {
      const larger = new Float32Array(used === 0 ? added.length : 2 * (used + added.length));
      larger.set(this.floats.subarray(0, used));
      this.floats = larger;
    }
    this.floats.set(added, used);
    const before = this.length;
    this.length += added.length / this.width;
    for (let row = before; this.fall === undefined && row < this.length; row++) {
      if (this.get(row, "fallen")) this.fall = this.get(row, "time");
    }
  }

  // Removes the oldest rows.
  dropOldest(rows) {
    this.floats.copyWithin(0, rows * this.width, this.length * this.width);
    this.length -= rows;
  }

  count(name) { return this.columns.get(name)[1]; }

  get(row, name, index = 0) { return this.floats[row * this.width + this.columns.get(name)[0] + index]; }

  // All components of a quantity in a row.
  all(row, name) {
    const [from, count] = this.columns.get(name), at = row * this.width + from;
    return this.floats.subarray(at, at + count);
  }

  // A component of a quantity in all rows from `from` on.
  column(name, index = 0, from = 0) {
    return Array.from({ length: this.length - from }, (_, row) => this.get(from + row, name, index));
  }

  get begin() { return this.length === 0 ? 0 : this.get(0, "time"); }
  get end() { return this.length === 0 ? 0 : this.get(this.length - 1, "time"); }

  // The last row at or before a time.
  row(time) {
    let [low, high] = [0, Math.max(this.length - 1, 0)];
    while (low < high) {
      const middle = Math.ceil((low + high) / 2);
      if (this.get(middle, "time") <= time) low = middle; else high = middle - 1;
    }
    return low;
  }
}

// Decodes base 64.
function decodeBase64(text) {
  const characters = atob(text.trim()), bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = characters.charCodeAt(i);
  return bytes.buffer;
}

