using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

namespace GltfPsplit
{
    /// <summary>What a primitive's bytes are.</summary>
    public enum MeshKind
    {
        /// <summary>A primitive of glTF that is not compressed. As an option of the encoder, it lets the size of the mesh choose.</summary>
        None = Native.PSPLIT_KIND_NONE,
        /// <summary>A container of PSPLIT_mesh_draco_patches.</summary>
        Patches = Native.PSPLIT_KIND_PATCHES,
        /// <summary>A stream of KHR_draco_mesh_compression, whose attributes the caller knows.</summary>
        Draco = Native.PSPLIT_KIND_DRACO,
        /// <summary>A whole Draco stream, mesh or point cloud: a .drc file.</summary>
        DracoFile = Native.PSPLIT_KIND_DRACO_FILE
    }

    /// <summary>The type of a component.</summary>
    public enum ComponentType
    {
        Int8 = Native.PSPLIT_INT8,
        UInt8 = Native.PSPLIT_UINT8,
        Int16 = Native.PSPLIT_INT16,
        UInt16 = Native.PSPLIT_UINT16,
        Int32 = Native.PSPLIT_INT32,
        UInt32 = Native.PSPLIT_UINT32,
        Int64 = Native.PSPLIT_INT64,
        UInt64 = Native.PSPLIT_UINT64,
        Float32 = Native.PSPLIT_FLOAT32,
        Float64 = Native.PSPLIT_FLOAT64,
        Bool = Native.PSPLIT_BOOL
    }

    /// <summary>What an attribute is.</summary>
    public enum Semantic
    {
        Position = Native.PSPLIT_POSITION,
        Normal = Native.PSPLIT_NORMAL,
        Color = Native.PSPLIT_COLOR,
        TexCoord = Native.PSPLIT_TEXCOORD,
        Generic = Native.PSPLIT_GENERIC
    }

    /// <summary>How a .drc file stores its mesh or point cloud.</summary>
    public enum Coding
    {
        Unknown = Native.PSPLIT_CODING_UNKNOWN,
        Sequential = Native.PSPLIT_CODING_SEQUENTIAL,
        Edgebreaker = Native.PSPLIT_CODING_EDGEBREAKER,
        EdgebreakerValence = Native.PSPLIT_CODING_EDGEBREAKER_VALENCE,
        CloudSequential = Native.PSPLIT_CODING_CLOUD_SEQUENTIAL,
        CloudKdTree = Native.PSPLIT_CODING_CLOUD_KD_TREE
    }

    /// <summary>An attribute as glTF's JSON describes it.</summary>
    public sealed class AttributeRequest
    {
        /// <summary>glTF's name, such as "POSITION"; of a morph target "targets/0/POSITION".</summary>
        public string Name;
        /// <summary>The extension's number for the attribute.</summary>
        public uint UniqueId;
        /// <summary>The accessor's componentType: one of glTF's six.</summary>
        public ComponentType ComponentType;
        /// <summary>The components of a value, 1 to 16.</summary>
        public int Components;
        public bool Normalized;
    }

    /// <summary>Facts about the bytes that they do not contain.</summary>
    public sealed class OpenOptions
    {
        /// <summary>The wanted attributes of the extension, in any order. None for MeshKind.DracoFile.</summary>
        public IList<AttributeRequest> Attributes;
        /// <summary>The accessors' counts, which are compared with the bytes; 0: not known.</summary>
        public ulong PointCount, IndexCount;
        /// <summary>Of .drc files: values are the integers of the stream, where it has such.</summary>
        public bool Integers;
    }

    /// <summary>An attribute of a mesh.</summary>
    public sealed class AttributeInfo
    {
        /// <summary>glTF's name. Of .drc files one that glTF would allow, or "" for all attributes if glTF cannot hold them.</summary>
        public string Name { get; internal set; }
        public uint UniqueId { get; internal set; }
        public Semantic Semantic { get; internal set; }
        public ComponentType ComponentType { get; internal set; }
        public int Components { get; internal set; }
        public bool Normalized { get; internal set; }
        /// <summary>Bytes of a value, tightly packed.</summary>
        public int ValueSize { get; internal set; }
        public bool IsIntegers { get; internal set; }
    }

