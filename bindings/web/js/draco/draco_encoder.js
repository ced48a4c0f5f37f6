// A drop-in for draco3d's encoder: its emscripten interface, on top of psplit's. A classic script, as the decoder beside it.
// encoder.md says what differs.
// eslint-disable-next-line no-unused-vars
var DracoEncoderModule = (() => {
  'use strict';

  //#include bindings/web/draco/emscripten.js

  const kConstants = {
    INVALID_GEOMETRY_TYPE: -1, POINT_CLOUD: 0, TRIANGULAR_MESH: 1,
    INVALID: -1, POSITION: 0, NORMAL: 1, COLOR: 2, TEX_COORD: 3, GENERIC: 4,
    MESH_SEQUENTIAL_ENCODING: 0, MESH_EDGEBREAKER_ENCODING: 1,
  };
  const { POSITION, GENERIC, MESH_EDGEBREAKER_ENCODING } = kConstants;
  const kMostComponents = 127, kMostSpeed = 10, kDefaultSpeed = 5, kLongestName = 255, kUnsupported = 5;
  const kFlagsAt = 10, kHasMetadata = 0x80, kHeaderBytes = 11;

  // Draco keeps the numbers of a grid as text with six decimals, of halves the even one. Only odd multiples of 2^-7 are halves.
  function as_in_text(number) {
    const value = Math.fround(number);
    if (Math.abs(value * 128 % 2) !== 1) return Math.fround(Number(value.toFixed(6)));
    const digits = value.toFixed(7), last = Number(digits.at(-2));
    return Math.fround(Number(digits.slice(0, -1)) + (last % 2) * Math.sign(value) * 1e-6);
  }

  const varint = (number) => (number < 128 ? [number] : [(number & 127) | 128, ...varint(number >>> 7)]);

  function make_module(started, config) {
    const memory = new Memory(started), { WrapperObject, array_class, members } = make_objects();

    // The first numbers of an array, or of memory of _malloc.
    function numbers_of(source, Type, length, may_lack = false) {
      const numbers = typeof source === 'number' ? new Type(memory.heap.buffer, source, length) : source;
      if (may_lack && numbers.length < length) return numbers;
      if (!(numbers?.length >= length)) throw new RangeError(`psplit: ${length} numbers are needed, and ${numbers?.length ?? 0} given`);
      return numbers.length === length ? numbers : numbers.subarray?.(0, length) ?? numbers.slice(0, length);
    }

    class GeometryAttribute extends WrapperObject {}
    class PointAttribute extends WrapperObject {
      size() { return 0; }
      attribute_type() { return kConstants.INVALID; }
      data_type() { return 0; }
      num_components() { return 0; }
      normalized() { return false; }
      byte_stride() { return 0; }
      byte_offset() { return 0; }
      unique_id() { return 0; }
    }

    class PointCloud extends WrapperObject {
      handle_ = 0;
      point_count_ = 0;
      face_count_ = 0;
      attributes_ = [];  // of each its type and its number of values
      metadata_;         // of the geometry, with the attributes' metadata
      num_attributes() { return this.attributes_.length; }
      num_points() { return this.point_count_; }
      // The instance that has the mesh.
      open_() {
        if (this.handle_ !== 0) return this.core_;
        this.core_ = memory.usable_core();
        this.handle_ = this.core_.call('new_mesh');
        ++this.core_.live;
        return this.core_;
      }
      // Points that are equal become one.
      deduplicate_() {
        if (this.core_.call('deduplicate', this.handle_) === 0) return;
        this.point_count_ = this.core_.exports.point_count(this.handle_);
        for (const attribute of this.attributes_) attribute.count = this.point_count_;
      }
      __destroy__() {
        if (this.handle_ !== 0) {
          if (!this.core_.broken) this.core_.exports.free_mesh(this.handle_);
          memory.leave(this.core_);
          this.handle_ = 0;
        }
        super.__destroy__();
      }
    }
    class Mesh extends PointCloud {
      num_faces() { return this.face_count_; }
      set_num_points(count) { this.point_count_ = count; }
    }

    class Metadata extends WrapperObject {
      entries_ = new Map();  // names as strings of bytes
    }
    class MetadataBuilder extends WrapperObject {
      AddStringEntry(metadata, name, value) { return this.#add(metadata, name, bytes_of_text(value)); }
      AddIntEntry(metadata, name, value) { return this.#add(metadata, name, Int32Array.of(value)); }
      AddIntEntryArray(metadata, name, values, count) { return this.#add(metadata, name, Int32Array.from(numbers_of(values, Int32Array, count))); }
      AddDoubleEntry(metadata, name, value) { return this.#add(metadata, name, Float64Array.of(value)); }
      #add(metadata, name, value) {
        metadata.entries_.set(string_of_bytes(bytes_of_text(name)), new Uint8Array(value.buffer, value.byteOffset, value.byteLength));
        return true;
      }
    }
    const bytes_of_entries = (entries) => [...varint(entries.size), ...[...entries.keys()].sort().flatMap((name) => {
      const value = entries.get(name);
      return [name.length, ...[...name].map((letter) => letter.charCodeAt()), ...varint(value.length), ...value];
    }), 0];
    // A stream with metadata in it, or undefined if a name is too long for Draco.
    function with_metadata(stream, { entries, of_attributes }) {
      const all = [entries, ...of_attributes.map(([, of_attribute]) => of_attribute)];
      if (all.some((some) => [...some.keys()].some((name) => name.length > kLongestName))) return undefined;
      const bytes = [...varint(of_attributes.length),
        ...of_attributes.flatMap(([unique_id, of_attribute]) => [...varint(unique_id), ...bytes_of_entries(of_attribute)]),
        ...bytes_of_entries(entries)];
      const result = new Int8Array(stream.length + bytes.length);
      result.set(stream.subarray(0, kHeaderBytes));
      result[kFlagsAt] |= kHasMetadata;
      result.set(bytes, kHeaderBytes);
      result.set(stream.subarray(kHeaderBytes), kHeaderBytes + bytes.length);
      return result;
    }

    // The calls that PointCloudBuilder and MeshBuilder have in common.
    class Builder extends WrapperObject {
      AddFloatAttribute(...of) { return add_attribute(Float32Array, 9, ...of); }
      AddInt8Attribute(...of) { return add_attribute(Int8Array, 1, ...of); }
      AddUInt8Attribute(...of) { return add_attribute(Uint8Array, 2, ...of); }
      AddInt16Attribute(...of) { return add_attribute(Int16Array, 3, ...of); }
      AddUInt16Attribute(...of) { return add_attribute(Uint16Array, 4, ...of); }
      AddInt32Attribute(...of) { return add_attribute(Int32Array, 5, ...of); }
      AddUInt32Attribute(...of) { return add_attribute(Uint32Array, 6, ...of); }
      AddMetadata(cloud, metadata) {
        if (cloud.metadata_ !== undefined) return false;
        cloud.metadata_ = { entries: new Map(metadata.entries_), of_attributes: [] };
        return true;
      }
      SetMetadataForAttribute(cloud, id, metadata) {
        if (!(id in cloud.attributes_)) return false;
        cloud.metadata_ ??= { entries: new Map(), of_attributes: [] };
        cloud.metadata_.of_attributes.push([id, new Map(metadata.entries_)]);
        return true;
      }
      SetNormalizedFlagForAttribute(cloud, id, normalized) {
        if (!(id in cloud.attributes_)) return false;
        cloud.core_.exports.set_normalized(cloud.handle_, id, normalized ? 1 : 0);
        return true;
      }
    }
    function add_attribute(Type, type, cloud, semantic, count, components, values) {
      if (!(semantic >= POSITION && semantic <= GENERIC)) throw new RangeError(`psplit: ${semantic} is not a type of attributes`);
      if (!(components >= 1 && components <= kMostComponents)) throw new RangeError(`psplit: attributes have 1 to ${kMostComponents} components`);
      const numbers = numbers_of(values, Type, count * components), core = cloud.open_();
      if (cloud.point_count_ === 0) cloud.point_count_ = count;
      core.exports.set_point_count(cloud.handle_, count);
      const at = core.call('add_attribute', cloud.handle_, semantic, type, components) >>> 0;
      new Type(core.buffer, at, numbers.length).set(numbers);
      cloud.attributes_.push({ semantic, count, components });
      return cloud.point_count_ === count ? cloud.attributes_.length - 1 : -1;
    }
    class PointCloudBuilder extends Builder {}
    class MeshBuilder extends Builder {
      AddFacesToMesh(mesh, count, faces) {
        // three's DRACOExporter gives a third of the indices of a mesh without an index, and all faces by their count. The
        // missing faces are 0, 0, 0, which Edgebreaker leaves out.
        const indices = numbers_of(faces, Int32Array, 3 * count, true), core = mesh.open_();
        const at = core.call('set_face_count', mesh.handle_, count) >>> 0, all = new Int32Array(core.buffer, at, 3 * count);
        all.set(indices);
        all.fill(0, indices.length);
        mesh.face_count_ = count;
        return true;
      }
      AddFloatAttributeToMesh(...of) { return this.AddFloatAttribute(...of); }
      AddInt32AttributeToMesh(...of) { return this.AddInt32Attribute(...of); }
      AddMetadataToMesh(...of) { return this.AddMetadata(...of); }
    }

    // What Encoder and ExpertEncoder have in common. Quantization is set by type there, by attribute here.
    class AnyEncoder extends WrapperObject {
      #speeds = [-1, -1];
      #method = -1;
      #is_tracking = false;
      #quantization = new Map();
      #counts = [0, 0];  // points, faces

      SetSpeedOptions(encoding, decoding) { this.#speeds = [encoding, decoding]; }
      SetEncodingMethod(method) { this.#method = method; }
      SetTrackEncodedProperties(is_tracking) { this.#is_tracking = is_tracking; }
      SetAttributeQuantization(key, bits) { this.#quantization.set(key, { ...this.#quantization.get(key), bits }); }
      SetAttributeExplicitQuantization(key, bits, components, origin, range) {
        this.#quantization.set(key, { bits, range: as_in_text(range),
          origin: Array.from(numbers_of(origin, Float32Array, components), as_in_text) });
      }
      GetNumberOfEncodedPoints() { return this.#counts[0]; }
      GetNumberOfEncodedFaces() { return this.#counts[1]; }

      // Returns the length of the stream, or 0 where draco3d does. `key_of`: what the quantization of an attribute was set for.
      encode_(mesh, deduplicate, out, key_of) {
        const speed = Math.max(...this.#speeds) === -1 ? kDefaultSpeed : Math.max(...this.#speeds);
        if (!(speed >= 0 && speed <= kMostSpeed)) throw new RangeError(`psplit encodes at speeds from 0 to ${kMostSpeed}`);
        if (mesh.attributes_.some(({ count }) => count !== mesh.point_count_)) throw new Error('psplit: attributes with different numbers of values');
        if (mesh.attributes_.length === 0 || mesh.point_count_ === 0) return 0;
        const core = mesh.core_;
        if (deduplicate) mesh.deduplicate_();
        const stream = this.#encode(core, mesh, speed, this.#numbers(mesh, key_of));
        const bytes = stream !== undefined && mesh.metadata_ !== undefined ? with_metadata(stream, mesh.metadata_) : stream;
        if (bytes === undefined) return 0;
        out.array_ = bytes;
        return bytes.length;
      }
      // What encode_mesh reads.
      #numbers(mesh, key_of) {
        return Float32Array.from(mesh.attributes_.flatMap((attribute, id) => {
          const { bits = 0, origin, range } = this.#quantization.get(key_of(attribute, id)) ?? {};
          if (origin === undefined) return [bits, 0];
          if (!(range > 0 && range < Infinity)) throw new RangeError(`psplit: ${range} is no range of a grid`);
          return [bits, 1, range, ...Array.from({ length: attribute.components }, (_, k) => origin[k] ?? 0)];
        }));
      }
      #encode(core, mesh, speed, numbers) {
        const at = core.allocate(numbers.byteLength);
        new Float32Array(core.buffer, at, numbers.length).set(numbers);
        const method = this.#method, is_sequential = method !== -1 ? method !== MESH_EDGEBREAKER_ENCODING : speed === kMostSpeed;
        const result = (mesh instanceof Mesh ? core.call('encode_mesh', mesh.handle_, is_sequential ? 1 : 0, speed, at)
          : core.call('encode_cloud', mesh.handle_, method === 0 || method === 1 ? method : -1, speed, at)) >>> 0;
        core.exports.release(at);
        if (result === 0) {
          const { code, message } = core.last_error();
          if (code === kUnsupported) throw new Error(message);
          return undefined;
        }
        const [bytes, length, ...counts] = core.words(result, 4), stream = new Int8Array(core.buffer, bytes, length).slice();
        // draco3d's Encoder does not count the points of clouds.
        this.#counts = this.#is_tracking && (mesh instanceof Mesh || this instanceof ExpertEncoder) ? counts : [0, 0];
        core.exports.free_stream();
        return stream;
      }
    }
    class Encoder extends AnyEncoder {
      EncodeMeshToDracoBuffer(mesh, out) {
        if (!mesh.attributes_.some(({ semantic }) => semantic === POSITION)) return 0;
        return this.encode_(mesh, true, out, ({ semantic }) => semantic);
      }
      EncodePointCloudToDracoBuffer(cloud, deduplicate, out) { return this.encode_(cloud, deduplicate, out, ({ semantic }) => semantic); }
    }
    class ExpertEncoder extends AnyEncoder {
      constructor(mesh) {
        super();
        this.mesh_ = mesh;
      }
      EncodeToDracoBuffer(deduplicate, out) { return this.encode_(this.mesh_, deduplicate, out, (_, id) => id); }
    }

    const module = Object.assign(config, kConstants, members, {
      GeometryAttribute, PointAttribute, PointCloud, Mesh, PointCloudBuilder, MeshBuilder, Metadata, MetadataBuilder, Encoder, ExpertEncoder,
      DracoInt8Array: array_class(Int8Array, 'DracoInt8Array'),
    });
    memory.add_members(module);
    return module;
  }

  return starter_of('draco_encoder.wasm', make_module);
})();

if (typeof module === 'object' && typeof exports === 'object') {
  module.exports = DracoEncoderModule;
  module.exports.createEncoderModule = DracoEncoderModule;
}
