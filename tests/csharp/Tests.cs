// Tests.exe HEADER ABI SAMPLES: what bindings/csharp promises, in any runtime of .NET. HEADER is psplit.h, ABI the list of
// tests/c, SAMPLES the folder of the extension's samples.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Runtime.CompilerServices;
using System.Runtime.InteropServices;
using System.Text.RegularExpressions;
using System.Threading;
using GltfPsplit;

static class Tests
{
    static string header, abi, samples;

    static void Check(bool condition, string what = "", [CallerLineNumber] int line = 0)
    {
        if (!condition) throw new Exception("line " + line + ": " + what);
    }
    static void Equal<T>(T got, T wanted, [CallerLineNumber] int line = 0)
    {
        Check(EqualityComparer<T>.Default.Equals(got, wanted), "got " + got + ", wanted " + wanted, line);
    }
    static E Throws<E>(Action body, [CallerLineNumber] int line = 0) where E : Exception
    {
        try
        {
            body();
        }
        catch (E exception)
        {
            return exception;
        }
        Check(false, "no " + typeof(E).Name, line);
        return null;
    }
    static byte[] Sample(string name) { return File.ReadAllBytes(Path.Combine(samples, name)); }

    static CompressedMesh OpenSample(string name)
    {
        using (var gltf = GltfFile.Open(Sample(name))) return gltf.OpenPrimitive(0, 0);
    }

    // A wavy square of side * side points.
    static MeshSource Grid(int side, out float[] positions, out float[] texcoords)
    {
        positions = new float[3 * side * side];
        texcoords = new float[2 * side * side];
        var indices = new List<uint>();
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
            {
                int point = y * side + x;
                float u = (float)x / side, v = (float)y / side;
                positions[3 * point] = u;
                positions[3 * point + 1] = v;
                positions[3 * point + 2] = (float)(0.1 * Math.Sin(9 * u) * Math.Cos(7 * v));
                texcoords[2 * point] = u;
                texcoords[2 * point + 1] = 1 - v;
                if (x + 1 == side || y + 1 == side) continue;
                foreach (int corner in new[] { 0, 1, side, 1, side + 1, side }) indices.Add((uint)(point + corner));
            }
        return new MeshSource(indices.ToArray(), side * side)
            .Add("POSITION", positions, 3)
            .Add("TEXCOORD_0", texcoords, 2, false, -1);
    }

    // ---- Declarations ----

    static readonly Type native = typeof(CompressedMesh).Assembly.GetType("GltfPsplit.Native");
    const BindingFlags kAll = BindingFlags.Static | BindingFlags.Instance | BindingFlags.NonPublic | BindingFlags.Public |
                              BindingFlags.DeclaredOnly;

    static int SizeOf(Type type) { return type.IsPointer ? IntPtr.Size : Marshal.SizeOf(type); }

    // Sizes and offsets as the list of C has them.
    static void StructsAreThoseOfC()
    {
        var wanted = File.ReadAllLines(abi).Where(line => !line.Contains("@@")).ToList();
        var got = new List<string>();
        foreach (var type in native.GetNestedTypes(kAll).Where(type => type.Name.StartsWith("psplit_")))
        {
            got.Add(type.Name + " " + Marshal.SizeOf(type));
            foreach (var field in type.GetFields(kAll))
                got.Add(type.Name + "." + field.Name + " at " + Marshal.OffsetOf(type, field.Name) + ", " + SizeOf(field.FieldType));
        }
        Equal(string.Join("\n", got.OrderBy(line => line)), string.Join("\n", wanted.OrderBy(line => line)));
    }

    static string TextOfHeader()
    {
        var lines = File.ReadAllText(header).Replace("\\\n", " ").Split('\n').Where(line => !line.TrimStart().StartsWith("#"));
        return Regex.Replace(string.Join(" ", lines.Select(line => Regex.Replace(line, "//.*", ""))), @"\s+", " ");
    }

    static void ConstantsAreThoseOfC()
    {
        var wanted = Regex.Matches(TextOfHeader(), @"(PSPLIT_\w+) = (-?\d+)").Cast<Match>()
            .ToDictionary(match => match.Groups[1].Value, match => int.Parse(match.Groups[2].Value));
        var version = File.ReadAllText(Path.Combine(Path.GetDirectoryName(header), "version.h"));
        foreach (Match match in Regex.Matches(version, @"#define (PSPLIT_VERSION_(?:MAJOR|MINOR|PATCH)) (\d+)"))
            wanted[match.Groups[1].Value] = int.Parse(match.Groups[2].Value);
        var got = native.GetFields(kAll).Where(field => field.IsLiteral && field.Name.StartsWith("PSPLIT_"))
            .ToDictionary(field => field.Name, field => (int)field.GetRawConstantValue());
        Check(wanted.Count > 20 && wanted.ContainsKey("PSPLIT_VERSION_PATCH"));
        Equal(string.Join(" ", got.OrderBy(pair => pair.Key)), string.Join(" ", wanted.OrderBy(pair => pair.Key)));
    }

