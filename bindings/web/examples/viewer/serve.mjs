// Serves the built viewer on this machine:  node bindings/web/examples/viewer/serve.mjs [PORT]
import { createReadStream, existsSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const folder = fileURLToPath(new URL('../../../../build/web/viewer/', import.meta.url));
const kTypes = { '.html': 'text/html; charset=utf-8', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml',
  '.wasm': 'application/wasm', '.glb': 'model/gltf-binary' };
// Models that are dropped have addresses of the kinds blob: and data:.
export const headers = { 'Cache-Control': 'no-cache', 'X-Content-Type-Options': 'nosniff',
  'Content-Security-Policy': "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; " +
    "img-src 'self' blob: data:; connect-src 'self' blob: data:; base-uri 'none'; form-action 'none'" };

export const server = createServer((request, response) => {
  const url = new URL(request.url, 'http://localhost').pathname;  // no name has escapes
  const file = path.join(folder, url.endsWith('/') ? `${url}index.html` : url);
  if (!file.startsWith(folder) || !existsSync(file) || !statSync(file).isFile()) return response.writeHead(404, headers).end();
  response.writeHead(200, { ...headers, 'Content-Type': kTypes[path.extname(file)] ?? 'application/octet-stream' });
  createReadStream(file).pipe(response);
});

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const port = Number(process.argv[2] ?? 8080);
  server.listen(port, '127.0.0.1', () => console.log(`http://127.0.0.1:${server.address().port}/`));
}
