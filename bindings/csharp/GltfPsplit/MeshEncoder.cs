using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

namespace GltfPsplit
{
    /// <summary>How a mesh is encoded. A new one has the defaults of the library.</summary>
    public sealed unsafe class EncodeOptions
    {
        /// <summary>
        /// None: patches if the mesh is split, otherwise a Draco stream. Patches: a container of patches, if only of one. Draco: a
        /// stream as any encoder of Draco writes it.
        /// </summary>
        public MeshKind Kind;
        /// <summary>0 (smallest) to 10 (fastest).</summary>
        public int Speed;
        /// <summary>Both 0: 2, 4, 8, 16 or a multiple of 16 patches of about 30,000 faces, from 20,000 faces on.</summary>
        public int PatchCount, PatchFaces;
        /// <summary>Bits of components of floats, 1 to 30; -1 keeps floats exactly.</summary>
        public int PositionBits, NormalBits, TexCoordBits, ColorBits, GenericBits;
        /// <summary>Points that are equal in everything stay apart.</summary>
        public bool KeepDuplicates;
        /// <summary>Keeps faces that repeat an index; they draw nothing.</summary>
        public bool KeepDegenerate;
        /// <summary>Keeps points that no face uses.</summary>
        public bool KeepUnused;
        /// <summary>Patches share their tables, if that saves bytes.</summary>
        public bool Condense;
        /// <summary>Decodes the result, and compares it with the source.</summary>
        public bool Verify = true;

        public EncodeOptions()
        {
            Native.psplit_encode_options defaults = ToNative();
            Kind = (MeshKind)defaults.kind;
            Speed = defaults.speed;
            PositionBits = defaults.position_bits;
            NormalBits = defaults.normal_bits;
            TexCoordBits = defaults.texcoord_bits;
            ColorBits = defaults.color_bits;
            GenericBits = defaults.generic_bits;
        }

        private static Native.psplit_encode_options ToNative()
        {
            Native.psplit_encode_options options;
            options.struct_size = (uint)sizeof(Native.psplit_encode_options);
            Native.psplit_encode_options_init(&options);
            return options;
        }

        internal Native.psplit_encode_options ToNative(ref Native.psplit_run run)
        {
            var options = ToNative();
            options.kind = (int)Kind;
            options.speed = Speed;
            options.threads = run.threads;
            options.pool = run.pool;
            options.patch_count = checked((uint)PatchCount);
            options.patch_faces = checked((uint)PatchFaces);
            options.position_bits = PositionBits;
            options.normal_bits = NormalBits;
            options.texcoord_bits = TexCoordBits;
            options.color_bits = ColorBits;
            options.generic_bits = GenericBits;
            options.flags = (uint)((KeepDuplicates ? Native.PSPLIT_ENCODE_KEEP_DUPLICATES : 0) |
                                   (KeepDegenerate ? Native.PSPLIT_ENCODE_KEEP_DEGENERATE : 0) |
                                   (KeepUnused ? Native.PSPLIT_ENCODE_KEEP_UNUSED : 0) | (Condense ? Native.PSPLIT_ENCODE_CONDENSE : 0) |
                                   (Verify ? 0 : Native.PSPLIT_ENCODE_WITHOUT_VERIFYING));
            options.progress = run.progress;
            options.user = run.user;
            options.stop = run.stop;
            return options;
        }
    }

    /// <summary>A triangle mesh to be encoded. Its arrays are read, and pinned, while it is encoded only.</summary>
    public sealed class MeshSource
    {
        internal struct Attribute
        {
            internal string Name;
            internal Array Values;
            internal ComponentType Type;
            internal int Components, Bits;
            internal bool Normalized;
        }
        internal readonly Array Indices;
        internal readonly int PointCount;
        internal readonly List<Attribute> Attributes = new List<Attribute>();

        /// <param name="indices">Three for each face.</param>
        public MeshSource(uint[] indices, int pointCount) : this((Array)indices, pointCount) { }
        public MeshSource(ushort[] indices, int pointCount) : this((Array)indices, pointCount) { }
        private MeshSource(Array indices, int pointCount)
        {
            if (indices == null) throw new ArgumentNullException("indices");
            if (pointCount < 0) throw new ArgumentOutOfRangeException("pointCount");
            Indices = indices;
            PointCount = pointCount;
        }

