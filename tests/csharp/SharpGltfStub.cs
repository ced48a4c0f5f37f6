// The part of SharpGLTF that bindings/csharp/examples uses, declared without bodies, so that the example compiles without it.
using System;
using System.Collections.Generic;
using System.Numerics;

namespace SharpGLTF.Materials
{
    public class MaterialBuilder
    {
        public MaterialBuilder(string name) { }
    }
}
namespace SharpGLTF.Geometry.VertexTypes
{
    public struct VertexPosition
    {
        public VertexPosition(Vector3 position) { }
    }
}
namespace SharpGLTF.Geometry
{
    public struct VertexBuilder<TvG>
    {
        public static implicit operator VertexBuilder<TvG>(TvG geometry) { throw new NotSupportedException(); }
    }
    public class PrimitiveBuilder<TvG>
    {
        public (int A, int B, int C) AddTriangle(VertexBuilder<TvG> a, VertexBuilder<TvG> b, VertexBuilder<TvG> c) { throw new NotSupportedException(); }
    }
    public class MeshBuilder<TvG>
    {
        public MeshBuilder(string name) { }
        public PrimitiveBuilder<TvG> UsePrimitive(Materials.MaterialBuilder material) { throw new NotSupportedException(); }
    }
}
namespace SharpGLTF.Schema2
{
    public class Accessor
    {
        public IReadOnlyList<Vector3> AsVector3Array() { throw new NotSupportedException(); }
    }
    public class MeshPrimitive
    {
        public Accessor GetVertexAccessor(string name) { throw new NotSupportedException(); }
    }
    public class Mesh
    {
        public IReadOnlyList<MeshPrimitive> Primitives { get { throw new NotSupportedException(); } }
    }
    public class ModelRoot
    {
        public IReadOnlyList<Mesh> LogicalMeshes { get { throw new NotSupportedException(); } }
        public void SaveGLB(string file) { throw new NotSupportedException(); }
    }
    public static class Toolkit
    {
        public static IEnumerable<(int A, int B, int C)> GetTriangleIndices(this MeshPrimitive primitive) { throw new NotSupportedException(); }
    }
}
namespace SharpGLTF.Scenes
{
    public class SceneBuilder
    {
        public void AddRigidMesh<TvG>(Geometry.MeshBuilder<TvG> mesh, Matrix4x4 transform) { throw new NotSupportedException(); }
        public Schema2.ModelRoot ToGltf2() { throw new NotSupportedException(); }
    }
}