    /// <summary>
    /// How the values of an attribute are stored. With 0 bits, values are exact. With bits and an origin, they are places i on
    /// a grid: value = origin + i * range / (2^bits - 1). Without an origin, they are unit vectors on an octahedron.
    /// </summary>
    public sealed class Quantization
    {
        public int Bits { get; internal set; }
        public float Range { get; internal set; }
        public float[] Origin { get; internal set; }

        // While its origin is there.
        internal static Quantization Of(Native.psplit_quantization found)
        {
            var origin = new float[found.origin_count];
            if (origin.Length > 0) Marshal.Copy(found.origin, origin, 0, origin.Length);
            return new Quantization { Bits = found.bits, Range = found.range, Origin = origin };
        }
    }

    /// <summary>A part of a mesh that is decoded alone.</summary>
    public sealed class PatchInfo
    {
        public int FaceCount { get; internal set; }
        /// <summary>The points of the patch when it decodes alone, including points that other patches own.</summary>
        public int PointCount { get; internal set; }
        public int StreamSize { get; internal set; }
        /// <summary>Its faces, and the points that it owns, are consecutive in the whole.</summary>
        public int FirstFace { get; internal set; }
        public int FirstOwnedPoint { get; internal set; }
        public int OwnedPointCount { get; internal set; }
        public bool IsResidue { get; internal set; }
    }

    /// <summary>Where the values of an attribute go, in the memory that is given for all of them.</summary>
    public struct AttributePlace
    {
        /// <param name="attribute">Its number in the mesh.</param>
        /// <param name="offset">Of the first value, in bytes.</param>
        /// <param name="stride">Bytes from one value to the next; 0: tightly packed. Bytes between values are not touched.</param>
        public AttributePlace(int attribute, int offset, int stride)
        {
            Attribute = attribute;
            Offset = offset;
            Stride = stride;
        }
        public readonly int Attribute, Offset, Stride;
    }

    /// <summary>A compressed mesh, opened and checked. Methods may be called by several threads at once, but for Dispose.</summary>
    public sealed unsafe class CompressedMesh : IDisposable
    {
        private readonly MeshHandle handle;
        private readonly AttributeInfo[] attributes;
        internal readonly Native.psplit_mesh_info Info;

        internal CompressedMesh(MeshHandle handle)
        {
            this.handle = handle;
            try
            {
                var error = Native.NewError();
                Native.psplit_mesh_info info;
                info.struct_size = (uint)sizeof(Native.psplit_mesh_info);
                Native.Check(Native.psplit_mesh_get_info(handle, &info, &error), ref error);
                Info = info;
                attributes = new AttributeInfo[Info.attribute_count];
                for (int i = 0; i < attributes.Length; ++i) attributes[i] = ReadAttribute((uint)i);
            }
            catch
            {
                handle.Dispose();
                throw;
            }
        }

        /// <summary>
        /// Opens the bytes of an extension's buffer view, or a .drc file. The array stays pinned until the mesh is disposed or
        /// collected, and must not change until then.
        /// </summary>
        public static CompressedMesh Open(MeshKind kind, byte[] bytes, OpenOptions options = null)
        {
            if (bytes == null) throw new ArgumentNullException("bytes");
            var pinned = new PinnedBytes(bytes);
            return Open(kind, pinned.Address, bytes.Length, options, 0, pinned);
        }

        /// <summary>Opens a copy of the bytes.</summary>
        public static CompressedMesh Open(MeshKind kind, ReadOnlySpan<byte> bytes, OpenOptions options = null)
        {
            fixed (byte* data = &MemoryMarshal.GetReference(bytes))
                return Open(kind, (IntPtr)data, bytes.Length, options, Native.PSPLIT_COPY, null);
        }

