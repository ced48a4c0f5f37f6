using System;

namespace GltfPsplit
{
    /// <summary>What kind of error it is.</summary>
    public enum ErrorCode
    {
        /// <summary>The arguments are wrong, or buffers do not fit.</summary>
        Usage = Native.PSPLIT_ERROR_USAGE,
        /// <summary>The bytes, or what was said about them, are malformed.</summary>
        InvalidInput = Native.PSPLIT_ERROR_INVALID_INPUT,
        /// <summary>What should not fail failed.</summary>
        Failure = Native.PSPLIT_ERROR_FAILURE,
        /// <summary>The input is valid, but uses what psplit does not support.</summary>
        Unsupported = Native.PSPLIT_ERROR_UNSUPPORTED,
        /// <summary>The call was cancelled. Calls with a CancellationToken throw OperationCanceledException instead.</summary>
        Cancelled = Native.PSPLIT_ERROR_CANCELLED,
        /// <summary>Memory ran out; the same call may succeed later.</summary>
        NoMemory = Native.PSPLIT_ERROR_NO_MEMORY
    }

    /// <summary>Why a call failed. The message begins with the place: "mesh 0, primitive 1, patch 7: ...".</summary>
    public sealed class PsplitException : Exception
    {
        internal PsplitException(ErrorCode code, string message, long mesh = -1, long primitive = -1, long patch = -1) : base(message)
        {
            Code = code;
            Mesh = mesh;
            Primitive = primitive;
            Patch = patch;
        }

        public ErrorCode Code { get; private set; }
        /// <summary>The place; -1: it is not known, or does not apply.</summary>
        public long Mesh { get; private set; }
        public long Primitive { get; private set; }
        public long Patch { get; private set; }
    }
}
