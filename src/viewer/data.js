// What the page carries: a JSON text, and blocks of packed numbers (src/io/packed.hpp), unpacked when they are needed.

export const report = JSON.parse(document.getElementById("report").textContent);

async function bytesOf(block) {
  const text = atob(document.getElementById(`block-${block}`).textContent);
  const deflated = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) deflated[i] = text.charCodeAt(i);
  const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

export const int32 = async (block) => new Int32Array(await bytesOf(block));
export const float64 = async (block) => new Float64Array(await bytesOf(block));

/// Numbers from their differences.
export async function accumulated(block) {
  const values = await int32(block);
  for (let i = 1; i < values.length; ++i) values[i] += values[i - 1];
  return values;
}

/// For each vertex: the preceding vertices that a side of a triangle joins to it; if there is none, the one before it.
export class EarlierNeighbours {
  constructor(index, size) {
    this.size = size;
    this.first = new Uint32Array(size + 1);
    const visit = (side) => {
      for (let corner = 0; corner < index.length; ++corner) {
        const from = index[corner], to = index[corner % 3 === 2 ? corner - 2 : corner + 1];
        if (from < to) side(from, to);
      }
    };
    visit((from, to) => ++this.first[to + 1]);
    for (let v = 0; v < size; ++v) {
      if (v > 0 && this.first[v + 1] === 0) this.first[v + 1] = 1;
      this.first[v + 1] += this.first[v];
    }
    this.vertices = new Uint32Array(this.first[size]);
    for (let v = 1; v < size; ++v) this.vertices[this.first[v]] = v - 1;
    const end = this.first.slice(0, size);
    visit((from, to) => (this.vertices[end[to]++] = from));
  }
}

/// Rows of whole numbers from what their predictions left of them.
async function unpackedRows(block, { size, first, vertices }) {
  const bytes = new Uint8Array(await bytesOf(block));
  const order = bytes[0], count = (bytes.length - 1) / 2;
  const values = new Uint16Array(count), change = new Int32Array(size);
  for (let start = 0; start < count; start += size) {
    for (let v = 0, i = start; v < size; ++v, ++i) {
      let predicted = start > 0 ? values[i - size] : 0;
      if (order === 2 && start > size) predicted += values[i - size] - values[i - 2 * size];
      const begin = first[v], end = first[v + 1], n = end - begin;
      let sum = 0;
      for (let k = begin; k < end; ++k) sum += change[vertices[k]];
      const mean = n > 0 ? Math.floor((2 * sum + n) / (2 * n)) : 0;
      const coded = bytes[1 + i] | (bytes[1 + count + i] << 8);
      values[i] = predicted + mean + (coded & 1 ? -(coded + 1) / 2 : coded / 2);  // modulo 2^16
      change[v] = values[i] - predicted;
    }
  }
  return values;
}

/// Rows of quantised numbers.
class Rows {
  constructor(values, size, [low, high, levels]) {
    this.values = values;
    this.size = size;
    this.low = low;
    this.high = high;
    this.step = (high - low) / levels;
  }

  /// Adds `weight` times row `row` to every `stride`-th number of `target`, from `first` on.
  addTo(target, first, stride, row, weight) {
    const begin = row * this.size, low = weight * this.low, step = weight * this.step;
    for (let v = 0, to = first; v < this.size; ++v, to += stride) target[to] += low + step * this.values[begin + v];
  }

  value(row, v) {
    return this.low + this.step * this.values[row * this.size + v];
  }
}

export const rows = async (block, neighbours, scale) => new Rows(await unpackedRows(block, neighbours), neighbours.size, scale);

/// The history of a run on the page: column names to arrays.
export async function readHistory(run) {
  const { columns, rows: count, values } = run.history;
  const numbers = await float64(values);
  return new Map(columns.map((name, i) => [name, numbers.subarray(i * count, (i + 1) * count)]));
}
