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

// Bytes of a response that does not end.
export async function* endless(bytes) {
  yield bytes;
  await new Promise(() => {});
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

// Bytes of a file as a server answers that sends ranges: { status, headers, body }. `range`: [begin, end), or null.
export function part_of_file(bytes, range, tag = '"1"') {
  const headers = { ETag: tag, 'Accept-Ranges': 'bytes' };
  if (range === null) return { status: 200, headers, body: bytes };
  const [begin, end] = [range[0], Math.min(range[1], bytes.length)];
  if (begin >= end) return { status: 416, headers: { ...headers, 'Content-Range': `bytes */${bytes.length}` }, body: '' };
  return { status: 206, headers: { ...headers, 'Content-Range': `bytes ${begin}-${end - 1}/${bytes.length}` }, body: bytes.subarray(begin, end) };
}

// Starts a server. answer(path, range, headers) returns or resolves to what part_of_file returns, whose body may also be chunks
// that come slowly. Returns its origin; `asked`, the ranges in the order of their requests; `sent`, a function that returns how
// many bytes bodies had; and the paths of the responses that are `open`. It ends with the tests of this process.
export async function serve_ranges(answer) {
  const asked = [], open = [];
  let sent = 0;
  const server = createServer(async ({ url, headers: given }, response) => {
    const numbers = /^bytes=(\d+)-(\d+)$/.exec(given.range ?? ''), range = numbers && [Number(numbers[1]), Number(numbers[2]) + 1];
    asked.push(range);
    open.push(url);
    response.on('close', () => open.splice(open.indexOf(url), 1));
    const { status, headers, body } = await answer(url, range, given);
    response.writeHead(status, headers);
    for await (const chunk of typeof body[Symbol.asyncIterator] === 'function' ? body : [body]) {
      if (response.destroyed) return;
      sent += chunk.length;
      response.write(chunk);
    }
    response.end();
  });
  after(() => {
    server.close();
    server.closeAllConnections();
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { origin: `http://127.0.0.1:${server.address().port}`, asked, open, sent: () => sent };
}
