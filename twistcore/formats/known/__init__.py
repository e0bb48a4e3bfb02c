"""The formats that clips come in, one file each: what its file names is one."""
