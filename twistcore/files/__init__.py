"""Safe reading and writing of files: kinds, text encodings, documents, locks and checksums."""
