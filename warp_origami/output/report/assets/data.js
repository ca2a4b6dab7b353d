// The run as the page holds it: a description in JSON, arrays in compressed planes of bytes (see coding.py).

const run = JSON.parse(document.getElementById("run").textContent);

const KINDS = { u2: Uint16Array, i4: Int32Array, f4: Float32Array, f8: Float64Array };

function fromBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const plain = atob(text);
  const bytes = new Uint8Array(plain.length);
  for (let i = 0; i < plain.length; i++) bytes[i] = plain.charCodeAt(i);
  return bytes;
}

async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Numbers from their planes of bytes: first the lowest byte of each, then the second, ...
function joined(planes, Kind) {
  const size = Kind.BYTES_PER_ELEMENT;
  const count = planes.length / size;
  const bytes = new Uint8Array(planes.length);
  for (let b = 0; b < size; b++) {
    for (let i = 0, from = b * count, to = b; i < count; i++, from++, to += size) bytes[to] = planes[from];
  }
  return new Kind(bytes.buffer);
}

// All arrays by name, as { values, shape }. The texts are let go as they are read.
async function unpacked() {
  const texts = document.querySelectorAll("script.array");
  const arrays = {};
  for (const [k, { name, kind, shape, differences }] of run.arrays.entries()) {
    const values = joined(await inflated(fromBase64(texts[k].textContent)), KINDS[kind]);
    texts[k].remove();
    if (differences) {
      const row = shape.slice(1).reduce((a, b) => a * b, 1);
      for (let i = row; i < values.length; i++) values[i] += values[i - row]; // modulo the range, as written
    }
    arrays[name] = { values, shape };
  }
  return arrays;
}
