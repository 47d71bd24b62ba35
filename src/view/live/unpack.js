// Decompresses LZMA, which is a third smaller than gzip. Browsers support only gzip. The format is defined in
// `lzma-specification.txt` of the LZMA SDK (Igor Pavlov, public domain).

/** Number of bits of a probability, and adaptation rate. */
const LZMA_ONE = 11;
const LZMA_FOLLOW = 5;

/** Length of the header: properties, dictionary size and unpacked length. */
const LZMA_HEADER = 13;

/** Offset of the probabilities for each kind of decision. */
const LZMA_TABLES = (() => {
  const sizes = {
    isMatch: 12 << 4, isRep: 12, isRepG0: 12, isRepG1: 12, isRepG2: 12, isRep0Long: 12 << 4,
    slots: 4 << 6, special: 128, align: 16, lengths: 2 + (16 << 3) * 2 + 256, repLengths: 2 + (16 << 3) * 2 + 256,
  };
  const places = {};
  let end = 0;
  for (const [name, size] of Object.entries(sizes)) {
    places[name] = end;
    end += size;
  }
  return { ...places, literals: end };
})();

class RangeDecoder {
  constructor(bytes, at) {
    this.bytes = bytes;
    this.at = at + 5;
    // Range and code of the decoder, as unsigned numbers of 32 bits.
    this.registers = Uint32Array.of(0xffffffff, new DataView(bytes.buffer, bytes.byteOffset).getUint32(at + 1));
  }

  bit(probabilities, place) {
    const { registers } = this;
    const probability = probabilities[place];
    const bound = Math.imul(registers[0] >>> LZMA_ONE, probability) >>> 0;
    const bit = registers[1] < bound ? 0 : 1;
    if (bit === 0) {
      registers[0] = bound;
      probabilities[place] = probability + ((2048 - probability) >> LZMA_FOLLOW);
    } else {
      registers[0] -= bound;
      registers[1] -= bound;
      probabilities[place] = probability - (probability >> LZMA_FOLLOW);
    }
    this.fill();
    return bit;
  }

  fill() {
    const { registers } = this;
    if (registers[0] < 0x1000000) {
      registers[0] <<= 8;
      registers[1] = (registers[1] << 8) | this.bytes[this.at];
      this.at += 1;
    }
  }

  /** Decodes bits of equal probability, highest bit first. */
  direct(count) {
    const { registers } = this;
    let value = 0;
    for (let k = 0; k < count; k += 1) {
      registers[0] >>>= 1;
      const bit = registers[1] >= registers[0] ? 1 : 0;
      registers[1] -= bit * registers[0];
      this.fill();
      value = (value << 1) | bit;
    }
    return value;
  }

  /** Decodes bits with a tree of probabilities, highest bit first. */
  tree(probabilities, place, count) {
    let node = 1;
    for (let k = 0; k < count; k += 1) {
      node = (node << 1) | this.bit(probabilities, place + node);
    }
    return node - (1 << count);
  }

  /** Decodes bits with a tree of probabilities, lowest bit first. */
  reverseTree(probabilities, place, count) {
    let [node, value] = [1, 0];
    for (let k = 0; k < count; k += 1) {
      const bit = this.bit(probabilities, place + node);
      node = (node << 1) | bit;
      value |= bit << k;
    }
    return value;
  }
}

class Unpacker {
  constructor(packed) {
    const properties = packed[0];
    this.lc = properties % 9;
    this.lp = Math.floor(properties / 9) % 5;
    this.pb = Math.floor(properties / 45);
    this.out = new Uint8Array(Number(new DataView(packed.buffer, packed.byteOffset).getBigUint64(5, true)));
    this.coder = new RangeDecoder(packed, LZMA_HEADER);
    this.probabilities = new Uint16Array(LZMA_TABLES.literals + (0x300 << (this.lc + this.lp))).fill(1 << (LZMA_ONE - 1));
    this.at = 0;
    this.state = 0;
    this.distances = new Int32Array(4);
  }

