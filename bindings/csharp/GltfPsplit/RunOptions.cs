using System;
using System.Runtime.ExceptionServices;
using System.Runtime.InteropServices;
using System.Threading;

namespace GltfPsplit
{
    /// <summary>The library that is loaded.</summary>
    public static class Psplit
    {
        /// <summary>Its version.</summary>
        public static Version Version
        {
            get
            {
                uint version = Native.psplit_version();
                return new Version((int)(version >> 16), (int)(version >> 8 & 0xff), (int)(version & 0xff));
            }
        }

        /// <summary>Whether it can encode. Otherwise MeshEncoder.Encode throws ErrorCode.Unsupported.</summary>
        public static bool HasEncoder { get { return Native.psplit_has_encoder() != 0; } }

        /// <summary>Frees the memory that threads keep from one call to the next.</summary>
        public static void ReleaseScratch() { Native.psplit_release_scratch(); }
    }

    /// <summary>Threads that several calls use, one after the other or at once.</summary>
    public sealed class WorkerPool : IDisposable
    {
        internal readonly PoolHandle Handle;

        /// <param name="threads">With the calling thread, at most 4096; 0 means one for each processor.</param>
        public unsafe WorkerPool(int threads = 0)
        {
            var error = Native.NewError();
            Native.Check(Native.psplit_pool_create(threads, out Handle, &error), ref error);
        }

        public int Threads { get { return Native.psplit_pool_threads(Handle); } }
        public void Dispose() { Handle.Dispose(); }
    }

    /// <summary>How a call runs. null in its place: on one thread for each processor.</summary>
    public sealed class RunOptions
    {
        /// <summary>The threads of this call, if there is no pool; 0 means one for each processor.</summary>
        public int Threads;
        /// <summary>Threads of a pool. Reuse a pool for frequent calls.</summary>
        public WorkerPool Pool;
        /// <summary>Ends the call, which then throws OperationCanceledException.</summary>
        public CancellationToken CancellationToken;
        /// <summary>
        /// Called with the number of finished steps and their total, from any thread, also from several at once. Steps are patches
        /// where meshes are decoded, and faces where they are encoded. If it throws, the call throws that when it has ended.
        /// </summary>
        public Action<long, long> Progress;

        internal static readonly RunOptions Default = new RunOptions();
    }

    /// <summary>What C gets of RunOptions during a call.</summary>
    internal sealed unsafe class RunningCall : IDisposable
    {
        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        private delegate void Progress(IntPtr user, UIntPtr done, UIntPtr total);
        private static readonly Progress report = Report; // kept, so that its pointer stays valid
        private static readonly IntPtr reportPointer = Marshal.GetFunctionPointerForDelegate(report);

        private readonly RunOptions options;
        private readonly StopHandle stop;
        private CancellationTokenRegistration registration;
        private GCHandle self;
        private bool hasPool, hasStop;
        private ExceptionDispatchInfo thrown;
        [ThreadStatic]
        private static int callsOfThisThread;
        internal Native.psplit_run Run;

        internal RunningCall(RunOptions options)
        {
            this.options = options ?? RunOptions.Default;
            Run.struct_size = (uint)sizeof(Native.psplit_run);
            Run.threads = this.options.Threads;
            ++callsOfThisThread;
            try
            {
                if (this.options.Pool != null)
                {
                    this.options.Pool.Handle.DangerousAddRef(ref hasPool);
                    Run.pool = this.options.Pool.Handle.DangerousGetHandle();
                }
                if (this.options.CancellationToken.CanBeCanceled)
                {
                    var error = Native.NewError();
                    Native.Check(Native.psplit_stop_create(out stop, &error), ref error);
                    stop.DangerousAddRef(ref hasStop);
                    Run.stop = stop.DangerousGetHandle();
                    registration = this.options.CancellationToken.Register(() => Native.psplit_stop_set(stop, 1));
                }
                if (this.options.Progress != null)
                {
                    self = GCHandle.Alloc(this);
                    Run.progress = reportPointer;
                    Run.user = GCHandle.ToIntPtr(self);
                }
            }
            catch
            {
                Dispose();
                throw;
            }
        }

        // No exception may leave it: C is below.
        private static void Report(IntPtr user, UIntPtr done, UIntPtr total)
        {
            var call = (RunningCall)GCHandle.FromIntPtr(user).Target;
            try
            {
                // Mono takes a thread of the library for one that a program must wait for when it ends.
                if (callsOfThisThread == 0) Thread.CurrentThread.IsBackground = true;
                call.options.Progress((long)done, (long)total);
            }
            catch (Exception exception)
            {
                Interlocked.CompareExchange(ref call.thrown, ExceptionDispatchInfo.Capture(exception), null);
            }
        }

        /// <summary>Throws what the callback threw, or the error of the call.</summary>
        internal void Check(int code, ref Native.psplit_error error)
        {
            if (thrown != null) thrown.Throw();
            if (code == Native.PSPLIT_ERROR_CANCELLED) options.CancellationToken.ThrowIfCancellationRequested();
            Native.Check(code, ref error);
        }

        public void Dispose()
        {
            --callsOfThisThread;
            registration.Dispose(); // waits for a callback that runs
            if (hasStop) stop.DangerousRelease();
            if (stop != null) stop.Dispose();
            if (hasPool) options.Pool.Handle.DangerousRelease();
            if (self.IsAllocated) self.Free();
            hasStop = hasPool = false;
        }
    }
}
