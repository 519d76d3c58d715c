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

/// Rows of `size` whole numbers from what Lorenzo's predictor left of them.
async function unpackedRows(block, size) {
  const bytes = new Uint8Array(await bytesOf(block));
  const count = bytes.length / 2;
  const values = new Uint16Array(count);
  for (let start = 0; start < count; start += size) {
    let left = 0, leftBefore = 0;
    for (let v = 0; v < size; ++v) {
      const i = start + v;
      const coded = bytes[i] | (bytes[count + i] << 8);
      const r = coded & 1 ? -(coded + 1) / 2 : coded / 2;
      const before = start > 0 ? values[i - size] : 0;
      values[i] = before + left - leftBefore + r;  // modulo 2^16
      left = values[i];
      leftBefore = before;
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
}

export const rows = async (block, size, scale) => new Rows(await unpackedRows(block, size), size, scale);

/// The history: column names to arrays.
export async function readHistory() {
  const { columns, rows: count, values } = report.history;
  const numbers = await float64(values);
  return new Map(columns.map((name, i) => [name, numbers.subarray(i * count, (i + 1) * count)]));
}
