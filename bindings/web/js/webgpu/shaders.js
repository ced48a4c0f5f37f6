// All stages in WGSL, in reading order. One module has them all; each entry point is a pipeline.
import { attribute_views, attributes } from './attributes.wgsl.js';
import { border_walk } from './border_walk.wgsl.js';
import { connectivity } from './connectivity.wgsl.js';
import { clers, edgebreaker_symbols } from './edgebreaker_symbols.wgsl.js';
import { floats } from './floats.wgsl.js';
import { integers } from './integers.wgsl.js';
import { records } from './layout.js';
import { multi_parallelogram } from './multi_parallelogram.wgsl.js';
import { normals } from './normals.wgsl.js';
import { octahedral } from './octahedral.wgsl.js';
import { platform } from './platform.wgsl.js';
import { prediction } from './prediction.wgsl.js';
import { rans } from './rans.wgsl.js';
import { seams } from './seams.wgsl.js';
import { stitch } from './stitch.wgsl.js';
import { stitch_map } from './stitch_map.wgsl.js';
import { symbols } from './symbols.wgsl.js';
import { tex_coords } from './tex_coords.wgsl.js';
import { traversal } from './traversal.wgsl.js';
import { value_writer } from './value_writer.wgsl.js';

export const parts = { records, platform, rans, integers, floats, clers, edgebreaker_symbols, connectivity, seams, traversal, attribute_views, attributes, symbols,
  prediction, multi_parallelogram, octahedral, normals, tex_coords, stitch_map, border_walk, stitch, value_writer };
export const code = Object.values(parts).join('');

/**
 * The stages in the order in which they run. `by` says what a stage is dispatched for: a thread for each stream ('stream'), or for each
 * list of symbols, data, group or attribute of each stream; or the lanes of a group for each stream ('lanes'), or for each of its attributes.
 */
export const stages = [
  { entry: 'begin', by: 'lanes' },
  { entry: 'decode_lists', by: 'list' },
  { entry: 'decode', by: 'stream' },
  { entry: 'cut', by: 'data' },
  { entry: 'number_points', by: 'stream', of: 'data' },
  { entry: 'traverse', by: 'group' },
  { entry: 'read_attributes', by: 'stream' },
  { entry: 'decode_symbols', by: 'attribute' },
  { entry: 'predict', by: 'attribute' },
  { entry: 'predict_from_positions', by: 'attribute', of: 'other attribute' },
  { entry: 'link_border', by: 'lanes' },
  { entry: 'number', by: 'stream' },
  { entry: 'resolve', by: 'lanes' },
  { entry: 'write_faces', by: 'lanes' },
  { entry: 'write_values', by: 'lanes of attribute' },
];