  unpack() {
    const { coder, probabilities, out } = this;
    while (this.at < out.length) {
      const part = this.at & ((1 << this.pb) - 1);
      if (coder.bit(probabilities, LZMA_TABLES.isMatch + (this.state << 4) + part) === 0) {
        this.literal();
      } else {
        this.match(part);
      }
    }
    return out;
  }

  literal() {
    const { coder, probabilities, out, at, lc, lp, state } = this;
    const before = at > 0 ? out[at - 1] : 0;
    const context = ((at & ((1 << lp) - 1)) << lc) + (before >> (8 - lc));
    const place = LZMA_TABLES.literals + 0x300 * context;
    let symbol = 1;
    // After a match, the byte that follows in the matched text predicts the next literal, until a bit differs.
    if (state >= 7) {
      let hint = out[at - this.distances[0] - 1];
      while (symbol < 0x100) {
        const expected = (hint >> 7) & 1;
        hint <<= 1;
        const bit = coder.bit(probabilities, place + ((1 + expected) << 8) + symbol);
        symbol = (symbol << 1) | bit;
        if (bit !== expected) {
          break;
        }
      }
    }
    while (symbol < 0x100) {
      symbol = (symbol << 1) | coder.bit(probabilities, place + symbol);
    }
    out[at] = symbol;
    this.at = at + 1;
    this.state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
  }

  match(part) {
    const { coder, probabilities, distances, state } = this;
    const isLate = state >= 7;
    let length;
    if (coder.bit(probabilities, LZMA_TABLES.isRep + state) === 0) {
      length = this.length(LZMA_TABLES.lengths, part);
      this.moveToFront(3, this.distance(length));
      this.state = isLate ? 10 : 7;
    } else {
      const which = this.repeated(part);
      if (which < 0) {
        this.state = isLate ? 11 : 9;
        this.copy(1);
        return;
      }
      this.moveToFront(which, distances[which]);
      length = this.length(LZMA_TABLES.repLengths, part);
      this.state = isLate ? 11 : 8;
    }
    this.copy(length + 2);
  }

  moveToFront(place, distance) {
    for (let k = place; k > 0; k -= 1) {
      this.distances[k] = this.distances[k - 1];
    }
    this.distances[0] = distance;
  }

  /** Returns which of the last four distances is repeated, or -1 for a single byte at the last distance. */
  repeated(part) {
    const { coder, probabilities, state } = this;
    if (coder.bit(probabilities, LZMA_TABLES.isRepG0 + state) === 0) {
      return coder.bit(probabilities, LZMA_TABLES.isRep0Long + (state << 4) + part) === 0 ? -1 : 0;
    }
    if (coder.bit(probabilities, LZMA_TABLES.isRepG1 + state) === 0) {
      return 1;
    }
    return coder.bit(probabilities, LZMA_TABLES.isRepG2 + state) === 0 ? 2 : 3;
  }

  length(place, part) {
    const { coder, probabilities } = this;
    if (coder.bit(probabilities, place) === 0) {
      return coder.tree(probabilities, place + 2 + (part << 3), 3);
    }
    if (coder.bit(probabilities, place + 1) === 0) {
      return 8 + coder.tree(probabilities, place + 2 + 128 + (part << 3), 3);
    }
    return 16 + coder.tree(probabilities, place + 2 + 256, 8);
  }

  distance(length) {
    const { coder, probabilities } = this;
    const slot = coder.tree(probabilities, LZMA_TABLES.slots + (Math.min(length, 3) << 6), 6);
    if (slot < 4) {
      return slot;
    }
    const bits = (slot >> 1) - 1;
    const base = (2 | (slot & 1)) << bits;
    if (slot < 14) {
      return base + coder.reverseTree(probabilities, LZMA_TABLES.special + base - slot, bits);
    }
    return base + (coder.direct(bits - 4) << 4) + coder.reverseTree(probabilities, LZMA_TABLES.align, 4);
  }

  /** The source may overlap the copy. */
  copy(length) {
    const from = this.at - this.distances[0] - 1;
    if (from < 0 || this.at + length > this.out.length) {
      throw new Error("the module is damaged");
    }
    for (let k = 0; k < length; k += 1) {
      this.out[this.at + k] = this.out[from + k];
    }
    this.at += length;
  }
}
