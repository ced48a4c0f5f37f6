// Bytes that arrive slowly: from a stream, and from a server.
import { createServer } from 'node:http';
import { after } from 'node:test';

export const wait_ms = (time) => new Promise((resolve) => setTimeout(resolve, time));

// Chunks of next_length() bytes, each after a pause in milliseconds if there is one.
export async function* in_chunks(bytes, next_length, pause) {
  for (let at = 0, end; at < bytes.length; at = end) {
    end = at + next_length();
    if (pause !== undefined) await wait_ms(pause);
    yield bytes.slice(at, end);
  }
}

// Starts a server of `files`: functions that return chunks, by path. Returns its origin, and the paths whose responses are
// `open` and `done`. It ends with the tests of this process.
export async function serve_slowly(files) {
  const open = new Set(), done = new Set();
  const server = createServer(async ({ url }, response) => {
    response.writeHead(files[url] === undefined ? 404 : 200, { 'Access-Control-Allow-Origin': '*' });
    open.add(url);
    response.on('close', () => open.delete(url));
    for await (const chunk of files[url]?.() ?? []) {
      if (!open.has(url)) return;
      response.write(chunk);
    }
    done.add(url);
    response.end();
  });
  after(() => {
    server.close();
    server.closeAllConnections();
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { origin: `http://127.0.0.1:${server.address().port}`, open, done };
}
