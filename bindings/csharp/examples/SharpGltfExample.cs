// SharpGltfExample INPUT.glb OUTPUT.glb: SharpGLTF knows neither Draco nor patches. This decodes all compressed primitives of a
// .glb file by psplit, builds a scene of SharpGLTF from them, and saves it as a plain .glb file. It then encodes the first mesh
// of the scene again. Each primitive becomes a mesh of its own, with positions and a default material.
using System;
using System.IO;
using System.Linq;
using System.Numerics;
using GltfPsplit;
using SharpGLTF.Geometry;
using SharpGLTF.Geometry.VertexTypes;
using SharpGLTF.Materials;
using SharpGLTF.Scenes;
using SharpGLTF.Schema2;

static class SharpGltfExample
{
    // A mesh of SharpGLTF from a compressed primitive.
    static MeshBuilder<VertexPosition> ToMeshBuilder(CompressedMesh mesh, string name)
    {
        DecodedMesh decoded = mesh.Decode();
        ReadOnlySpan<Vector3> positions = decoded.GetValues<Vector3>(decoded.Find("POSITION"));
        var builder = new MeshBuilder<VertexPosition>(name);
        var primitive = builder.UsePrimitive(new MaterialBuilder("default"));
        for (int i = 0; i < decoded.Indices.Length; i += 3)
            primitive.AddTriangle(new VertexPosition(positions[(int)decoded.Indices[i]]),
                                  new VertexPosition(positions[(int)decoded.Indices[i + 1]]),
                                  new VertexPosition(positions[(int)decoded.Indices[i + 2]]));
        return builder;
    }

    // The other way: what a primitive of SharpGLTF becomes.
    static EncodedMesh Encode(MeshPrimitive primitive)
    {
        Vector3[] positions = primitive.GetVertexAccessor("POSITION").AsVector3Array().ToArray();
        uint[] indices = primitive.GetTriangleIndices().SelectMany(face => new[] { (uint)face.Item1, (uint)face.Item2, (uint)face.Item3 }).ToArray();
        return MeshEncoder.Encode(new MeshSource(indices, positions.Length).Add("POSITION", positions, 3));
    }

    static void Main(string[] arguments)
    {
        var scene = new SceneBuilder();
        using (var gltf = GltfFile.Open(File.ReadAllBytes(arguments[0])))
            for (int mesh = 0; mesh < gltf.MeshCount; ++mesh)
                for (int primitive = 0; primitive < gltf.GetPrimitiveCount(mesh); ++primitive)
                {
                    if (gltf.GetKind(mesh, primitive) == MeshKind.None) continue;
                    using (var compressed = gltf.OpenPrimitive(mesh, primitive))
                        scene.AddRigidMesh(ToMeshBuilder(compressed, "mesh " + mesh + "." + primitive), Matrix4x4.Identity);
                }
        ModelRoot model = scene.ToGltf2();
        model.SaveGLB(arguments[1]);
        EncodedMesh encoded = Encode(model.LogicalMeshes[0].Primitives[0]);
        Console.WriteLine(encoded.FaceCount + " triangles, " + encoded.Bytes.Length + " bytes as " + encoded.Kind);
    }
}
