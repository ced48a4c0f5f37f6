using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using System.Threading;

namespace GltfPsplit
{
    /// <summary>An array that the C library reads, until the last handle that was made of it is freed.</summary>
    internal sealed class PinnedBytes
    {
        private GCHandle pin;
        private int users = 1;

        internal PinnedBytes(byte[] bytes) { pin = GCHandle.Alloc(bytes, GCHandleType.Pinned); }
        internal IntPtr Address { get { return pin.AddrOfPinnedObject(); } }

        private void Add() { Interlocked.Increment(ref users); }
        private void Release()
        {
            if (Interlocked.Decrement(ref users) == 0) pin.Free();
        }

        /// <summary>The arrays that a handle reads.</summary>
        internal sealed class Set
        {
            private readonly List<PinnedBytes> pins = new List<PinnedBytes>();

            /// <summary>Takes the first use of an array.</summary>
            internal void Take(PinnedBytes bytes)
            {
                lock (pins) pins.Add(bytes);
            }
            /// <summary>Uses what another handle uses.</summary>
            internal void Share(Set other)
            {
                lock (other.pins)
                    foreach (var bytes in other.pins)
                    {
                        bytes.Add();
                        pins.Add(bytes);
                    }
            }
            internal void Release()
            {
                lock (pins)
                {
                    foreach (var bytes in pins) bytes.Release();
                    pins.Clear();
                }
            }
        }
    }
}
