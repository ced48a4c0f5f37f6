// What this decoder leaves to WebAssembly: containers that it does not decode, and all that are broken. WebAssembly then gives the
// result, or the error.
export class Refusal extends Error {}
export function refuse(why) {
  throw new Refusal(why);
}
