// Numbers in bits: those of a directory and of a stitch map (src/core/stitch_codes.h). A string that ends early is refused.
import { refuse } from './refusal.js';

/** Numbers of one kind have exponential Golomb codes, whose order follows the numbers. */
export class NumberKind {
  #sixteenths;

  constructor(order) {
    this.#sixteenths = 16 * order;
  }
  get order() {
    return this.#sixteenths >> 4;
  }
  follow(value) {
    this.#sixteenths = (3 * this.#sixteenths + 16 * floor_log2(value)) >> 2;
  }
}
export const floor_log2 = (value) => 31 - Math.clz32(value | 1);
export const unfold = (value) => (value % 2 === 0 ? value / 2 : -(value - 1) / 2 - 1);

/** Reads bits, each byte from its lowest bit. */
export class BitString {
  #bytes;
  #end;  // in bytes
  #byte;
  #bit = 0;  // below 8

  constructor(bytes, at, end) {
    this.#bytes = bytes;
    this.#byte = at;
    this.#end = end;
  }

  // The next 32 bits; 0 past the end.
  #ahead() {
    const bytes = this.#bytes, at = this.#byte, bit = this.#bit, left = this.#end - at;
    let low, high;
    if (left > 4) {
      low = bytes[at] | (bytes[at + 1] << 8) | (bytes[at + 2] << 16) | (bytes[at + 3] << 24);
      high = bytes[at + 4];
    } else {
      high = 0;
      low = (left > 0 ? bytes[at] : 0) | (left > 1 ? bytes[at + 1] << 8 : 0) | (left > 2 ? bytes[at + 2] << 16 : 0) | (left > 3 ? bytes[at + 3] << 24 : 0);
    }
    return (bit === 0 ? low : (low >>> bit) | (high << (32 - bit))) >>> 0;
  }
  #take(count) {
    const bit = this.#bit + count;
    this.#byte += bit >> 3;
    this.#bit = bit & 7;
    if (this.#byte + (this.#bit > 0 ? 1 : 0) > this.#end) refuse('bits that end early');
  }

  /** Of a string from byte 0 on. */
  taken() {
    return 8 * this.#byte + this.#bit;
  }
  /** @param {number} count at most 32 */
  bits(count) {
    const ahead = this.#ahead();
    this.#take(count);
    return count === 32 ? ahead : (ahead & ((1 << count) - 1)) >>> 0;
  }
  flag() {
    return this.bits(1) !== 0;
  }
  number(kind) {
    const { order } = kind, ahead = this.#ahead(), zeros = ahead === 0 ? 32 : 31 - Math.clz32(ahead & -ahead);
    const width = 2 * zeros + 1 + order;
    if (width <= 32) {  // nearly always
      this.#take(width);
      const high = (1 << zeros) - 1 + ((ahead >>> (zeros + 1)) & ((1 << zeros) - 1));
      // Without a low part, the shift may be that by 32, which leaves all bits: the mask has none.
      const value = ((high << order) | ((ahead >>> (2 * zeros + 1)) & ((1 << order) - 1))) >>> 0;
      kind.follow(value);
      return value;
    }
    if (zeros + order > 32) refuse('a code that is too long');
    if (zeros === 32) {
      this.#take(32);
      if (!this.flag()) refuse('a code that is too long');
    } else {
      this.#take(zeros + 1);
    }
    const whole = (2 ** zeros - 1 + this.bits(zeros)) * 2 ** order + this.bits(order);
    if (whole > 0xffffffff) refuse('a number of more than 32 bits');
    kind.follow(whole);
    return whole;
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
