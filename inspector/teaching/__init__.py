"""The teaching tab and its gizmo in the 3D view, which explain section 3 of [Choi26]."""
