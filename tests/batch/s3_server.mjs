// An S3 server on the loopback, with the bucket "bucket":  s3_server.mjs FOLDER
// Prints its port. Its keys are S3RVER and S3RVER.
import S3rver from 's3rver';

const server = new S3rver({
  address: '127.0.0.1', port: 0, silent: true, directory: process.argv[2], configureBuckets: [{ name: 'bucket' }],
});
console.log((await server.run()).port);
