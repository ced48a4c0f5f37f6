// Decodes a Draco stream and a container of patches in a pool of workers, encodes one anew in another worker, and draws all.
import { createPool } from 'psplit';
import { createEncoder } from 'psplit/encode';

const pool = createPool(), encoder = createEncoder();
const fetch_bytes = async (url) => (await fetch(url)).arrayBuffer();
const stream = fetch_bytes(new URL('./stream.drc', import.meta.url));
const container = fetch_bytes(new URL('./container.bin', import.meta.url));
// A glTF file has these facts in the primitive and its accessors.
const attributes = [{ name: 'POSITION', uniqueId: 0, type: 'float32', componentCount: 3 }];

// Draws the triangles, seen from above.
function draw(name, { faceCount, pointCount, indices, attributes: [{ array: positions }] }) {
  const figure = document.body.appendChild(document.createElement('figure'));
  const canvas = figure.appendChild(document.createElement('canvas')), context = canvas.getContext('2d');
  figure.append(`${name}: ${faceCount} faces, ${pointCount} points`);
  [canvas.width, canvas.height] = [400, 400];
  const [low, high] = [positions.reduce((a, b) => Math.min(a, b)), positions.reduce((a, b) => Math.max(a, b))];
  const place = (point, axis) => 10 + 380 * (positions[3 * point + axis] - low) / (high - low);
  for (let face = 0; face < faceCount; ++face) {
    const [a, b, c] = indices.subarray(3 * face, 3 * face + 3);
    context.moveTo(place(a, 0), place(a, 1));
    for (const point of [b, c, a]) context.lineTo(place(point, 0), place(point, 1));
  }
  context.stroke();
}

try {
  const mesh = await pool.decodeDraco(await stream);
  draw('Draco stream', mesh);
  draw('Container', await pool.decodeContainer(await container, { attributes }));
  const [{ array, componentCount }] = mesh.attributes;
  const encoded = await encoder.encodeMesh({ indices: mesh.indices, attributes: { POSITION: { array, componentCount } } });
  draw('Encoded anew', await pool.decodeContainer(encoded.container, { attributes: encoded.attributes }));
} catch (error) {
  document.body.append(`${error.name} (${error.code}): ${error.message}`);
} finally {
  pool.dispose();
  encoder.dispose();
}
document.body.dataset.done = '';