    static string KindOfC(string declaration)
    {
        if (declaration.Contains("*")) return "pointer";
        string type = declaration.Trim().Split(' ')[0];
        return type == "uint32_t" ? "uint" : type == "size_t" ? "size" : type == "uint64_t" ? "ulong" : type == "void" ? "void" : "int";
    }
    static string KindOfNet(Type type)
    {
        if (type == typeof(UIntPtr)) return "size";
        if (type == typeof(uint)) return "uint";
        if (type == typeof(int)) return "int";
        if (type == typeof(ulong)) return "ulong";
        if (type == typeof(void)) return "void";
        return type.IsPointer || type.IsByRef || type == typeof(IntPtr) || typeof(SafeHandle).IsAssignableFrom(type) ? "pointer"
                                                                                                                      : type.Name;
    }

    static void FunctionsAreThoseOfC()
    {
        var wanted = Regex.Matches(TextOfHeader(), @"PSPLIT_API ([^;(]*?)(\w+)\(([^;]*)\);").Cast<Match>().Select(match => {
            var parameters = match.Groups[3].Value.Split(',').Where(part => part.Trim() != "void").Select(KindOfC);
            return KindOfC(match.Groups[1].Value) + " " + match.Groups[2].Value + "(" + string.Join(", ", parameters) + ")";
        }).ToList();
        var got = native.GetMethods(kAll).Where(method => method.Name.StartsWith("psplit_")).Select(method => {
            var parameters = method.GetParameters().Select(parameter => KindOfNet(parameter.ParameterType));
            return KindOfNet(method.ReturnType) + " " + method.Name + "(" + string.Join(", ", parameters) + ")";
        });
        Check(wanted.Count > 30);
        Equal(string.Join("\n", got.OrderBy(line => line)), string.Join("\n", wanted.OrderBy(line => line)));
    }

    // ---- Decoding ----

    static void DecodesASampleOnAnyThreads()
    {
        using (var gltf = GltfFile.Open(Sample("patches.glb")))
        using (var mesh = gltf.OpenPrimitive(0, 0))
        using (var pool = new WorkerPool(2))
        {
            Equal(gltf.MeshCount, 1);
            Equal(gltf.GetPrimitiveCount(0), 1);
            Equal(gltf.GetKind(0, 0), MeshKind.Patches);
            Equal(gltf.GetKind(0, 1), MeshKind.None);
            Equal(gltf.GetBufferUri(0), null);
            Equal(pool.Threads, 2);
            Equal(mesh.FaceCount, 1222);
            Equal(mesh.PointCount, 663);
            Equal(mesh.LeastIndexSize, 2);
            Check(mesh.PatchCount > 1);
            var decoded = mesh.Decode(new RunOptions { Threads = 1 });
            Check(decoded.Indices.Length == 3 * 1222 && decoded.Indices.All(index => index < 663));
            var positions = decoded.GetValues<float>(decoded.Find("POSITION"));
            Equal(positions.Length, 3 * 663);
            Check(Math.Abs(positions[0] + 0.636158) < 1e-6);
            Throws<ArgumentException>(() => decoded.GetValues<double>(0));
            foreach (var run in new[] { null, new RunOptions { Pool = pool } })
            {
                var again = mesh.Decode(run);
                Check(again.Indices.SequenceEqual(decoded.Indices));
                Check(again.GetBytes(0).SequenceEqual(decoded.GetBytes(0)));
            }
        }
        Psplit.ReleaseScratch();
    }

    static void DecodesAPatchAlone()
    {
        using (var mesh = OpenSample("patches.glb"))
        {
            var whole = mesh.Decode();
            int position = mesh.Find(Semantic.Position), faces = 0, owned = 0;
            for (int number = 0; number < mesh.PatchCount; ++number)
            {
                var patch = mesh.GetPatch(number);
                Equal(patch.FirstFace, faces);
                Equal(patch.FirstOwnedPoint, owned);
                faces += patch.FaceCount;
                owned += patch.OwnedPointCount;
                var indices = new uint[3 * patch.FaceCount];
                var positions = new float[3 * patch.PointCount];
                mesh.DecodePatch(number, indices, MemoryMarshal.AsBytes(new Span<float>(positions)),
                                 new[] { new AttributePlace(position, 0, 0) });
                for (int corner = 0; corner < indices.Length; ++corner)
                {
                    uint there = whole.Indices[3 * patch.FirstFace + corner];
                    for (int c = 0; c < 3; ++c)
                        Equal(positions[3 * indices[corner] + c], whole.GetValues<float>(position)[(int)(3 * there + c)]);
                }
            }
            Equal(faces, mesh.FaceCount);
            Equal(owned, mesh.PointCount);
            Equal(Throws<PsplitException>(() => mesh.GetPatch(mesh.PatchCount)).Code, ErrorCode.Usage);
        }
    }

