// Types of components, by Draco's numbers.
export const kArrays = [undefined, Int8Array, Uint8Array, Int16Array, Uint16Array, Int32Array, Uint32Array, BigInt64Array,
  BigUint64Array, Float32Array, Float64Array, Uint8Array];
export const kTypes = [undefined, 'int8', 'uint8', 'int16', 'uint16', 'int32', 'uint32', 'int64', 'uint64', 'float32', 'float64',
  'bool'];
export const kSemantics = ['POSITION', 'NORMAL', 'COLOR', 'TEX_COORD', 'GENERIC'];
export const array_of = (type) => kArrays[kTypes.indexOf(type)];