        private static CompressedMesh Open(MeshKind kind, IntPtr data, int size, OpenOptions options, int flags, PinnedBytes pinned)
        {
            var given = options ?? new OpenOptions();
            var wanted = given.Attributes ?? new AttributeRequest[0];
            var pins = new PinnedBytes.Set();
            MeshHandle handle = null;
            try
            {
                var requests = new Native.psplit_attribute_request[wanted.Count + 1]; // fixed needs an element
                for (int i = 0; i < wanted.Count; ++i)
                {
                    var name = new PinnedBytes(Native.Bytes(wanted[i].Name));
                    pins.Take(name);
                    requests[i].struct_size = (uint)sizeof(Native.psplit_attribute_request);
                    requests[i].unique_id = wanted[i].UniqueId;
                    requests[i].name = name.Address;
                    requests[i].type = (int)wanted[i].ComponentType;
                    requests[i].components = (uint)wanted[i].Components;
                    requests[i].normalized = wanted[i].Normalized ? 1u : 0u;
                }
                fixed (Native.psplit_attribute_request* first = requests)
                {
                    Native.psplit_source source;
                    source.struct_size = (uint)sizeof(Native.psplit_source);
                    source.kind = (int)kind;
                    source.data = data;
                    source.size = (UIntPtr)size;
                    source.attributes = first;
                    source.attribute_count = (uint)wanted.Count;
                    source.flags = (uint)(flags | (given.Integers ? Native.PSPLIT_INTEGERS : 0));
                    source.point_count = given.PointCount;
                    source.index_count = given.IndexCount;
                    var error = Native.NewError();
                    Native.Check(Native.psplit_mesh_open(&source, out handle, &error), ref error);
                }
                if (pinned != null) handle.Pins.Take(pinned);
                pinned = null;
            }
            finally
            {
                pins.Release();
                if (pinned != null)
                {
                    pins.Take(pinned);
                    pins.Release();
                }
            }
            return new CompressedMesh(handle);
        }

        /// <summary>A point is a vertex of glTF: a tuple of attribute values.</summary>
        public int PointCount { get { return checked((int)Info.point_count); } }
        /// <summary>0: a point cloud.</summary>
        public int FaceCount { get { return checked((int)Info.face_count); } }
        /// <summary>The number of patches, including the residue; 1 for a Draco stream.</summary>
        public int PatchCount { get { return (int)Info.patch_count; } }
        /// <summary>Whether the last patch has the faces and points that no other stream can carry.</summary>
        public bool HasResidue { get { return Info.has_residue != 0; } }
        /// <summary>Bytes of an index: 2 if all point numbers fit, otherwise 4.</summary>
        public int LeastIndexSize { get { return (int)Info.least_index_size; } }
        public MeshKind Kind { get { return (MeshKind)Info.kind; } }
        public Coding Coding { get { return (Coding)Info.coding; } }
        public IReadOnlyList<AttributeInfo> Attributes { get { return attributes; } }

        /// <summary>The number of the attribute of that name, or -1.</summary>
        public int Find(string name)
        {
            return Array.FindIndex(attributes, attribute => attribute.Name == name);
        }
        /// <summary>The number of the attribute after `skip` others of that semantic, or -1.</summary>
        public int Find(Semantic semantic, int skip = 0)
        {
            return Array.FindIndex(attributes, attribute => attribute.Semantic == semantic && skip-- == 0);
        }

        private AttributeInfo ReadAttribute(uint number)
        {
            var error = Native.NewError();
            Native.psplit_attribute_info info;
            info.struct_size = (uint)sizeof(Native.psplit_attribute_info);
            Native.Check(Native.psplit_mesh_get_attribute(handle, number, &info, &error), ref error);
            return new AttributeInfo {
                Name = Native.Text(info.name),
                UniqueId = info.unique_id,
                Semantic = (Semantic)info.semantic,
                ComponentType = (ComponentType)info.type,
                Components = (int)info.components,
                Normalized = info.normalized != 0,
                ValueSize = (int)info.value_size,
                IsIntegers = info.is_integers != 0
            };
        }

