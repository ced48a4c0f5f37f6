// Numbers in bits: those of a directory and of a stitch map (src/core/stitch_codes.h). A string that ends early is refused.
import { refuse } from './refusal.js';

const { clz32 } = Math;

/** Numbers of one kind have exponential Golomb codes, whose order follows the numbers. */
export class NumberKind {
  constructor(order) {
    this.sixteenths = 16 * order;
  }
  follow(value) {
    this.sixteenths = (3 * this.sixteenths + 16 * (31 - clz32(value | 1))) >> 2;
  }
}
export const floor_log2 = (value) => 31 - clz32(value | 1);
/** The whole number, positive or negative, that a number of 32 bits stands for. */
export const unfold = (value) => (value >>> 1) ^ -(value & 1);

// What lies in the four bytes at any bit of a byte.
const kBytes = 4, kMostWidth = 25;

/** Reads bits, each byte from its lowest bit. */
export class BitString {
  #view;
  #end;  // in bytes
  #byte;
  #bit = 0;  // below 8

  constructor(bytes, at, end) {
    this.#view = new DataView(bytes.buffer, bytes.byteOffset, end);
    this.#byte = at;
    this.#end = end;
  }

  #take(count) {
    const bit = this.#bit + count;
    this.#byte += bit >> 3;
    this.#bit = bit & 7;
  }
  /** Of a string from byte 0 on. */
  taken() {
    return 8 * this.#byte + this.#bit;
  }
  flag() {
    if (this.#byte === this.#end) refuse('bits that end early');
    const bit = (this.#view.getUint8(this.#byte) >> this.#bit) & 1;
    this.#take(1);
    return bit !== 0;
  }
  /** @param {number} count at most 32 */
  bits(count) {
    let value = 0;
    if (count <= kMostWidth && this.#end - this.#byte >= kBytes) {
      value = (this.#view.getInt32(this.#byte, true) >>> this.#bit) & ((1 << count) - 1);
      this.#take(count);
    } else {
      for (let i = 0; i < count; ++i) if (this.flag()) value += 2 ** i;
    }
    return value;
  }
  number(kind) {
    const at = this.#byte, bit = this.#bit, order = kind.sixteenths >> 4;
    // Nearly all codes lie in four bytes. There are thousands, which V8 at first interprets: so this calls little.
    if (this.#end - at >= kBytes) {
      const ahead = this.#view.getInt32(at, true) >>> bit, zeros = 31 - clz32(ahead & -ahead), width = 2 * zeros + 1 + order;
      if (zeros >= 0 && width <= kMostWidth) {
        const end = bit + width, ones = (1 << zeros) - 1;
        this.#byte = at + (end >> 3);
        this.#bit = end & 7;
        const value = ((ones + ((ahead >>> (zeros + 1)) & ones)) << order) | ((ahead >>> (width - order)) & ((1 << order) - 1));
        kind.follow(value);
        return value;
      }
    }
    let zeros = 0;
    while (!this.flag()) if (++zeros + order > 32) refuse('a code that is too long');
    const value = (2 ** zeros - 1 + this.bits(zeros)) * 2 ** order + this.bits(order);
    if (value > 0xffffffff) refuse('a number of more than 32 bits');
    kind.follow(value);
    return value;
  }
  signed(kind) {
    return unfold(this.number(kind));
  }
  /** The unused bits of the last byte are 0, and nothing follows. */
  finish() {
    if (this.#bit > 0 && this.bits(8 - this.#bit) !== 0) refuse('bits behind the last number');
    if (this.#byte !== this.#end) refuse('bytes behind the last number');
  }
}
