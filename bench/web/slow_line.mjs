// A server whose responses with assets have a number of Mbit/s together, and a page that waits for scripts of its caller.
import { createServer } from 'node:http';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { modules_folder, package_folder } from '../../tests/web/load.mjs';

const kTickMs = 5;
const kTypes = { '.js': 'text/javascript', '.wasm': 'application/wasm', '.glb': 'model/gltf-binary' };
const kImports = { three: '/modules/three/build/three.module.js', 'three/addons/': '/modules/three/examples/jsm/' };
const kPage = `<!doctype html><meta charset="utf-8"><script type="importmap">${JSON.stringify({ imports: kImports })}</script>`;

// Sends bodies such that all together have `mbits`: each tick, they share what the time allows.
class SlowLine {
  #bodies = new Set();
  constructor(mbits) {
    let last = performance.now();
    setInterval(() => {
      const now = performance.now(), bytes = (mbits * 1e6 / 8) * ((now - last) / 1000) / Math.max(1, this.#bodies.size);
      last = now;
      for (const body of this.#bodies) body.step(bytes);
    }, kTickMs).unref();
  }
  send(response, bytes) {
    let at = 0, allowed = 0;
    const body = { step: (more) => {
      const end = Math.min(bytes.length, Math.floor(allowed += more));
      if (end > at) response.write(bytes.subarray(at, end));
      if ((at = end) < bytes.length) return;
      response.end();
      this.#bodies.delete(body);
    } };
    this.#bodies.add(body);
    response.on('close', () => this.#bodies.delete(body));
  }
}

// `files` by path; those named in `brotli` are in brotli. Returns the origin and close().
export async function serve(files, mbits, brotli = []) {
  const line = new SlowLine(mbits), folders = { '/psplit/': package_folder, '/modules/': path.join(modules_folder, 'node_modules') };
  const server = createServer((request, response) => {
    const { pathname } = new URL(request.url, 'http://localhost'), type = { 'Content-Type': kTypes[path.extname(pathname)] ?? 'text/html' };
    if (pathname === '/') return response.writeHead(200, type).end(kPage);
    if (pathname === '/favicon.ico') return response.writeHead(200).end();
    const prefix = Object.keys(folders).find((name) => pathname.startsWith(name));
    if (prefix !== undefined) return response.writeHead(200, type).end(readFileSync(path.join(folders[prefix], pathname.slice(prefix.length))));
    const bytes = files[pathname];
    if (brotli.includes(pathname)) type['Content-Encoding'] = 'br';
    response.writeHead(200, { ...type, 'Content-Length': bytes.length });
    line.send(response, bytes);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { origin: `http://127.0.0.1:${server.address().port}`, close: () => server.close() && server.closeAllConnections() };
}
