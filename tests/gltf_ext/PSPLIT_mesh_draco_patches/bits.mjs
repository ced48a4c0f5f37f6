// What all parts of the specification's decoder share: how a container is refused, and "Numbers of bits".

export class Invalid extends Error {}

export function demand(holds, why) {
  if (!holds) throw new Invalid(why);
}

// Reads a string of bits.
export function bit_reader(part, name) {
  let at = 0;
  const bits = (count) => {
    let value = 0;
    for (let i = 0; i < count; ++i, ++at) {
      demand(at < 8 * part.length, `the ${name} ends within a number`);
      value += ((part[at >> 3] >> (at & 7)) & 1) * 2 ** i;
    }
    return value;
  };
  const number = (kind) => {
    let zeros = 0;
    while (bits(1) === 0) zeros += 1;
    const order = Math.floor(kind.state / 16);
    const high = 2 ** zeros - 1 + bits(zeros);
    const value = high * 2 ** order + bits(order);
    demand(value < 2 ** 32, 'a number of more than 32 bits');
    kind.state = Math.floor((3 * kind.state + 16 * Math.floor(Math.log2(Math.max(1, value)))) / 4);
    return value;
  };
  const signed = (kind) => unfold(number(kind));
  // The bytes from which bits were taken.
  const bytes_taken = () => {
    const bytes = Math.ceil(at / 8);
    demand(bits(8 * bytes - at) === 0, `the last byte of the ${name} is not padded with zeros`);
    return bytes;
  };
  const end = () => demand(bytes_taken() === part.length, `the ${name} goes on`);
  return { bits, number, signed, bytes_taken, end };
}

export const unfold = (value) => (value % 2 === 0 ? value / 2 : -(value + 1) / 2);

// Kinds of numbers with their orders at the start.
export const kinds_of = (orders) =>
  Object.fromEntries(Object.entries(orders).map(([name, order]) => [name, { state: 16 * order }]));