        /// <summary>How the values of an attribute are stored. The first call may decode a stream for that.</summary>
        public Quantization GetQuantization(int attribute)
        {
            var error = Native.NewError();
            Native.psplit_quantization found;
            found.struct_size = (uint)sizeof(Native.psplit_quantization);
            Native.Check(Native.psplit_mesh_get_quantization(handle, (uint)attribute, &found, &error), ref error);
            var quantization = Quantization.Of(found);
            GC.KeepAlive(this); // the origin is the mesh's
            return quantization;
        }

        public PatchInfo GetPatch(int patch)
        {
            var error = Native.NewError();
            Native.psplit_patch_info info;
            info.struct_size = (uint)sizeof(Native.psplit_patch_info);
            Native.Check(Native.psplit_mesh_get_patch(handle, (uint)patch, &info, &error), ref error);
            return new PatchInfo {
                FaceCount = (int)info.face_count,
                PointCount = (int)info.point_count,
                StreamSize = (int)info.stream_size,
                FirstFace = (int)info.first_face,
                FirstOwnedPoint = (int)info.first_owned_point,
                OwnedPointCount = (int)info.owned_point_count,
                IsResidue = info.is_residue != 0
            };
        }

        /// <summary>Decodes the whole mesh into arrays of its own.</summary>
        public DecodedMesh Decode(RunOptions run = null)
        {
            var decoded = new DecodedMesh(this);
            var places = new AttributePlace[attributes.Length];
            int bytes = 0;
            for (int i = 0; i < places.Length; ++i)
            {
                places[i] = new AttributePlace(i, bytes, 0);
                bytes = checked(bytes + (attributes[i].ValueSize * PointCount + 7) / 8 * 8); // aligned to the largest component
            }
            decoded.Bytes = new byte[bytes];
            decoded.Offsets = Array.ConvertAll(places, place => place.Offset);
            var indices = new uint[checked(3 * FaceCount)];
            Decode(new Span<uint>(indices), new Span<byte>(decoded.Bytes), places, run);
            decoded.Indices = indices;
            return decoded;
        }

        /// <summary>
        /// Decodes the whole mesh into the caller's memory: three indices for each face, and attributes in `vertices`, interleaved or
        /// one after the other. Attributes without a place are not decoded. After an error the memory may hold anything.
        /// </summary>
        public void Decode(Span<uint> indices, Span<byte> vertices, IReadOnlyList<AttributePlace> places, RunOptions run = null)
        {
            fixed (uint* first = &MemoryMarshal.GetReference(indices))
                Decode(-1, first, 4, indices.Length, vertices, places, run);
        }
        /// <summary>Decodes as above, for at most 65,535 points.</summary>
        public void Decode(Span<ushort> indices, Span<byte> vertices, IReadOnlyList<AttributePlace> places, RunOptions run = null)
        {
            fixed (ushort* first = &MemoryMarshal.GetReference(indices))
                Decode(-1, first, 2, indices.Length, vertices, places, run);
        }
        /// <summary>
        /// Decodes one patch, which has the sizes of its PatchInfo. Indices count from its first point. No other patch's stream is
        /// read.
        /// </summary>
        public void DecodePatch(int patch, Span<uint> indices, Span<byte> vertices, IReadOnlyList<AttributePlace> places,
                                RunOptions run = null)
        {
            if (patch < 0) throw new ArgumentOutOfRangeException("patch");
            fixed (uint* first = &MemoryMarshal.GetReference(indices))
                Decode(patch, first, 4, indices.Length, vertices, places, run);
        }

