"""Read and write files safely: kinds of files, encodings, documents, locks and checksums."""
