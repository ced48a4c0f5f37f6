using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

namespace GltfPsplit
{
    /// <summary>The JSON of a glTF file, and its bytes. Methods may be called by several threads at once, but for SetBuffer and
    /// Dispose.</summary>
    public sealed unsafe class GltfFile : IDisposable
    {
        private readonly GltfHandle handle;

        private GltfFile(GltfHandle handle) { this.handle = handle; }

        /// <summary>
        /// Opens a .glb file, or the JSON of a .gltf file. The array stays pinned until this and the meshes that it opened are
        /// disposed or collected, and must not change until then.
        /// </summary>
        public static GltfFile Open(byte[] bytes)
        {
            if (bytes == null) throw new ArgumentNullException("bytes");
            var pinned = new PinnedBytes(bytes);
            return Open(pinned.Address, bytes.Length, 0, pinned);
        }

        /// <summary>Opens a copy of the bytes.</summary>
        public static GltfFile Open(ReadOnlySpan<byte> bytes)
        {
            fixed (byte* data = &MemoryMarshal.GetReference(bytes))
                return Open((IntPtr)data, bytes.Length, Native.PSPLIT_COPY, null);
        }

        private static GltfFile Open(IntPtr data, int size, int flags, PinnedBytes pinned)
        {
            Native.psplit_gltf_source source;
            source.struct_size = (uint)sizeof(Native.psplit_gltf_source);
            source.flags = (uint)flags;
            source.data = data;
            source.size = (UIntPtr)size;
            var error = Native.NewError();
            GltfHandle handle;
            int code = Native.psplit_gltf_open(&source, out handle, &error);
            var pins = code == Native.PSPLIT_OK ? handle.Pins : new PinnedBytes.Set();
            if (pinned != null) pins.Take(pinned);
            if (code != Native.PSPLIT_OK) pins.Release();
            Native.Check(code, ref error);
            return new GltfFile(handle);
        }

        public int BufferCount { get { return (int)Native.psplit_gltf_buffer_count(handle); } }

        /// <summary>The URI of a buffer, which the caller reads for SetBuffer. null if it has none, as the buffer in a .glb file.</summary>
        public string GetBufferUri(int buffer)
        {
            string uri = Native.Text(Native.psplit_gltf_buffer_uri(handle, (uint)buffer));
            GC.KeepAlive(this); // the text is the file's
            return uri;
        }

        /// <summary>
        /// Sets the bytes of a buffer, for the primitives that are opened afterwards. The array stays pinned as that of Open.
        /// </summary>
        public void SetBuffer(int buffer, byte[] bytes)
        {
            if (bytes == null) throw new ArgumentNullException("bytes");
            var pinned = new PinnedBytes(bytes);
            handle.Pins.Take(pinned); // also after an error, until the file is freed
            var error = Native.NewError();
            Native.Check(
                Native.psplit_gltf_set_buffer(handle, (uint)buffer, (void*)pinned.Address, (UIntPtr)bytes.Length, &error), ref error);
        }

        public int MeshCount { get { return (int)Native.psplit_gltf_mesh_count(handle); } }
        /// <summary>0 if there is no such mesh.</summary>
        public int GetPrimitiveCount(int mesh) { return (int)Native.psplit_gltf_primitive_count(handle, (uint)mesh); }
        /// <summary>MeshKind.None if it is not compressed, or does not exist.</summary>
        public MeshKind GetKind(int mesh, int primitive)
        {
            return (MeshKind)Native.psplit_gltf_primitive_kind(handle, (uint)mesh, (uint)primitive);
        }

        /// <summary>
        /// Opens a primitive with all attributes that its extension stores, under their names in glTF. The mesh stays usable when
        /// this is disposed.
        /// </summary>
        public CompressedMesh OpenPrimitive(int mesh, int primitive)
        {
            var error = Native.NewError();
            MeshHandle opened;
            Native.Check(Native.psplit_gltf_open_primitive(handle, (uint)mesh, (uint)primitive, out opened, &error), ref error);
            opened.Pins.Share(handle.Pins);
            GC.KeepAlive(this);
            return new CompressedMesh(opened);
        }

        public void Dispose() { handle.Dispose(); }
    }
}
