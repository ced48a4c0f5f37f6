// Draws the first mesh in patches of a GLB: its compressed bytes go to the GPU, and what comes out is drawn. WebGPU alone, no library.
import { createGpuDecoder } from 'psplit/webgpu';

const kCode = `
  struct View { center: vec3f, scale: f32 }
  struct Corner { @builtin(position) place: vec4f, @location(0) at: vec3f }
  @group(0) @binding(0) var<uniform> view: View;
  @vertex fn vertex(@location(0) position: vec3f) -> Corner {
    let at = (position - view.center) * view.scale;
    return Corner(vec4f(at.xy, 0.5 - 0.5 * at.z, 1), at);
  }
  @fragment fn fragment(@location(0) at: vec3f) -> @location(0) vec4f {
    let normal = normalize(cross(dpdx(at), dpdy(at)));
    return vec4f(vec3f(0.2 + 0.8 * abs(normal.z)), 1);
  }`;

/** The bytes of the first primitive in patches, and its POSITION. */
export function container_of(glb) {
  const view = new DataView(glb), json_bytes = view.getUint32(12, true);
  const json = JSON.parse(new TextDecoder().decode(new Uint8Array(glb, 20, json_bytes)));
  const primitive = json.meshes.flatMap(({ primitives }) => primitives).find(({ extensions }) => extensions?.PSPLIT_mesh_draco_patches);
  const { bufferView, attributes } = primitive.extensions.PSPLIT_mesh_draco_patches, { byteOffset = 0, byteLength } = json.bufferViews[bufferView];
  return { bytes: new Uint8Array(glb, 28 + json_bytes + byteOffset, byteLength),
    attributes: [{ name: 'POSITION', uniqueId: attributes.POSITION, type: 'float32', componentCount: 3 }] };
}

/** Draws to a texture, such as a canvas's. @param {ArrayBuffer} glb @param {object} [options] of createGpuDecoder */
export async function draw(device, glb, { format, texture_of }, options) {
  const { bytes, attributes } = container_of(glb), decoder = await createGpuDecoder(device, options);
  const mesh = await decoder.decode(bytes, { attributes }), [positions] = mesh.attributes;
  const { min, max } = positions.min ? positions : bounds_of(await mesh.read());
  const size = Math.max(...max.map((high, k) => high - min[k]));

  const module = device.createShaderModule({ code: kCode });
  const pipeline = await device.createRenderPipelineAsync({ layout: 'auto', primitive: { topology: 'triangle-list' },
    vertex: { module, buffers: [{ arrayStride: positions.stride, attributes: [{ shaderLocation: 0, offset: 0, format: 'float32x3' }] }] },
    fragment: { module, targets: [{ format }] }, depthStencil: { format: 'depth24plus', depthWriteEnabled: true, depthCompare: 'less' } });
  const uniform = device.createBuffer({ size: 16, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
  device.queue.writeBuffer(uniform, 0, Float32Array.of(...min.map((low, k) => (low + max[k]) / 2), 1.8 / size));
  const texture = texture_of();   // of a canvas, for this task only
  const depth = device.createTexture({ size: [texture.width, texture.height], format: 'depth24plus', usage: GPUTextureUsage.RENDER_ATTACHMENT });

  const encoder = device.createCommandEncoder(), pass = encoder.beginRenderPass({
    colorAttachments: [{ view: texture.createView(), loadOp: 'clear', storeOp: 'store', clearValue: { r: 0, g: 0, b: 0.2, a: 1 } }],
    depthStencilAttachment: { view: depth.createView(), depthLoadOp: 'clear', depthStoreOp: 'discard', depthClearValue: 1 } });
  pass.setPipeline(pipeline);
  pass.setBindGroup(0, device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries: [{ binding: 0, resource: { buffer: uniform } }] }));
  pass.setIndexBuffer(mesh.indices.buffer, mesh.indices.format);
  pass.setVertexBuffer(0, positions.buffer);
  pass.drawIndexed(mesh.indices.count);
  pass.end();
  device.queue.submit([encoder.finish()]);
  return mesh;
}

// Where WebAssembly decoded, there are no bounds.
function bounds_of({ attributes: [{ array }] }) {
  const min = [Infinity, Infinity, Infinity], max = [-Infinity, -Infinity, -Infinity];
  for (const [i, value] of array.entries()) min[i % 3] = Math.min(min[i % 3], value), max[i % 3] = Math.max(max[i % 3], value);
  return { min, max };
}
