// A drop-in for the file of the same name of draco3d: the emscripten interface of Draco's decoder, on top of psplit's.
// It is a classic script, because loaders evaluate it in workers, by importScripts, by a script tag or by require.
// conformance.md says what differs.
// eslint-disable-next-line no-unused-vars
var DracoDecoderModule = (() => {
  'use strict';

  //#include bindings/web/draco/emscripten.js

  const kConstants = {
    ATTRIBUTE_INVALID_TRANSFORM: -1, ATTRIBUTE_NO_TRANSFORM: 0, ATTRIBUTE_QUANTIZATION_TRANSFORM: 1,
    ATTRIBUTE_OCTAHEDRON_TRANSFORM: 2,
    INVALID: -1, POSITION: 0, NORMAL: 1, COLOR: 2, TEX_COORD: 3, GENERIC: 4,
    INVALID_GEOMETRY_TYPE: -1, POINT_CLOUD: 0, TRIANGULAR_MESH: 1,
    DT_INVALID: 0, DT_INT8: 1, DT_UINT8: 2, DT_INT16: 3, DT_UINT16: 4, DT_INT32: 5, DT_UINT32: 6, DT_INT64: 7,
    DT_UINT64: 8, DT_FLOAT32: 9, DT_FLOAT64: 10, DT_BOOL: 11, DT_TYPES_COUNT: 12,
    OK: 0, DRACO_ERROR: -1, IO_ERROR: -2, INVALID_PARAMETER: -3, UNSUPPORTED_VERSION: -4, UNKNOWN_VERSION: -5,
  };
  const { DT_INT8, DT_UINT8, DT_INT16, DT_UINT16, DT_INT32, DT_UINT32, DT_FLOAT32 } = kConstants;
  // Of the types that can be asked for.
  const kArrays = [undefined, Int8Array, Uint8Array, Int16Array, Uint16Array, Int32Array, Uint32Array, undefined, undefined,
    Float32Array];
  const kRaw = 0, kQuantized = 2, kNormal = 3;  // codings
  const kHeaderBytes = 11, kMagic = [68, 82, 65, 67, 79];  // DRACO
  // The items of stream_metadata: a tree of an attribute or of the geometry begins, a part of it begins, an entry, an end.
  const kGeometryTree = 1, kPart = 2, kEntry = 3;
  const kMostDepth = 1001;  // draco3d's limit of nested parts

  // The handle of what decoding makes of the bytes, or 0.
  function decode_bytes(core, bytes) {
    const own = bytes.buffer === core.buffer ? bytes.slice() : bytes, at = core.allocate(bytes.length);  // which may detach views
    new Uint8Array(core.buffer, at, own.length).set(own);
    return core.call('decode_stream', at, own.length);
  }

  function make_module(started, config) {
    const memory = new Memory(started), { WrapperObject, null_of, array_class, members } = make_objects();
    class Status extends WrapperObject {
      #code;
      #message;
      constructor(code = kConstants.OK, message = '') {
        super();
        this.#code = code;
        this.#message = message;
      }
      code() { return this.#code; }
      ok() { return this.#code === kConstants.OK; }
      error_msg() { return this.#message; }
    }

    class DecoderBuffer extends WrapperObject {
      data_ = new Uint8Array(0);
      Init(data, size) {
        this.data_ = view_of(data, size).slice();
      }
    }
    const view_of = (data, size) => {
      const bytes = data instanceof ArrayBuffer ? new Uint8Array(data)
        : ArrayBuffer.isView(data) ? new Uint8Array(data.buffer, data.byteOffset, data.byteLength) : Uint8Array.from(data);
      return size === bytes.length ? bytes : bytes.subarray(0, size);
    };

    class GeometryAttribute extends WrapperObject {}
    // The words come from the export stream_attribute, and `is_skipped` holds if the values are the integers
    // before the attribute's transform.
    class PointAttribute extends WrapperObject {
      constructor(mesh, index) {
        super();
        // Meshes of few faces are decoded in the time of some of JavaScript's conveniences: here and below, words have numbers.
        const words = mesh.core_.words(mesh.core_.exports.stream_attribute(mesh.handle_, index), 10);
        this.semantic_ = words[0];
        this.type_ = words[1];
        this.components_ = words[2];
        this.normalized_ = words[3];
        this.unique_id_ = words[4];
        this.coding_ = words[5];
        this.bits_ = words[6];
        this.value_count_ = mesh.has_order_ ? words[9] : mesh.counts_[1];
        this.range_bits_ = words[7];
        this.origin_at_ = words[8];  // in the bytes of the stream, at any address
        this.mesh_ = mesh;
        this.index_ = index;
        this.is_skipped_ = mesh.skipped_.size > 0 && mesh.skipped_.has(this.semantic_) && (mesh.is_kd_tree_ ? this.coding_ === kQuantized : this.coding_ !== kRaw);
        if (!this.is_skipped_) return;
        // Attributes of a kD-tree lose their id.
        if (mesh.is_kd_tree_) this.unique_id_ = 0;
        this.type_ = mesh.is_kd_tree_ ? DT_UINT32 : DT_INT32;
        this.normalized_ = 0;
        if (this.coding_ === kNormal) this.components_ = 2;
      }
      size() { return this.value_count_; }
      attribute_type() { return this.semantic_; }
      data_type() { return this.type_; }
      num_components() { return this.components_; }
      normalized() { return this.normalized_ !== 0; }
      byte_stride() { return this.components_ * [0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 1][this.type_]; }
      byte_offset() { return 0; }
      unique_id() { return this.unique_id_; }
      GetAttributeTransformData() {
        const { ATTRIBUTE_OCTAHEDRON_TRANSFORM, ATTRIBUTE_QUANTIZATION_TRANSFORM } = kConstants;
        return this.is_skipped_ && this.coding_ === kNormal ? new AttributeTransformData(ATTRIBUTE_OCTAHEDRON_TRANSFORM)
          : this.is_skipped_ && this.coding_ === kQuantized ? new AttributeTransformData(ATTRIBUTE_QUANTIZATION_TRANSFORM)
            : kNoTransform;
      }
    }
    // Nothing can be read of it.
    const kNoAttribute = null_of(PointAttribute, { semantic_: 0, type_: 0, components_: 0, normalized_: 0, unique_id_: 0,
      coding_: kRaw, is_skipped_: false, value_count_: 0 });
    class AttributeTransformData extends WrapperObject {
      constructor(type = -1) {
        super();
        this.type_ = type;
      }
      transform_type() { return this.type_; }
    }
    const kNoTransform = null_of(AttributeTransformData, { type_: kConstants.ATTRIBUTE_INVALID_TRANSFORM });
    // An attribute whose values are those before a transform, as { bits_, range_, origin_ }; undefined if it is not.
    function transformed(attribute, coding, transform) {
      if (attribute instanceof PointAttribute) {
        if (!attribute.is_skipped_ || attribute.coding_ !== coding) return undefined;
        const { mesh_: { core_: { buffer } }, bits_, range_bits_, origin_at_, components_ } = attribute;
        return { bits_, range_: new Float32Array(Uint32Array.of(range_bits_).buffer)[0],
          origin_: coding === kQuantized ? new Float32Array(buffer.slice(origin_at_, origin_at_ + 4 * components_)) : [] };
      }
      const theirs = new draco3d[transform]();
      const result = theirs.InitFromAttribute(attribute) ? { bits_: theirs.quantization_bits(), range_: theirs.range?.(),
        origin_: Array.from({ length: attribute.num_components() }, (_, axis) => theirs.min_value?.(axis)) } : undefined;
      draco3d.destroy(theirs);
      return result;
    }
    class AttributeQuantizationTransform extends WrapperObject {
      InitFromAttribute(attribute) {
        this.attribute_ = transformed(attribute, kQuantized, 'AttributeQuantizationTransform');
        return this.attribute_ !== undefined;
      }
      quantization_bits() { return this.attribute_?.bits_ ?? -1; }
      min_value(axis) { return this.attribute_?.origin_[axis] ?? 0; }
      range() { return this.attribute_?.range_ ?? 0; }
    }
    class AttributeOctahedronTransform extends WrapperObject {
      InitFromAttribute(attribute) {
        this.attribute_ = transformed(attribute, kNormal, 'AttributeOctahedronTransform');
        return this.attribute_ !== undefined;
      }
      quantization_bits() { return this.attribute_?.bits_ ?? -1; }
    }

    class PointCloud extends WrapperObject {
      counts_ = [0, 0, 0];  // faces, points, attributes
      handle_ = 0;
      skipped_ = new Set();
      attributes_ = [];
      metadata_ = [];  // of attributes with their unique ids, and last of the geometry
      theirs_;  // draco3d's object, if draco3d decoded it
      num_attributes() { return this.counts_[2]; }
      num_points() { return this.counts_[1]; }
      clear_() {
        if (this.theirs_ !== undefined) draco3d.destroy(this.theirs_);
        this.theirs_ = undefined;
        if (this.handle_ === 0) return;
        if (!this.core_.broken) this.core_.exports.free_stream(this.handle_);
        memory.leave(this.core_);
        this.handle_ = 0;
        for (const attribute of this.attributes_) attribute.__destroy__();
        for (const [, metadata] of this.metadata_) metadata.__destroy__();
        this.attributes_ = [];
        this.metadata_ = [];
        this.faces_ = undefined;
        this.counts_ = [0, 0, 0];
      }
      __destroy__() {
        this.clear_();
        super.__destroy__();
      }
    }
    class Mesh extends PointCloud {
      num_faces() { return this.counts_[0]; }
    }
    // Names are strings of bytes, in whose order draco3d has them.
    class Metadata extends WrapperObject {
      constructor(entries = new Map()) {
        super();
        this.entries_ = entries;
      }
    }
    const kNoMetadata = null_of(Metadata, { entries_: new Map() });
    const text_of_bytes = (bytes) => new TextDecoder().decode(bytes).split('\0', 1)[0];
    const entry_of = ({ entries_: entries }, name) => entries.get(string_of_bytes(bytes_of_text(name)));
    // The metadata of a decoded stream that has some, as of a mesh. Undefined if it is more than draco3d accepts.
    function metadata_of({ core_: core, handle_: handle }, size) {
      const [at, count] = core.words(core.call('stream_metadata', handle, size), 2), words = core.words(at, count).slice(), trees = [];
      core.exports.release(at);
      const bytes = (at, size) => new Uint8Array(core.buffer, at, size), name_of = (at, size) => string_of_bytes(bytes(at, size));
      let entries, open;  // entries of parts cannot be asked for
      for (let i = 0; i < words.length; i += 5) {
        const [call, first, second, third, fourth] = words.subarray(i, i + 5);
        if (call <= kGeometryTree) {
          trees.push([call === kGeometryTree ? undefined : first, entries = new Map()]);
          open = [];
        } else if (call === kPart) {
          while (open.at(-1).missing === 0) open.pop();
          const { names } = open.at(-1), count = names.size;
          --open.at(-1).missing;
          if (open.length > kMostDepth || names.add(name_of(first, second)).size === count) return undefined;
          entries = undefined;
        } else if (call === kEntry) {
          if (fourth === 0) return undefined;
          entries?.set(name_of(first, second), bytes(third, fourth).slice());
        } else if (first > 0) {
          open.push({ missing: first, names: new Set() });
        }
      }
      return trees.map(([unique_id, tree]) => [unique_id, new Metadata(tree)]);
    }
    class MetadataQuerier extends WrapperObject {
      HasEntry(metadata, name) { return entry_of(metadata, name) !== undefined; }
      GetIntEntry(metadata, name) {
        const value = entry_of(metadata, name);
        return value?.length === 4 ? new Int32Array(value.buffer)[0] : 0;
      }
      GetIntEntryArray(metadata, name, out) {
        const value = entry_of(metadata, name);
        out.array_ = new Int32Array(value?.length % 4 === 0 ? value.buffer : 0);
      }
      GetDoubleEntry(metadata, name) {
        const value = entry_of(metadata, name);
        return value?.length === 8 ? new Float64Array(value.buffer)[0] : 0;
      }
      GetStringEntry(metadata, name) { return text_of_bytes(entry_of(metadata, name)); }
      NumEntries(metadata) { return metadata.entries_.size; }
      GetEntryName(metadata, number) {
        return text_of_bytes(Uint8Array.from([...metadata.entries_.keys()].sort()[number] ?? '', (letter) => letter.charCodeAt()));
      }
    }
    // The calls above are for metadata that psplit read.
    for (const name of Object.getOwnPropertyNames(MetadataQuerier.prototype)) {
      if (name === 'constructor') continue;
      const own = MetadataQuerier.prototype[name];
      MetadataQuerier.prototype[name] = function (metadata, ...rest) {
        if (metadata instanceof Metadata) return own.call(this, metadata, ...rest);
        this.theirs_ ??= new draco3d.MetadataQuerier();
        return call_draco3d(this.theirs_, name, metadata, rest);
      };
    }

    class Decoder extends WrapperObject {
      #skipped = new Set();

      // draco3d looks at one byte of an array.
      GetEncodedGeometryType(data) {
        if (data instanceof DecoderBuffer) return header_status(data.data_).ok() ? kind_of(data.data_) : kConstants.INVALID_GEOMETRY_TYPE;
        return data.byteLength < 8 ? kConstants.INVALID_GEOMETRY_TYPE : kind_of(data);
      }
      GetEncodedGeometryType_Deprecated(buffer) { return this.GetEncodedGeometryType(buffer); }

      DecodeArrayToMesh(data, size, mesh) { return this.#decode(view_of(data, size), mesh, 'Mesh'); }
      DecodeBufferToMesh(buffer, mesh) { return this.#decode(buffer.data_, mesh, 'Mesh'); }
      DecodeArrayToPointCloud(data, size, cloud) { return this.#decode(view_of(data, size), cloud, 'PointCloud'); }
      DecodeBufferToPointCloud(buffer, cloud) { return this.#decode(buffer.data_, cloud, 'PointCloud'); }
      #decode(bytes, mesh, kind) {
        mesh.clear_();
        const status = header_status(bytes, kind === 'Mesh' ? kConstants.TRIANGULAR_MESH : kConstants.POINT_CLOUD);
        if (is_fault(status)) return status;
        const major = bytes[5], minor = bytes[6];
        if (status.ok() && major === 2 && minor >= 2) return this.#decode_by_psplit(bytes, mesh);
        return this.#decode_by_draco3d(bytes, mesh, kind, !status.ok() ? status : new Status(kConstants.UNSUPPORTED_VERSION,
          `psplit: bitstream ${major}.${minor} is older than 2.2, the oldest that is decoded`));
      }
      // What psplit refuses, with `refusal`, if the page offers no draco3d.
      #decode_by_draco3d(bytes, mesh, kind, refusal) {
        try {
          draco3d ??= load_draco3d(config.draco3d ?? DracoDecoderModule.draco3d);
        } catch (error) {
          return new Status(refusal.code(), `${refusal.error_msg()} (${error.message})`);
        }
        if (draco3d === undefined) return refusal;
        mesh.theirs_ = new draco3d[kind]();
        const status = this.their_decoder_()[`DecodeArrayTo${kind}`](bytes, bytes.length, mesh.theirs_);
        mesh.counts_ = [mesh.theirs_.num_faces?.() ?? 0, mesh.theirs_.num_points(), mesh.theirs_.num_attributes()];
        return new Status(status.code(), status.error_msg());
      }
      their_decoder_() {
        if (this.theirs_ === undefined) {
          this.theirs_ = new draco3d.Decoder();
          for (const semantic of this.#skipped) this.theirs_.SkipAttributeTransform(semantic);
        }
        return this.theirs_;
      }
      __destroy__() {
        if (this.theirs_ !== undefined) draco3d.destroy(this.theirs_);
        super.__destroy__();
      }
      #decode_by_psplit(bytes, mesh) {
        mesh.core_ = memory.usable_core();
        mesh.skipped_ = new Set(this.#skipped);
        const { exports } = mesh.core_;
        try {
          mesh.handle_ = decode_bytes(mesh.core_, bytes);
          if (mesh.handle_ === 0) return new Status(kConstants.DRACO_ERROR, mesh.core_.last_error().message);
          ++mesh.core_.live;
          const counts = mesh.core_.words(exports.stream_counts(mesh.handle_), 3);
          mesh.counts_ = [counts[0], counts[1], counts[2]];
          const is_mesh = bytes[7] === kConstants.TRIANGULAR_MESH, is_sequential = bytes[8] === 0;
          mesh.has_order_ = is_mesh && !is_sequential;  // Edgebreaker's order of values, which is not that of points
          mesh.is_kd_tree_ = !is_mesh && !is_sequential;
          for (let i = 0; i < counts[2]; ++i) mesh.attributes_.push(new PointAttribute(mesh, i));
          const metadata = bytes[10] >= 128 ? metadata_of(mesh, bytes.length) : [];
          if (metadata !== undefined) {
            mesh.metadata_ = metadata;
            memory.make_room(room_for(mesh));
            return new Status();
          }
          mesh.clear_();
          return new Status(kConstants.DRACO_ERROR, 'psplit: Draco stream: metadata with an empty value, or that repeat a name or nest too deeply');
        } catch (error) {
          mesh.clear_();
          if (!(error instanceof RangeError)) throw error;
          return new Status(kConstants.DRACO_ERROR, error.message);
        }
      }

      // Values are addressed by their place among the attributes, as draco3d's ids are.
      GetAttributeId(mesh, semantic) { return mesh.attributes_.findIndex((attribute) => attribute.semantic_ === semantic); }
      GetAttribute(mesh, id) { return mesh.attributes_[id] ?? kNoAttribute; }
      GetAttributeByUniqueId(mesh, unique_id) {
        return mesh.attributes_.find((attribute) => attribute.unique_id_ === unique_id) ?? kNoAttribute;
      }
      GetAttributeIdByName(mesh, name) { return this.GetAttributeIdByMetadataEntry(mesh, 'name', name); }
      GetAttributeIdByMetadataEntry(mesh, name, value) {
        const wanted = string_of_bytes(bytes_of_text(value));
        const unique_id = mesh.metadata_.slice(0, -1).find(([, metadata]) => {
          const entry = entry_of(metadata, name);
          return entry?.length > 0 && entry.length === wanted.length && string_of_bytes(entry) === wanted;
        })?.[0];
        return mesh.attributes_.findIndex((attribute) => attribute.unique_id_ === unique_id);
      }
      GetMetadata(mesh) { return mesh.metadata_.at(-1)?.[1] ?? kNoMetadata; }
      GetAttributeMetadata(mesh, id) {
        return mesh.metadata_.find(([unique_id]) => unique_id !== undefined && unique_id === mesh.attributes_[id]?.unique_id_)?.[1] ?? kNoMetadata;
      }

      GetTrianglesUInt16Array(mesh, size, out) {
        return mesh.num_points() <= 65536 && this.#write_faces(mesh, 2, size, out);
      }
      GetTrianglesUInt32Array(mesh, size, out) { return this.#write_faces(mesh, 4, size, out); }
      #write_faces(mesh, index_bytes, size, out) {
        if (size !== 3 * mesh.num_faces() * index_bytes) return false;
        write(mesh, out, size, (at) => mesh.core_.exports.write_faces(mesh.handle_, index_bytes, at));
        return true;
      }
      GetFaceFromMesh(mesh, face, out) {
        if (!(face >= 0 && face < mesh.num_faces())) return false;
        mesh.faces_ ??= read(mesh, Uint32Array, 3 * mesh.num_faces(), (at) => mesh.core_.exports.write_faces(mesh.handle_, 4, at));
        out.array_ = Int32Array.from(mesh.faces_.subarray(3 * face, 3 * face + 3));
        return true;
      }

      // Only draco3d's own meshes have triangle strips.
      GetTriangleStripsFromMesh() { throw new Error('psplit makes no triangle strips'); }
      GetAttributeFloat(attribute, number, out) {
        if (!(attribute instanceof PointAttribute)) return call_draco3d(this.their_decoder_(), 'GetAttributeFloat', attribute, [number, out]);
        const { mesh_: mesh, components_: components } = attribute;
        if (!(number >= 0 && number < attribute.value_count_)) return false;
        const floats = (attribute.floats_ ??= values_of(mesh, attribute, DT_FLOAT32)), point = !mesh.has_order_ ? number
          : (attribute.value_numbers_ ??= read(mesh, Uint32Array, mesh.num_points(),
            (at) => (mesh.core_.exports.write_value_numbers(mesh.handle_, attribute.index_, at), 1))).indexOf(number);
        if (point < 0) return false;
        out.array_ = floats.slice(point * components, (point + 1) * components);
        return true;
      }

      GetAttributeDataArrayForAllPoints(mesh, attribute, type, size, out) {
        const Type = kArrays[type];
        if (Type === undefined || attribute === kNoAttribute) return false;
        if (size !== value_count(mesh, attribute) * Type.BYTES_PER_ELEMENT) return false;
        if (!attribute.is_skipped_) {
          return write(mesh, out, size, (at) => mesh.core_.exports.write_attribute(mesh.handle_, attribute.index_, type, at)) !== 0;
        }
        const values = converted(integers_of(mesh, attribute), type);
        if (values === null) return false;
        new Type(memory.heap.buffer, out, values.length).set(values);
        return true;
      }
      GetAttributeFloatForAllPoints(mesh, attribute, out) { return values_for_all_points(mesh, attribute, DT_FLOAT32, out); }
      GetAttributeIntForAllPoints(mesh, attribute, out) { return values_for_all_points(mesh, attribute, DT_INT32, out); }
      GetAttributeInt8ForAllPoints(mesh, attribute, out) { return values_for_all_points(mesh, attribute, DT_INT8, out); }
      GetAttributeUInt8ForAllPoints(mesh, attribute, out) { return values_for_all_points(mesh, attribute, DT_UINT8, out); }
      GetAttributeInt16ForAllPoints(mesh, attribute, out) { return values_for_all_points(mesh, attribute, DT_INT16, out); }
      GetAttributeUInt16ForAllPoints(mesh, attribute, out) { return values_for_all_points(mesh, attribute, DT_UINT16, out); }
      GetAttributeInt32ForAllPoints(mesh, attribute, out) { return values_for_all_points(mesh, attribute, DT_INT32, out); }
      GetAttributeUInt32ForAllPoints(mesh, attribute, out) { return values_for_all_points(mesh, attribute, DT_UINT32, out); }

      SkipAttributeTransform(semantic) {
        this.#skipped.add(semantic);
        this.theirs_?.SkipAttributeTransform(semantic);
      }
    }
    // The calls above are for meshes that psplit decoded.
    for (const name of Object.getOwnPropertyNames(Decoder.prototype)) {
      if (!/^Get(?!EncodedGeometryType|AttributeFloat$)/.test(name)) continue;
      const own = Decoder.prototype[name];
      Decoder.prototype[name] = function (mesh, a, b, c, d) {
        return mesh.theirs_ === undefined ? own.call(this, mesh, a, b, c, d)
          : call_draco3d(this.their_decoder_(), name, mesh.theirs_, [...arguments].slice(1));
      };
    }

    // draco3d, which decodes what psplit refuses.
    let draco3d;
    // Calls draco3d with copies of the arguments that draco3d writes: Draco's arrays, and memory of this module.
    function call_draco3d(object, name, subject, rest) {
      const arrays = rest.filter((argument) => argument?.array_ !== undefined).map((ours) => [ours, new draco3d[ours.name_]()]);
      const copies = new Map(arrays), size = /Triangles|DataArray/.test(name) ? rest.at(-2) : 0;
      const at = size > 0 ? draco3d._malloc(size) : 0;
      try {
        const result = object[name](subject, ...rest.map((argument, i) =>
          (at !== 0 && i === rest.length - 1 ? at : copies.get(argument) ?? argument)));
        for (const [ours, theirs] of arrays)
          ours.array_ = ours.array_.constructor.from({ length: theirs.size() }, (_, i) => theirs.GetValue(i));
        if (at !== 0 && result) new Uint8Array(memory.heap.buffer, rest.at(-1), size).set(draco3d.HEAPU8.subarray(at, at + size));
        return result;
      } finally {
        for (const [, theirs] of arrays) draco3d.destroy(theirs);
        if (at !== 0) draco3d._free(at);
      }
    }

    // The most that a page allocates for the faces or for an attribute. Loaders free it before they ask for the next one.
    const room_for = ({ counts_: [face_count, point_count], attributes_: attributes }) =>
      Math.max(12 * face_count, ...attributes.map(({ components_ }) => 4 * components_ * point_count));
    const value_count = (mesh, attribute) => mesh.num_points() * attribute.components_;
    // Has something written to `out`, which is memory of _malloc. It may lie in another instance than the mesh.
    function write(mesh, out, size, write_to) {
      if (mesh.core_ === memory.heap) return write_to(out);
      const at = mesh.core_.allocate(size), result = write_to(at);
      new Uint8Array(memory.heap.buffer, out, size).set(new Uint8Array(mesh.core_.buffer, at, size));
      mesh.core_.exports.release(at);
      return result;
    }
    // A new array of the written values; null if it returns 0.
    function read(mesh, Type, length, write_to) {
      const at = mesh.core_.allocate(length * Type.BYTES_PER_ELEMENT);
      try {
        return write_to(at) === 0 ? null : new Type(mesh.core_.buffer, at, length).slice();
      } finally {
        mesh.core_.exports.release(at);
      }
    }
    const integers_of = (mesh, attribute) => read(mesh, kArrays[attribute.type_], value_count(mesh, attribute),
      (at) => mesh.core_.exports.write_integers(mesh.handle_, attribute.index_, at));
    // Null if a number does not fit the type. As libdraco compares them, all fit DT_UINT32.
    function converted(integers, type) {
      const values = new kArrays[type](integers);
      return type === DT_FLOAT32 || type === DT_UINT32 || values.every((value, i) => value === integers[i]) ? values : null;
    }
    // Null if a value does not fit the type.
    function values_of(mesh, attribute, type) {
      return attribute.is_skipped_ ? converted(integers_of(mesh, attribute), type)
        : read(mesh, kArrays[type], value_count(mesh, attribute),
          (at) => mesh.core_.exports.write_attribute(mesh.handle_, attribute.index_, type, at));
    }
    // Whether values of the two types are the same bytes.
    const is_twin = (a, b) => a !== b && a >= DT_INT8 && a <= DT_UINT32 && Math.ceil(a / 2) === Math.ceil(b / 2);
    function values_for_all_points(mesh, attribute, type, out) {
      if (attribute === kNoAttribute) return false;
      // draco3d copies the bytes of values that are in the order of points.
      const stored = !mesh.has_order_ && is_twin(attribute.type_, type) ? attribute.type_ : type;
      const values = values_of(mesh, attribute, stored);
      if (values === null) return false;
      out.array_ = stored === type ? values : new kArrays[type](values.buffer);
      return true;
    }

    // draco3d's code for a faulty header. `kind`: the one that is wanted.
    function header_status(bytes, kind = bytes[7]) {
      const refuse = (code, what) => new Status(kConstants[code], `psplit: ${what}`);
      const major = bytes[5], minor = bytes[6];
      if (bytes.length >= kMagic.length && kMagic.some((letter, i) => bytes[i] !== letter)) return refuse('DRACO_ERROR', 'not a Draco stream');
      if (bytes.length < kHeaderBytes) return refuse('IO_ERROR', 'the stream ends early');
      if (kind_of(bytes) !== kind) return refuse('DRACO_ERROR', `not a ${kind === kConstants.POINT_CLOUD ? 'point cloud' : 'mesh'}`);
      if (bytes[8] > 1) return refuse('DRACO_ERROR', 'a coding method that does not exist');
      // The newest bitstreams are 2.2 of meshes and 2.3 of point clouds.
      const newest = kind === kConstants.POINT_CLOUD ? 3 : 2;
      if (major < 1 || major > 2 || (major === 2 && minor > newest)) return refuse('UNKNOWN_VERSION', `unknown bitstream ${major}.${minor}`);
      return new Status();
    }
    // An unknown version may be one that draco3d knows.
    const is_fault = (status) => !status.ok() && status.code() !== kConstants.UNKNOWN_VERSION;
    const kind_of = (bytes) => (bytes[7] <= 1 ? bytes[7] : kConstants.INVALID_GEOMETRY_TYPE);

    const module = Object.assign(config, kConstants, members, {
      Status, DecoderBuffer, GeometryAttribute, PointAttribute, AttributeTransformData,
      AttributeQuantizationTransform, AttributeOctahedronTransform, PointCloud, Mesh, Metadata, MetadataQuerier, Decoder,
      ...Object.fromEntries(Object.entries({ DracoFloat32Array: Float32Array, DracoInt8Array: Int8Array, DracoUInt8Array: Uint8Array,
        DracoInt16Array: Int16Array, DracoUInt16Array: Uint16Array, DracoInt32Array: Int32Array, DracoUInt32Array: Uint32Array })
        .map(([name, Type]) => [name, array_class(Type, name)])),
    });
    memory.add_members(module);
    return module;
  }

  // draco3d's module from `offered`: the module, or the address of the folder of its draco_wasm_wrapper.js and
  // draco_decoder.wasm. Decoding is synchronous, so only a classic worker can load these when they are needed.
  function load_draco3d(offered) {
    if (typeof offered !== 'string') return offered;
    if (typeof importScripts !== 'function') throw new Error('draco3d can be loaded from an address in a classic worker only');
    const address = (file) => new URL(file, offered.replace(/\/?$/, '/')).href;
    const request = new XMLHttpRequest();
    request.open('GET', address('draco_decoder.wasm'), false);
    request.responseType = 'arraybuffer';
    request.send();
    if (request.status !== 200) throw new Error(`${address('draco_decoder.wasm')}: HTTP status ${request.status}`);
    const compiled = new WebAssembly.Module(request.response), own = globalThis.DracoDecoderModule;
    importScripts(address('draco_wasm_wrapper.js'));
    const theirs = { instantiateWasm(imports, done) {
      const instance = new WebAssembly.Instance(compiled, imports);
      done(instance);
      return instance.exports;
    } };
    globalThis.DracoDecoderModule(theirs);
    globalThis.DracoDecoderModule = own;
    if (theirs.Decoder === undefined) throw new Error(`${offered} has no draco3d that starts at once`);
    return theirs;
  }

  return starter_of('draco_decoder.wasm', make_module);
})();

if (typeof module === 'object' && typeof exports === 'object') {
  module.exports = DracoDecoderModule;
  module.exports.createDecoderModule = DracoDecoderModule;
}