        /// <summary>
        /// Adds an attribute: `components` numbers for each point, sbyte to uint or float, or structs of floats, as
        /// System.Numerics.Vector3. `name` is glTF's: POSITION, NORMAL, TEXCOORD_0 ... `bits` of floats are 1 to 30; 0: the options'
        /// bits; -1: the values are kept exactly, as integers always are.
        /// </summary>
        public MeshSource Add<T>(string name, T[] values, int components, bool normalized = false, int bits = 0) where T : struct
        {
            if (values == null) throw new ArgumentNullException("values");
            Attributes.Add(new Attribute {
                Name = name, Values = values, Type = TypeOf(typeof(T), components), Components = components, Bits = bits,
                Normalized = normalized
            });
            return this;
        }

        private static ComponentType TypeOf(Type type, int components)
        {
            if (type == typeof(sbyte)) return ComponentType.Int8;
            if (type == typeof(byte)) return ComponentType.UInt8;
            if (type == typeof(short)) return ComponentType.Int16;
            if (type == typeof(ushort)) return ComponentType.UInt16;
            if (type == typeof(uint)) return ComponentType.UInt32;
            if (type == typeof(float)) return ComponentType.Float32;
            if (!type.IsPrimitive && Marshal.SizeOf(type) == 4 * components) return ComponentType.Float32;
            throw new ArgumentException(type + " is no type of glTF, and no struct of " + components + " floats");
        }
    }

    /// <summary>Encoded bytes, and what a loader must know about them.</summary>
    public sealed unsafe class EncodedMesh : IDisposable
    {
        private readonly EncodedHandle handle;

        internal EncodedMesh(EncodedHandle handle) { this.handle = handle; }
        /// <summary>A kind for CompressedMesh.Open.</summary>
        public MeshKind Kind { get; internal set; }
        /// <summary>The bytes of the extension's buffer view.</summary>
        public byte[] Bytes { get; internal set; }
        /// <summary>The number of points of the decoded mesh.</summary>
        public int PointCount { get; internal set; }
        public int FaceCount { get; internal set; }
        /// <summary>The number of patches, including a residue.</summary>
        public int PatchCount { get; internal set; }
        /// <summary>For each decoded point the point of the source that it was.</summary>
        public int[] SourcePoints { get; internal set; }
        /// <summary>The largest distance between a position and its decoded one; below 0 if it was not measured.</summary>
        public double PositionError { get; internal set; }
        /// <summary>How CompressedMesh.Open, or glTF's JSON, requests the attributes, in the order of the source.</summary>
        public AttributeRequest[] Attributes { get; internal set; }
        /// <summary>How each attribute is stored.</summary>
        public Quantization[] Quantizations { get; internal set; }
        /// <summary>Why: "POSITION gets 14 bits, as the options say".</summary>
        public string[] Reasons { get; internal set; }
        /// <summary>Sentences about the precision of the mesh.</summary>
        public string[] Notes { get; internal set; }

        /// <summary>
        /// What glTF's JSON says about the mesh: an object with `primitive`, `accessors`, which get the numbers from
        /// firstAccessor on, and `extensions`, the names that are used and required. The bytes are in the buffer view of the
        /// number bufferView.
        /// </summary>
        public string ToJson(int firstAccessor, int bufferView)
        {
            var error = Native.NewError();
            OutputHandle output;
            int code = Native.psplit_encoded_write_json(handle, checked((uint)firstAccessor), checked((uint)bufferView), out output, &error);
            using (output)
            {
                Native.Check(code, ref error);
                return Native.Text((byte*)Native.psplit_output_data(output));
            }
        }

        /// <summary>A whole .glb file with the mesh in a scene, without a material.</summary>
        public byte[] ToGlb()
        {
            var error = Native.NewError();
            OutputHandle output;
            int code = Native.psplit_encoded_write_glb(handle, out output, &error);
            using (output)
            {
                Native.Check(code, ref error);
                var bytes = new byte[checked((int)Native.psplit_output_size(output))];
                Marshal.Copy((IntPtr)Native.psplit_output_data(output), bytes, 0, bytes.Length);
                return bytes;
            }
        }

        /// <summary>Frees what ToJson and ToGlb need. All else stays.</summary>
        public void Dispose() { handle.Dispose(); }

        /// <summary>Opens the bytes.</summary>
        public CompressedMesh Open()
        {
            return CompressedMesh.Open(Kind, Bytes, new OpenOptions { Attributes = Attributes, PointCount = (ulong)PointCount });
        }
    }

