"""Safe reading and writing of files, with file kinds, text encodings, documents, locks and
checksums.
"""
