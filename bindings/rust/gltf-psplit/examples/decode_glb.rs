//! decode_glb FILE: decodes all compressed meshes of a .glb file at once, and prints them. With a .drc file it prints that.

use gltf_psplit::{decode_meshes, Buffers, Gltf, Mesh, Run};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).ok_or("usage: decode_glb FILE")?;
    let bytes = std::fs::read(file)?;
    let meshes: Vec<Mesh> = if bytes.starts_with(b"DRACO") {
        vec![Mesh::open_draco_file(&bytes)?]
    } else {
        let gltf = Gltf::open(&bytes)?;
        let places = gltf.compressed_primitives();
        places
            .iter()
            .map(|&(mesh, primitive)| gltf.open_primitive(mesh, primitive))
            .collect::<Result<_, _>>()?
    };

    // Memory for indices and positions of all meshes, as an engine has it.
    let mut indices: Vec<Vec<u32>> =
        meshes.iter().map(|mesh| vec![0; 3 * mesh.info().face_count as usize]).collect();
    let mut positions: Vec<Vec<f32>> =
        meshes.iter().map(|mesh| vec![0.0; 3 * mesh.info().point_count as usize]).collect();
    let mut jobs = Vec::new();
    for ((mesh, indices), positions) in meshes.iter().zip(&mut indices).zip(&mut positions) {
        let mut buffers = Buffers::new(mesh)?;
        buffers.indices_u32(indices);
        if let Some(position) = mesh.find_name("POSITION") {
            buffers.attribute(position, positions)?;
        }
        jobs.push((mesh, buffers));
    }
    decode_meshes(&mut jobs, &Run::default()).into_iter().collect::<Result<Vec<()>, _>>()?;
    drop(jobs);

    for (mesh, positions) in meshes.iter().zip(&positions) {
        let info = mesh.info();
        let names: Vec<String> = mesh.attributes()?.into_iter().map(|attribute| attribute.name).collect();
        print!("{} triangles, {} points: {}", info.face_count, info.point_count, names.join(" "));
        match positions.get(..3) {
            Some(first) => println!(" from ({}, {}, {})", first[0], first[1], first[2]),
            None => println!(),
        }
    }
    Ok(())
}