    public static unsafe class MeshEncoder
    {
        /// <summary>
        /// Encodes a triangle mesh, to the bytes of `gltf-psplit encode` with any number of threads. Faces and points get another
        /// order: see EncodedMesh.SourcePoints.
        /// </summary>
        public static EncodedMesh Encode(MeshSource source, EncodeOptions options = null, RunOptions run = null)
        {
            if (source == null) throw new ArgumentNullException("source");
            int count = source.Attributes.Count;
            var values = new Native.psplit_attribute_values[count + 1]; // fixed needs an element
            var pins = new List<GCHandle>();
            Func<Array, IntPtr> pin = array => {
                var pinned = GCHandle.Alloc(array, GCHandleType.Pinned);
                pins.Add(pinned);
                return pinned.AddrOfPinnedObject();
            };
            try
            {
                for (int i = 0; i < count; ++i)
                {
                    var attribute = source.Attributes[i];
                    values[i].struct_size = (uint)sizeof(Native.psplit_attribute_values);
                    values[i].type = (int)attribute.Type;
                    values[i].name = pin(Native.Bytes(attribute.Name));
                    values[i].data = pin(attribute.Values);
                    values[i].size = (UIntPtr)SizeOf(attribute.Values);
                    values[i].components = (uint)attribute.Components;
                    values[i].normalized = attribute.Normalized ? 1u : 0u;
                    values[i].bits = attribute.Bits;
                }
                fixed (Native.psplit_attribute_values* first = values)
                using (var call = new RunningCall(run))
                {
                    Native.psplit_encode_source stated;
                    stated.struct_size = (uint)sizeof(Native.psplit_encode_source);
                    stated.point_count = (uint)source.PointCount;
                    stated.indices = pin(source.Indices);
                    stated.indices_size = (UIntPtr)SizeOf(source.Indices);
                    stated.index_size = (uint)Marshal.SizeOf(source.Indices.GetType().GetElementType());
                    stated.attribute_count = (uint)count;
                    stated.attributes = first;
                    var wanted = (options ?? new EncodeOptions()).ToNative(ref call.Run);
                    var error = Native.NewError();
                    EncodedHandle handle;
                    int code = Native.psplit_encode(&stated, &wanted, out handle, &error);
                    try
                    {
                        call.Check(code, ref error);
                        return Read(handle);
                    }
                    catch
                    {
                        handle.Dispose();
                        throw;
                    }
                }
            }
            finally
            {
                foreach (var pinned in pins) pinned.Free();
            }
        }

        private static ulong SizeOf(Array array)
        {
            return (ulong)array.LongLength * (ulong)Marshal.SizeOf(array.GetType().GetElementType());
        }

        private static EncodedMesh Read(EncodedHandle handle)
        {
            var error = Native.NewError();
            Native.psplit_encoded_info info;
            info.struct_size = (uint)sizeof(Native.psplit_encoded_info);
            Native.Check(Native.psplit_encoded_get_info(handle, &info, &error), ref error);
            var encoded = new EncodedMesh(handle) {
                Kind = (MeshKind)info.kind,
                Bytes = new byte[checked((int)info.size)],
                PointCount = checked((int)info.point_count),
                FaceCount = checked((int)info.face_count),
                PatchCount = (int)info.patch_count,
                SourcePoints = new int[info.point_count],
                PositionError = info.position_error,
                Attributes = new AttributeRequest[info.attribute_count],
                Quantizations = new Quantization[info.attribute_count],
                Reasons = new string[info.attribute_count],
                Notes = new string[info.note_count]
            };
            Marshal.Copy(info.data, encoded.Bytes, 0, encoded.Bytes.Length);
            Marshal.Copy(info.source_points, encoded.SourcePoints, 0, encoded.SourcePoints.Length);
            for (uint i = 0; i < info.attribute_count; ++i)
            {
                Native.psplit_attribute_request request;
                request.struct_size = (uint)sizeof(Native.psplit_attribute_request);
                Native.Check(Native.psplit_encoded_get_attribute(handle, i, &request, &error), ref error);
                encoded.Attributes[i] = new AttributeRequest {
                    Name = Native.Text(request.name),
                    UniqueId = request.unique_id,
                    ComponentType = (ComponentType)request.type,
                    Components = (int)request.components,
                    Normalized = request.normalized != 0
                };
                Native.psplit_quantization found;
                found.struct_size = (uint)sizeof(Native.psplit_quantization);
                Native.Check(Native.psplit_encoded_get_quantization(handle, i, &found, &error), ref error);
                encoded.Quantizations[i] = Quantization.Of(found);
                encoded.Reasons[i] = Native.Text(Native.psplit_encoded_reason(handle, i));
            }
            for (uint i = 0; i < info.note_count; ++i) encoded.Notes[i] = Native.Text(Native.psplit_encoded_note(handle, i));
            return encoded;
        }
    }
}
