// Whether this browser keeps files for the page, which all its workers see. Over plain http and in some private windows there are none: then
// what is recorded is in the memory of one worker.

export const keepsFiles = async (): Promise<boolean> => {
  try {
    await navigator.storage.getDirectory();
    return true;
  } catch {
    return false;
  }
};
