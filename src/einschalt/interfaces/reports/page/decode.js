// Decoding: base64 -> inflated bytes -> JSON head and typed arrays (packed_data.py).

async function inflated(text) {
  const raw = atob(text.trim());
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Whole numbers of an array: 0 is a missing value. */
function wholeNumbers(bytes, start, facts) {
  const { n, at, width, steps } = facts;
  const out = new Uint32Array(n);
  for (let plane = 0; plane < width; plane++) {
    const from = start + at + plane * n, shift = 8 * plane;
    for (let i = 0; i < n; i++) out[i] |= bytes[from + i] << shift;
  }
  if (steps) {
    let value = 0;
    for (let i = 0; i < n; i++) {
      const z = out[i];
      value += z % 2 ? -(z + 1) / 2 : z / 2;
      out[i] = value;
    }
  }
  return out;
}

class Decoded {
  constructor(bytes) {
    const length = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
    this.head = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
    this.bytes = bytes;
    this.start = 4 + length;
  }

  whole(facts) {
    return wholeNumbers(this.bytes, this.start, facts);
  }

  /** Numbers; NaN where missing. */
  numbers(facts, Kind = Float64Array) {
    if (!facts) return null;
    const whole = this.whole(facts), out = new Kind(facts.n);
    for (let i = 0; i < facts.n; i++) {
      out[i] = whole[i] ? (whole[i] - 1 + facts.low) * facts.quantum : NaN;
    }
    return out;
  }

  /** Texts that repeat, as (i) => text, with their codes. */
  codes(facts) {
    if (!facts) return null;
    const whole = this.whole(facts);
    const text = (i) => facts.texts[whole[i] - 1 + facts.low];
    text.texts = facts.texts;
    text.code = (i) => whole[i] - 1 + facts.low;
    return text;
  }

  /** Names, as (i) => text: put together when they are asked for. */
  names(facts) {
    const stem = this.codes(facts.stem);
    const number = this.whole(facts.number), low = facts.number.low;
    return (i) => (number[i] ? stem(i) + (number[i] - 1 + low) : stem(i));
  }
}

async function decoded(element) {
  return new Decoded(await inflated(element.textContent));
}