    static void DecodesToInterleavedVertices()
    {
        const int kStride = 24; // 12 bytes of a position, 4 that nobody writes, 8 of a texture coordinate
        CompressedMesh mesh;
        using (var gltf = GltfFile.Open(new ReadOnlySpan<byte>(Sample("seams.glb")))) mesh = gltf.OpenPrimitive(0, 0);
        using (mesh)
        {
            int position = mesh.Find("POSITION"), texcoord = mesh.Find("TEXCOORD_0");
            var wanted = mesh.Decode();
            var vertices = Enumerable.Repeat((byte)0xa5, kStride * mesh.PointCount).ToArray();
            var indices = new ushort[3 * mesh.FaceCount];
            mesh.Decode(indices, vertices, new[] { new AttributePlace(position, 0, kStride), new AttributePlace(texcoord, 16, kStride) });
            Check(indices.Select(index => (uint)index).SequenceEqual(wanted.Indices));
            for (int point = 0; point < mesh.PointCount; ++point)
            {
                var vertex = new ReadOnlySpan<byte>(vertices, kStride * point, kStride);
                Check(vertex.Slice(0, 12).SequenceEqual(wanted.GetBytes(position).Slice(12 * point, 12)));
                Check(vertex[12] == 0xa5 && vertex[15] == 0xa5);
                Check(vertex.Slice(16).SequenceEqual(wanted.GetBytes(texcoord).Slice(8 * point, 8)));
            }
        }
    }

    static void RefusesMemoryThatDoesNotFit()
    {
        using (var mesh = OpenSample("patches.glb"))
        {
            var indices = new uint[3 * mesh.FaceCount];
            var memory = new byte[12 * mesh.PointCount - 1];
            var places = new[] { new AttributePlace(0, 0, 0) };
            var error = Throws<PsplitException>(() => mesh.Decode(indices, memory, places));
            Equal(error.Message, "mesh 0, primitive 0: the buffer of POSITION has no room for 663 points");
            Check(error.Code == ErrorCode.Usage && error.Mesh == 0 && error.Primitive == 0 && error.Patch == -1);
            foreach (var place in new[] { new AttributePlace(1, 0, 0), new AttributePlace(0, -1, 0), new AttributePlace(0, 1 << 20, 0) })
                Equal(Throws<PsplitException>(() => mesh.Decode(indices, memory, new[] { place })).Code, ErrorCode.Usage);
            Throws<PsplitException>(() => mesh.Decode(new uint[3], memory, new AttributePlace[0]));
        }
    }

    static void MalformedBytesAreErrors()
    {
        var bytes = Sample("condensed-residue.glb");
        for (int end = 0; end < bytes.Length; end += 3)
        {
            var cut = bytes.Take(end).ToArray();
            if (end >= 12) BitConverter.GetBytes(end).CopyTo(cut, 8); // the file's own length
            var error = Throws<PsplitException>(() => {
                using (var gltf = GltfFile.Open(cut))
                using (var mesh = gltf.OpenPrimitive(0, 0)) mesh.Decode();
            });
            Check(error.Code == ErrorCode.InvalidInput || error.Code == ErrorCode.Usage, error.Message);
        }
        Equal(Throws<PsplitException>(() => CompressedMesh.Open(MeshKind.DracoFile, new byte[0])).Code, ErrorCode.InvalidInput);
        Equal(Throws<PsplitException>(() => CompressedMesh.Open(MeshKind.DracoFile, ReadOnlySpan<byte>.Empty)).Code,
              ErrorCode.InvalidInput);
        Throws<ArgumentNullException>(() => GltfFile.Open((byte[])null));
    }

