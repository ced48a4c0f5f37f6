// What decoding rejects with.
export class PsplitError extends Error {
  /**
   * @param {string} message
   * @param {'invalid-input' | 'unsupported' | 'out-of-memory' | 'aborted' | 'failed'} code
   * @param {number} [patch] the number of the patch in its container; undefined if the error is not one patch's
   */
  constructor(message, code, patch) {
    super(patch === undefined ? message : `patch ${patch}: ${message}`);
    this.name = 'PsplitError';
    this.code = code;
    this.patch = patch;
  }
}

// Malformed JSON makes JavaScript throw in many places.
export const as_psplit_error = (error) => (error instanceof PsplitError ? error
  : new PsplitError(`the asset is malformed: ${error.message ?? error}`, 'invalid-input'));

// Errors as data, which a worker posts.
export const error_to_data = (error) =>
  ({ message: error.message, code: error.code ?? 'failed', patch: error.patch });
export function error_from_data({ message, code, patch }) {
  const error = new PsplitError(message, code);
  error.patch = patch;
  return error;
}
