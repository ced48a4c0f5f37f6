// Condensed streams (src/core/condensed/condensed_stream.h): their shaders, and how JavaScript reads and places them. Pages load this with
// the first container that has some.
import { border_part } from './border_part.wgsl.js';
import { condensed_attributes } from './condensed_attributes.wgsl.js';
import { condensed_connectivity } from './condensed_connectivity.wgsl.js';
import { CondensedTables } from './condensed_head.js';
import { add_condensed_record_words, condensed_records, condensed_stream_words, CondensedLayout, shared_bytes } from './condensed_layout.js';
import { read_condensed_stream } from './condensed_stream.js';
import { creation } from './creation.wgsl.js';
import { are_justified, read_directory } from './directory.js';
import { refuse } from './refusal.js';
import { section } from './section.wgsl.js';
import { parts } from './shaders.js';

// Streams are read otherwise; all else is the same.
const { rans, edgebreaker_symbols, attributes, symbols, ...shared } = parts;
const code = Object.values({ ...shared, condensed_records, section, condensed_connectivity, border_part, creation, condensed_attributes }).join('');

// As in shaders.js. The border is numbered first, because values at it are known before all others.
const stages = [
  { entry: 'begin', by: 'lanes' },
  { entry: 'decode_condensed', by: 'stream' },
  { entry: 'cut', by: 'data' },
  { entry: 'number_points', by: 'stream', of: 'data' },
  { entry: 'link_border', by: 'lanes' },
  { entry: 'number', by: 'stream' },
  { entry: 'place_own_values', by: 'stream' },
  { entry: 'share_values', by: 'lanes' },
  { entry: 'find_orders', by: 'attribute' },
  { entry: 'find_predictors', by: 'lanes of attribute' },
  { entry: 'traverse', by: 'group' },
  { entry: 'decode_tokens', by: 'attribute' },
  { entry: 'create', by: 'attribute' },
  { entry: 'predict', by: 'attribute' },
  { entry: 'predict_from_positions', by: 'attribute', of: 'other attribute' },
  { entry: 'resolve', by: 'lanes' },
  { entry: 'write_faces', by: 'lanes' },
  { entry: 'write_values', by: 'lanes of attribute' },
];

function read_condensed_directory(bytes) {
  const directory = read_directory(bytes, CondensedTables), { tables, has_references } = directory;
  // Values at borders need walks.
  return { ...directory, plan_words: tables.words.length, has_references: has_references || tables.has_borders, shared_bytes: 0, width: undefined };
}
function read_head(reader, directory, i) {
  const head = read_condensed_stream(reader, directory, i), { tables, references, stream_at, stream_count } = directory;
  if (!tables.has_borders) return head;
  const { bytes, width } = shared_bytes({ ...head, reference_count: references[i] });
  directory.width ??= width;
  directory.shared_bytes += bytes;
  if (width !== directory.width) refuse('shared values of other components');
  if (!are_justified(directory.shared_bytes, stream_at[stream_count] - stream_at[0])) refuse('shared values that the bytes do not justify');
  return head;
}

/** See `draco` of container_plan.js. */
export const condensed = { is_condensed: true, code, stages, Layout: CondensedLayout, stream_words: condensed_stream_words,
  add_record_words: add_condensed_record_words, read_directory: read_condensed_directory, read_head };