        private void Decode(int patch, void* indices, int indexSize, int indexCount, Span<byte> vertices,
                            IReadOnlyList<AttributePlace> places, RunOptions run)
        {
            fixed (byte* memory = &MemoryMarshal.GetReference(vertices))
            {
                var elements = new Native.psplit_attribute_buffer[attributes.Length + 1]; // fixed needs an element
                for (int i = 0; i < attributes.Length; ++i)
                    elements[i].struct_size = (uint)sizeof(Native.psplit_attribute_buffer);
                CheckPlaces(places, vertices.Length);
                foreach (var place in places)
                {
                    elements[place.Attribute].data = (IntPtr)(memory + place.Offset);
                    elements[place.Attribute].size = (UIntPtr)(vertices.Length - place.Offset);
                    elements[place.Attribute].stride = (UIntPtr)place.Stride;
                }
                fixed (Native.psplit_attribute_buffer* first = elements)
                using (var call = new RunningCall(run))
                {
                    Native.psplit_buffers buffers;
                    buffers.struct_size = (uint)sizeof(Native.psplit_buffers);
                    buffers.index_size = (uint)indexSize;
                    buffers.indices = (IntPtr)indices;
                    buffers.indices_size = (UIntPtr)((ulong)indexCount * (ulong)indexSize);
                    buffers.attributes = first;
                    buffers.attribute_count = (uint)attributes.Length;
                    buffers.reserved = 0;
                    var error = Native.NewError();
                    Native.psplit_run stated = call.Run;
                    int code = patch < 0 ? Native.psplit_mesh_decode(handle, &buffers, &stated, &error)
                                         : Native.psplit_mesh_decode_patch(handle, (uint)patch, &buffers, &stated, &error);
                    call.Check(code, ref error);
                }
            }
        }

        private void CheckPlaces(IReadOnlyList<AttributePlace> places, int size)
        {
            if (places == null) throw new ArgumentNullException("places");
            foreach (var place in places)
            {
                if (place.Attribute < 0 || place.Attribute >= attributes.Length)
                    throw new PsplitException(ErrorCode.Usage, "there is no attribute " + place.Attribute);
                if (place.Offset < 0 || place.Offset > size || place.Stride < 0)
                    throw new PsplitException(ErrorCode.Usage, attributes[place.Attribute].Name + " is not in the memory");
            }
        }

        public void Dispose() { handle.Dispose(); }
    }

    /// <summary>A decoded mesh or point cloud.</summary>
    public sealed class DecodedMesh
    {
        internal byte[] Bytes;
        internal int[] Offsets;

        internal DecodedMesh(CompressedMesh mesh)
        {
            PointCount = mesh.PointCount;
            Attributes = mesh.Attributes;
        }

        public int PointCount { get; private set; }
        /// <summary>Three for each face; empty for a point cloud.</summary>
        public uint[] Indices { get; internal set; }
        public IReadOnlyList<AttributeInfo> Attributes { get; private set; }

        /// <summary>The values of an attribute, tightly packed.</summary>
        public ReadOnlySpan<byte> GetBytes(int attribute)
        {
            return new ReadOnlySpan<byte>(Bytes, Offsets[attribute], Attributes[attribute].ValueSize * PointCount);
        }

        /// <summary>
        /// The values of an attribute: its components, as float or ushort, or structs of the size of a value, as
        /// System.Numerics.Vector3. Throws ArgumentException if T has another size.
        /// </summary>
        public ReadOnlySpan<T> GetValues<T>(int attribute) where T : struct
        {
            var info = Attributes[attribute];
            int size = Marshal.SizeOf(typeof(T));
            if (size != info.ValueSize && size != info.ValueSize / info.Components)
                throw new ArgumentException(info.Name + " has values of " + info.ValueSize + " bytes, and " + typeof(T) + " has " + size);
            return MemoryMarshal.Cast<byte, T>(GetBytes(attribute));
        }

        /// <summary>The number of the attribute of that name, or -1.</summary>
        public int Find(string name)
        {
            for (int i = 0; i < Attributes.Count; ++i)
                if (Attributes[i].Name == name) return i;
            return -1;
        }
    }
}