    static void BuffersOfUrisAreTheCallers()
    {
        using (var gltf = GltfFile.Open(Sample("fallback.gltf")))
        {
            var error = Throws<PsplitException>(() => gltf.OpenPrimitive(0, 0));
            Check(error.Code == ErrorCode.Usage && error.Message.EndsWith("are not set"), error.Message);
            for (int buffer = 0; buffer < gltf.BufferCount; ++buffer) gltf.SetBuffer(buffer, Sample(gltf.GetBufferUri(buffer)));
            Throws<PsplitException>(() => gltf.SetBuffer(0, new byte[1]));
            using (var mesh = gltf.OpenPrimitive(0, 0)) Check(mesh.Decode().Indices.Length > 0);
        }
    }

    // ---- Lifetimes, threads and callbacks ----

    static CompressedMesh[] Opened(int count)
    {
        return Enumerable.Range(0, count).Select(_ => OpenSample("seams.glb")).ToArray();
    }

    static void ArraysStayWhereTheyAre()
    {
        // Their files are disposed, and nothing else refers to the arrays. Collections move arrays that are not pinned.
        var meshes = Opened(50);
        var wanted = meshes[0].Decode();
        for (int i = 0; i < 5; ++i)
        {
            var garbage = Enumerable.Range(0, 100).Select(_ => new byte[5000]).ToArray();
            GC.Collect();
            GC.WaitForPendingFinalizers();
            GC.KeepAlive(garbage);
        }
        foreach (var mesh in meshes) Check(mesh.Decode().Indices.SequenceEqual(wanted.Indices));
        foreach (var mesh in meshes) mesh.Dispose();
        Throws<ObjectDisposedException>(() => meshes[0].Decode());
        meshes[0].Dispose();
    }

    static void ThreadsShareHandles()
    {
        using (var mesh = OpenSample("seams.glb"))
        using (var pool = new WorkerPool(2))
        {
            var wanted = mesh.Decode();
            Exception failure = null;
            var threads = Enumerable.Range(0, 4).Select(_ => new Thread(() => {
                try
                {
                    for (int i = 0; i < 20; ++i)
                        Check(mesh.Decode(new RunOptions { Pool = pool }).Indices.SequenceEqual(wanted.Indices));
                }
                catch (Exception exception)
                {
                    failure = exception;
                }
            })).ToList();
            foreach (var thread in threads) thread.Start();
            foreach (var thread in threads) thread.Join();
            Check(failure == null, "" + failure);
        }
    }

    static void ExceptionsOfCallbacksDoNotCrossC()
    {
        using (var mesh = OpenSample("patches.glb"))
        {
            int calls = 0;
            var error = Throws<InvalidOperationException>(() => mesh.Decode(new RunOptions { Progress = (done, total) => {
                Interlocked.Increment(ref calls);
                throw new InvalidOperationException("in a callback");
            } }));
            Equal(error.Message, "in a callback");
            Equal(calls, mesh.PatchCount);
            long last = 0;
            mesh.Decode(new RunOptions { Progress = (done, total) => { Interlocked.Increment(ref last); Check(done <= total); } });
            Equal(last, (long)mesh.PatchCount);
        }
    }

    static void ATokenEndsCalls()
    {
        using (var mesh = OpenSample("patches.glb"))
        using (var source = new CancellationTokenSource())
        {
            var run = new RunOptions { CancellationToken = source.Token };
            mesh.Decode(run);
            // Also while the call runs.
            var during = new RunOptions { CancellationToken = source.Token, Threads = 1, Progress = (done, total) => source.Cancel() };
            Throws<OperationCanceledException>(() => mesh.Decode(during));
            Throws<OperationCanceledException>(() => mesh.Decode(run));
            float[] positions, texcoords;
            if (Psplit.HasEncoder)
                Throws<OperationCanceledException>(() => MeshEncoder.Encode(Grid(20, out positions, out texcoords), null, run));
        }
    }

    // ---- Encoding ----

