"""Safe reading and writing of files: file kinds, text encodings, documents, locks and checksums."""
