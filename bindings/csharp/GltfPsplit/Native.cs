// The declarations of psplit/psplit.h, under its names: the test compares them with the header. The header describes each of
// them.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace GltfPsplit
{
    /// <summary>A handle of the C library, which is freed when nobody has it any more, or by Dispose.</summary>
    internal abstract class Handle : SafeHandle
    {
        protected Handle() : base(IntPtr.Zero, true) { }
        public override bool IsInvalid { get { return handle == IntPtr.Zero; } }
    }
    internal sealed class PoolHandle : Handle
    {
        protected override bool ReleaseHandle() { Native.psplit_pool_free(handle); return true; }
    }
    internal sealed class StopHandle : Handle
    {
        protected override bool ReleaseHandle() { Native.psplit_stop_free(handle); return true; }
    }
    internal sealed class EncodedHandle : Handle
    {
        protected override bool ReleaseHandle() { Native.psplit_encoded_free(handle); return true; }
    }
    internal sealed class OutputHandle : Handle
    {
        protected override bool ReleaseHandle() { Native.psplit_output_free(handle); return true; }
    }
    /// <summary>Handles that read the caller's arrays, which stay pinned until the handle is freed.</summary>
    internal abstract class ReadingHandle : Handle
    {
        internal readonly PinnedBytes.Set Pins = new PinnedBytes.Set();
        protected abstract void Free(IntPtr handle);
        protected override bool ReleaseHandle()
        {
            Free(handle);
            Pins.Release();
            return true;
        }
    }
    internal sealed class MeshHandle : ReadingHandle
    {
        protected override void Free(IntPtr handle) { Native.psplit_mesh_free(handle); }
    }
    internal sealed class GltfHandle : ReadingHandle
    {
        protected override void Free(IntPtr handle) { Native.psplit_gltf_free(handle); }
    }

    internal static unsafe class Native
    {
        private const string Library = "psplit";

        // The version of the header that this file was written from.
        internal const int PSPLIT_VERSION_MAJOR = 0;
        internal const int PSPLIT_VERSION_MINOR = 1;
        internal const int PSPLIT_VERSION_PATCH = 0;

        internal const int PSPLIT_OK = 0;
        internal const int PSPLIT_ERROR_USAGE = 1;
        internal const int PSPLIT_ERROR_INVALID_INPUT = 3;
        internal const int PSPLIT_ERROR_FAILURE = 4;
        internal const int PSPLIT_ERROR_UNSUPPORTED = 5;
        internal const int PSPLIT_ERROR_CANCELLED = 6;
        internal const int PSPLIT_ERROR_NO_MEMORY = 8;
        internal const int PSPLIT_KIND_NONE = 0;
        internal const int PSPLIT_KIND_PATCHES = 1;
        internal const int PSPLIT_KIND_DRACO = 2;
        internal const int PSPLIT_KIND_DRACO_FILE = 3;
        internal const int PSPLIT_INT8 = 1;
        internal const int PSPLIT_UINT8 = 2;
        internal const int PSPLIT_INT16 = 3;
        internal const int PSPLIT_UINT16 = 4;
        internal const int PSPLIT_INT32 = 5;
        internal const int PSPLIT_UINT32 = 6;
        internal const int PSPLIT_INT64 = 7;
        internal const int PSPLIT_UINT64 = 8;
        internal const int PSPLIT_FLOAT32 = 9;
        internal const int PSPLIT_FLOAT64 = 10;
        internal const int PSPLIT_BOOL = 11;
        internal const int PSPLIT_POSITION = 0;
        internal const int PSPLIT_NORMAL = 1;
        internal const int PSPLIT_COLOR = 2;
        internal const int PSPLIT_TEXCOORD = 3;
        internal const int PSPLIT_GENERIC = 4;
        internal const int PSPLIT_CODING_UNKNOWN = -1;
        internal const int PSPLIT_CODING_SEQUENTIAL = 0;
        internal const int PSPLIT_CODING_EDGEBREAKER = 1;
        internal const int PSPLIT_CODING_EDGEBREAKER_VALENCE = 3;
        internal const int PSPLIT_CODING_CLOUD_SEQUENTIAL = 4;
        internal const int PSPLIT_CODING_CLOUD_KD_TREE = 5;
        internal const int PSPLIT_COPY = 1;
        internal const int PSPLIT_INTEGERS = 2;
        internal const int PSPLIT_ENCODE_KEEP_DUPLICATES = 1;
        internal const int PSPLIT_ENCODE_KEEP_DEGENERATE = 2;
        internal const int PSPLIT_ENCODE_KEEP_UNUSED = 4;
        internal const int PSPLIT_ENCODE_CONDENSE = 8;
        internal const int PSPLIT_ENCODE_WITHOUT_VERIFYING = 16;
        internal const int PSPLIT_ENCODE_POINTS = 32;

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_error
        {
            internal uint struct_size;
            internal int code;
            internal long mesh;
            internal long primitive;
            internal long patch;
            internal fixed byte text[480];
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_run
        {
            internal uint struct_size;
            internal int threads;
            internal IntPtr pool;
            internal IntPtr progress;
            internal IntPtr user;
            internal IntPtr stop;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_attribute_request
        {
            internal uint struct_size;
            internal uint unique_id;
            internal IntPtr name;
            internal int @type;
            internal uint components;
            internal uint normalized;
            internal uint reserved;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_source
        {
            internal uint struct_size;
            internal int kind;
            internal IntPtr data;
            internal UIntPtr size;
            internal psplit_attribute_request* attributes;
            internal uint attribute_count;
            internal uint flags;
            internal ulong point_count;
            internal ulong index_count;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_mesh_info
        {
            internal uint struct_size;
            internal int kind;
            internal int coding;
            internal uint point_count;
            internal uint face_count;
            internal uint attribute_count;
            internal uint patch_count;
            internal uint has_residue;
            internal uint least_index_size;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_attribute_info
        {
            internal uint struct_size;
            internal uint unique_id;
            internal int semantic;
            internal int @type;
            internal uint components;
            internal uint normalized;
            internal uint value_size;
            internal uint is_integers;
            internal IntPtr name;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_quantization
        {
            internal uint struct_size;
            internal int bits;
            internal float range;
            internal uint origin_count;
            internal IntPtr origin;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_patch_info
        {
            internal uint struct_size;
            internal uint face_count;
            internal uint point_count;
            internal uint stream_size;
            internal uint first_face;
            internal uint first_owned_point;
            internal uint owned_point_count;
            internal uint is_residue;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_attribute_buffer
        {
            internal uint struct_size;
            internal uint reserved;
            internal IntPtr data;
            internal UIntPtr size;
            internal UIntPtr stride;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_buffers
        {
            internal uint struct_size;
            internal uint index_size;
            internal IntPtr indices;
            internal UIntPtr indices_size;
            internal psplit_attribute_buffer* attributes;
            internal uint attribute_count;
            internal uint reserved;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_job
        {
            internal uint struct_size;
            internal int code;
            internal IntPtr mesh;
            internal psplit_buffers* buffers;
            internal psplit_error* error;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_gltf_source
        {
            internal uint struct_size;
            internal uint flags;
            internal IntPtr data;
            internal UIntPtr size;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_attribute_values
        {
            internal uint struct_size;
            internal int @type;
            internal IntPtr name;
            internal IntPtr data;
            internal UIntPtr size;
            internal UIntPtr stride;
            internal uint components;
            internal uint normalized;
            internal int bits;
            internal uint reserved;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_encode_source
        {
            internal uint struct_size;
            internal uint point_count;
            internal IntPtr indices;
            internal UIntPtr indices_size;
            internal uint index_size;
            internal uint attribute_count;
            internal psplit_attribute_values* attributes;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_encode_options
        {
            internal uint struct_size;
            internal int kind;
            internal int speed;
            internal int threads;
            internal IntPtr pool;
            internal uint patch_count;
            internal uint patch_faces;
            internal int position_bits;
            internal int normal_bits;
            internal int texcoord_bits;
            internal int color_bits;
            internal int generic_bits;
            internal uint flags;
            internal IntPtr progress;
            internal IntPtr user;
            internal IntPtr stop;
        }

        [StructLayout(LayoutKind.Sequential)]
        internal unsafe struct psplit_encoded_info
        {
            internal uint struct_size;
            internal int kind;
            internal IntPtr data;
            internal UIntPtr size;
            internal uint point_count;
            internal uint face_count;
            internal uint patch_count;
            internal uint attribute_count;
            internal IntPtr source_points;
            internal double position_error;
            internal uint note_count;
            internal uint reserved;
        }

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern uint psplit_version();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_has_encoder();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern byte* psplit_code_name(int code);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_pool_create(int threads, out PoolHandle pool, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_pool_threads(PoolHandle pool);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern void psplit_pool_free(IntPtr pool);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_stop_create(out StopHandle stop, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern void psplit_stop_set(StopHandle stop, int value);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern void psplit_stop_free(IntPtr stop);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern void psplit_release_scratch();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_mesh_open(psplit_source* source, out MeshHandle mesh, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern void psplit_mesh_free(IntPtr mesh);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_mesh_get_info(MeshHandle mesh, psplit_mesh_info* info, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_mesh_get_attribute(MeshHandle mesh, uint attribute, psplit_attribute_info* info, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_mesh_find_name(MeshHandle mesh, byte* name);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_mesh_find_id(MeshHandle mesh, uint unique_id);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_mesh_find_semantic(MeshHandle mesh, int semantic, uint skip);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_mesh_get_quantization(MeshHandle mesh, uint attribute, psplit_quantization* quantization, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_mesh_get_patch(MeshHandle mesh, uint patch, psplit_patch_info* info, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_mesh_decode(MeshHandle mesh, psplit_buffers* buffers, psplit_run* run, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_mesh_decode_patch(MeshHandle mesh, uint patch, psplit_buffers* buffers, psplit_run* run, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_decode_meshes(psplit_job* jobs, UIntPtr job_count, psplit_run* run, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_gltf_open(psplit_gltf_source* source, out GltfHandle gltf, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern void psplit_gltf_free(IntPtr gltf);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern uint psplit_gltf_buffer_count(GltfHandle gltf);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern byte* psplit_gltf_buffer_uri(GltfHandle gltf, uint buffer);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_gltf_set_buffer(GltfHandle gltf, uint buffer, void* data, UIntPtr size, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern uint psplit_gltf_mesh_count(GltfHandle gltf);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern uint psplit_gltf_primitive_count(GltfHandle gltf, uint mesh);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_gltf_primitive_kind(GltfHandle gltf, uint mesh, uint primitive);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_gltf_open_primitive(GltfHandle gltf, uint mesh, uint primitive, out MeshHandle result, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern void psplit_encode_options_init(psplit_encode_options* options);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_encode(psplit_encode_source* source, psplit_encode_options* options, out EncodedHandle encoded, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern void psplit_encoded_free(IntPtr encoded);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_encoded_get_info(EncodedHandle encoded, psplit_encoded_info* info, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern byte* psplit_encoded_note(EncodedHandle encoded, uint note);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_encoded_get_attribute(EncodedHandle encoded, uint attribute, psplit_attribute_request* request, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_encoded_get_quantization(EncodedHandle encoded, uint attribute, psplit_quantization* quantization, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern byte* psplit_encoded_reason(EncodedHandle encoded, uint attribute);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern void* psplit_output_data(OutputHandle output);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern UIntPtr psplit_output_size(OutputHandle output);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern void psplit_output_free(IntPtr output);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_encoded_write_json(EncodedHandle encoded, uint first_accessor, uint buffer_view, out OutputHandle output, psplit_error* error);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int psplit_encoded_write_glb(EncodedHandle encoded, out OutputHandle output, psplit_error* error);

        /// <summary>A text of C, which ends with a zero byte; null for a null pointer.</summary>
        internal static string Text(byte* text)
        {
            if (text == null) return null;
            int size = 0;
            while (text[size] != 0) ++size;
            return size == 0 ? "" : Encoding.UTF8.GetString(text, size);
        }
        internal static string Text(IntPtr text) { return Text((byte*)text); }

        /// <summary>A text for C, to be pinned.</summary>
        internal static byte[] Bytes(string text)
        {
            if (text == null) throw new ArgumentNullException("text");
            if (text.IndexOf('\0') >= 0) throw new ArgumentException("a name has a zero character");
            return Encoding.UTF8.GetBytes(text + "\0");
        }

        internal static psplit_error NewError()
        {
            var error = new psplit_error();
            error.struct_size = (uint)sizeof(psplit_error);
            return error;
        }

        /// <summary>Throws the error of a call that returned `code`.</summary>
        internal static void Check(int code, ref psplit_error error)
        {
            if (code == PSPLIT_OK) return;
            fixed (byte* text = error.text)
                throw new PsplitException((ErrorCode)code, Text(text), error.mesh, error.primitive, error.patch);
        }
    }
}