    static void EncodesAndDecodesAgain()
    {
        float[] positions, texcoords;
        var source = Grid(60, out positions, out texcoords);
        if (!Psplit.HasEncoder)
        {
            Equal(Throws<PsplitException>(() => MeshEncoder.Encode(source)).Code, ErrorCode.Unsupported);
            Console.WriteLine("skipped: the library has no encoder");
            return;
        }
        Equal(new EncodeOptions().PositionBits, 14);
        foreach (var kind in new[] { MeshKind.Patches, MeshKind.Draco })
        {
            var encoded = MeshEncoder.Encode(source, new EncodeOptions { Kind = kind, PatchFaces = 1000, PositionBits = 16 });
            Equal(encoded.Kind, kind);
            Equal(encoded.PatchCount > 3, kind == MeshKind.Patches);
            Equal(encoded.FaceCount, 2 * 59 * 59);
            Check(encoded.PositionError >= 0 && encoded.PositionError < 1e-4);
            using (var mesh = encoded.Open())
            {
                int position = mesh.Find("POSITION"), texcoord = mesh.Find("TEXCOORD_0");
                var quantization = mesh.GetQuantization(position);
                Check(quantization.Bits == 16 && quantization.Origin.Length == 3);
                var decoded = mesh.Decode();
                for (int point = 0; point < encoded.PointCount; ++point)
                {
                    int from = encoded.SourcePoints[point];
                    for (int c = 0; c < 2; ++c) Equal(decoded.GetValues<float>(texcoord)[2 * point + c], texcoords[2 * from + c]);
                    for (int c = 0; c < 3; ++c)
                        Check(Math.Abs(decoded.GetValues<float>(position)[3 * point + c] - positions[3 * from + c]) <=
                              quantization.Range / 65535);
                }
            }
            if (kind == MeshKind.Draco)
                using (var file = CompressedMesh.Open(MeshKind.DracoFile, encoded.Bytes, new OpenOptions { Integers = true }))
                {
                    Check(file.Coding == Coding.Edgebreaker || file.Coding == Coding.EdgebreakerValence);
                    Equal(file.Attributes[file.Find(Semantic.Position)].ComponentType, ComponentType.Int32);
                    Equal(file.Decode().Indices.Length, 3 * encoded.FaceCount);
                }
        }
    }

    static void WritesGltfAndSaysHowAttributesAreStored()
    {
        if (!Psplit.HasEncoder) return;
        float[] positions, texcoords;
        using (var encoded = MeshEncoder.Encode(Grid(30, out positions, out texcoords)))
        {
            using (var gltf = GltfFile.Open(encoded.ToGlb()))
            using (var mesh = gltf.OpenPrimitive(0, 0))
            using (var wanted = encoded.Open()) Check(mesh.Decode().Indices.SequenceEqual(wanted.Decode().Indices));
            string json = encoded.ToJson(5, 2);
            Check(json.StartsWith("{\"primitive\":{\"attributes\":{\"POSITION\":5,\"TEXCOORD_0\":6},\"indices\":7"), json);
            Check(json.Contains("\"bufferView\":2") && json.EndsWith("}"), json);
            Check(encoded.Quantizations[0].Bits == 14 && encoded.Quantizations[1].Bits == 0);
            Equal(encoded.Reasons[0], "POSITION gets 14 bits, as the options say");
            Equal(encoded.Reasons[1], "TEXCOORD_0 is kept exactly, as its bits say");
            encoded.Dispose();
            Throws<ObjectDisposedException>(() => encoded.ToGlb());
        }
    }

    static void WrongSourcesAreErrorsOfTheEncoder()
    {
        if (!Psplit.HasEncoder) return;
        var positions = new float[9];
        Equal(Throws<PsplitException>(() => MeshEncoder.Encode(new MeshSource(new uint[] { 0, 1, 3 }, 3).Add("POSITION", positions, 3))).Code,
              ErrorCode.InvalidInput);
        Equal(Throws<PsplitException>(() => MeshEncoder.Encode(new MeshSource(new ushort[] { 0, 1, 2 }, 4).Add("POSITION", positions, 3))).Code,
              ErrorCode.Usage);
        Throws<ArgumentException>(() => MeshEncoder.Encode(new MeshSource(new uint[3], 3).Add("POS\0", positions, 3)));
        Throws<ArgumentException>(() => new MeshSource(new uint[3], 3).Add("POSITION", new double[9], 3));
    }

    static int Main(string[] arguments)
    {
        header = arguments[0];
        abi = arguments[1];
        samples = arguments[2];
        int failed = 0, passed = 0;
        foreach (var test in new Action[] {
                     StructsAreThoseOfC, ConstantsAreThoseOfC, FunctionsAreThoseOfC, DecodesASampleOnAnyThreads, DecodesAPatchAlone,
                     DecodesToInterleavedVertices, RefusesMemoryThatDoesNotFit, MalformedBytesAreErrors, BuffersOfUrisAreTheCallers,
                     ArraysStayWhereTheyAre, ThreadsShareHandles, ExceptionsOfCallbacksDoNotCrossC, ATokenEndsCalls,
                     EncodesAndDecodesAgain, WritesGltfAndSaysHowAttributesAreStored, WrongSourcesAreErrorsOfTheEncoder })
            try
            {
                test();
                ++passed;
            }
            catch (Exception exception)
            {
                ++failed;
                Console.WriteLine("FAILED " + test.Method.Name + ": " + exception);
            }
        Console.WriteLine(passed + " passed, " + failed + " failed");
        return failed == 0 ? 0 : 1;
    }
}
